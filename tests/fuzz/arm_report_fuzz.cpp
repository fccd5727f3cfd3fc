// Reports of arms on HID, with their lengths before them, for each driver; the same bytes as lines of a serial arm.
#include "sim/device/arm_driver.h"
#include "sim/device/raw_arm.h"
#include "sim/device/serial_arm.h"
#include "tests/fuzz/harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kerf;
  for (const ArmDriver* driver : armDrivers()) {
    ArmState state;
    for (std::size_t at = 0; at < size;) {
      const std::size_t length = std::min<std::size_t>(data[at], size - at - 1);
      const ArmState before = state;
      const FrameFault fault = driver->take({data + at + 1, length}, state);
      at += 1 + length;
      fuzz::require(state.hand.pose.isUsable(), "a pose that is taken can be computed with");
      fuzz::require(state.jacobian.allFinite(), "torques are finite");
      if (fault != FrameFault::kNone)
        fuzz::require(state.hand.pose.translation == before.hand.pose.translation && state.counts == before.counts,
                      "nothing of a malformed report is used");
      ForceFrame force;
      force.is_enabled = true;
      force.force = {1e3, -1e3, 1e-3};
      ArmReportBytes out{};
      const std::size_t written = driver->write(force, state, {}, out);
      fuzz::require(written > 0 && written <= out.size(), "a report fits");
    }
  }
  ForceFrame read;
  if (decodeRawForce({data, size}, read) == FrameFault::kNone)
    fuzz::require(read.force.allFinite() && read.torque.allFinite(), "forces are finite");
  SerialLine line;
  (void)parseSerialLine({reinterpret_cast<const char*>(data), size}, line);
  return 0;
}
