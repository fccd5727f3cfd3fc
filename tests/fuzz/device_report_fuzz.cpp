// Reports of devices: a number of reports with their lengths before them, for each driver.
#include <cmath>

#include "sim/device/device_driver.h"
#include "tests/fuzz/harness.h"

namespace {

// A stick, a slider of the page of simulation, a hat, ten buttons and a battery, in two numbered reports.
constexpr std::uint8_t kDescriptor[] = {
    0x05, 0x01, 0x09, 0x04, 0xA1, 0x01, 0x85, 0x01, 0x09, 0x30, 0x09, 0x31, 0x16, 0x00, 0x80, 0x26, 0xFF,
    0x7F, 0x75, 0x10, 0x95, 0x02, 0x81, 0x02, 0x05, 0x02, 0x09, 0xC4, 0x15, 0x00, 0x26, 0xFF, 0x03, 0x75,
    0x0A, 0x95, 0x01, 0x81, 0x02, 0x05, 0x01, 0x09, 0x39, 0x15, 0x01, 0x25, 0x08, 0x75, 0x04, 0x81, 0x42,
    0x05, 0x09, 0x19, 0x01, 0x29, 0x0A, 0x15, 0x00, 0x25, 0x01, 0x75, 0x01, 0x95, 0x0A, 0x81, 0x02, 0x85,
    0x02, 0x05, 0x06, 0x09, 0x20, 0x26, 0xFF, 0x00, 0x75, 0x08, 0x95, 0x01, 0x81, 0x02, 0xC0};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const kerf::HidLayout layout = *kerf::parseHidDescriptor(kDescriptor);
  for (const kerf::DeviceDriver* driver : kerf::deviceDrivers()) {
    kerf::DeviceReading reading;
    std::uint64_t count = 0;
    for (std::size_t at = 0; at < size; ++count) {
      const std::size_t length = std::min<std::size_t>(data[at] % 80, size - at - 1);
      const kerf::DeviceReading before = reading;
      const auto kind = kerf::takeReport(*driver, {data + at + 1, length}, 1, reading, layout);
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
