// Datagrams from and to a bridge.
#include "sim/device/frame/device_frame.h"
#include "tests/fuzz/harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kerf;
  HandFrame hand;
  if (decode({data, size}, hand) == FrameFault::kNone) {
    fuzz::require(hand.pose.isUsable(), "a pose that is taken can be computed with");
    fuzz::require(hand.velocity.allFinite() && hand.angular.allFinite(), "speeds are finite");
    fuzz::require(hand.most_force >= 0 && hand.most_stiffness >= 0, "limits are not negative");
    HandFrame again;
    fuzz::require(decode(encode(hand), again) == FrameFault::kNone && again.number == hand.number,
                  "what was read can be written and read");
  }
  ForceFrame force;
  if (decode({data, size}, force) == FrameFault::kNone)
    fuzz::require(force.force.allFinite() && force.torque.allFinite(), "forces are finite");
  return 0;
}
