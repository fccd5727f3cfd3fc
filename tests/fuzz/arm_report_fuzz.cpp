// Reports of HID arms with length prefixes, for each driver.
#include "sim/device/arm/raw_arm.h"
#include "sim/device/hid/device_driver.h"
#include "tests/fuzz/harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kerf;
  for (const DeviceDriver* driver : deviceDrivers()) {
    if (!driver->arm) continue;
    HandFrame hand;
    for (std::size_t at = 0; at < size;) {
      const std::size_t length = std::min<std::size_t>(data[at], size - at - 1);
      const HandFrame before = hand;
      const FrameFault fault = driver->arm->take({data + at + 1, length}, hand);
      at += 1 + length;
      fuzz::require(hand.pose.isUsable(), "a pose that is taken can be computed with");
      if (fault != FrameFault::kNone)
        fuzz::require(hand.pose.translation == before.pose.translation && hand.number == before.number,
                      "nothing of a malformed report is used");
    }
    ForceFrame force;
    force.is_enabled = true;
    force.force = {1e3, -1e3, 1e-3};
    ArmReportBytes out{};
    const std::size_t written = driver->arm->write(force, out);
    fuzz::require(written > 0 && written <= out.size(), "a report fits");
  }
  ForceFrame read;
  if (decodeRawForce({data, size}, read) == FrameFault::kNone)
    fuzz::require(read.force.allFinite() && read.torque.allFinite(), "forces are finite");
  return 0;
}
