// Device reports with length prefixes, for each driver of a device with axes.
#include <cmath>

#include "sim/device/hid/device_driver.h"
#include "tests/fuzz/harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  for (const kerf::DeviceDriver* driver : kerf::deviceDrivers()) {
    if (!driver->axes) continue;
    kerf::DeviceReading reading;
    std::uint64_t count = 0;
    for (std::size_t at = 0; at < size; ++count) {
      const std::size_t length = std::min<std::size_t>(data[at] % 80, size - at - 1);
      const kerf::DeviceReading before = reading;
      const auto kind = kerf::takeReport(*driver, {data + at + 1, length}, 1, reading);
      at += 1 + length;
      for (const double axis : reading.axes) kerf::fuzz::require(std::abs(axis) <= 1, "axes are -1 to 1");
      if (kind == kerf::ReportKind::kMalformed)
        kerf::fuzz::require(reading.axes == before.axes && reading.buttons == before.buttons &&
                                reading.battery_percent == before.battery_percent,
                            "nothing of a malformed report is used");
    }
    kerf::fuzz::require(reading.reports + reading.unknown + reading.malformed == count, "each report is counted once");
  }
  return 0;
}
