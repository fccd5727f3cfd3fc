// Descriptors of HID devices, and what reports of force feedback are made of them.
#include "sim/device/pid_device.h"
#include "tests/fuzz/harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kerf;
  auto layout = parseHidDescriptor({data, size});
  if (!layout) return 0;
  constexpr std::size_t kMostBytes = 4097;
  for (const HidField& field : layout->fields) {
    fuzz::require(layout->bytesOf(field.kind, field.report) <= kMostBytes, "reports are bounded");
    std::vector<std::uint8_t> report(layout->bytesOf(field.kind, field.report));
    const bool has_number = layout->has_numbers;
    putHidValue(report, has_number, field, 0, field.logical_max);
    const bool is_whole = field.bits > 0 && field.bits < 32 && field.count > 0 && field.logical_min >= 0 &&
                          field.logical_max > field.logical_min &&
                          std::int64_t{field.logical_max} < (std::int64_t{1} << field.bits);
    if (is_whole)
      fuzz::require(getHidValue(report, has_number, field, 0) == field.logical_max, "what was put can be got");
  }
  const auto pid = PidReports::of(std::move(*layout));
  if (!pid) return 0;
  for (const auto& report : {pid->control(PidControl::kReset), pid->create(PidEffect::kSine),
                             pid->set(PidEffect::kConstant, 1, 1), pid->constant(1, -1), pid->damper(2, 1, 1),
                             pid->sine(3, 1, 50), pid->operate(1, PidOperation::kStop), pid->free(1)})
    fuzz::require(!report.empty() && report.size() <= kMostBytes, "a report has a length");
  (void)pid->loadOf({data, size});
  return 0;
}
