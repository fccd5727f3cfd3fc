// What a HID device says of its reports: the fields of each, where their bits are, and what they mean. By the USB
// device class definition for HID 1.11, chapter 6.2.2. Functions of their arguments alone.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

enum class HidReportKind { kInput, kOutput, kFeature };

/// Usage page in the upper half, usage in the lower one.
using HidUsage = std::uint32_t;

struct HidField {
  HidReportKind kind = HidReportKind::kInput;
  std::uint8_t report = 0;            ///< its number; 0: reports have none
  std::vector<HidUsage> usages;       ///< one a value, the last one for all that are left; of an array: by its index
  std::vector<HidUsage> collections;  ///< that it is in, the outermost first
  bool is_array = false;              ///< a value is the 1-based place of a usage, counted from logical_min
  bool is_constant = false;           ///< padding
  std::int32_t logical_min = 0, logical_max = 0;
  std::int32_t physical_min = 0, physical_max = 0;
  int unit_exponent = 0;
  std::uint32_t bit = 0;    ///< where it begins in the report, behind its number
  std::uint32_t bits = 0;   ///< of one value
  std::uint32_t count = 0;  ///< of values
};

struct HidLayout {
  std::vector<HidField> fields;
  /// Of a report, with its number if reports have one; 0: there is none.
  std::size_t bytesOf(HidReportKind kind, std::uint8_t report) const;
  bool has_numbers = false;
};

/// Errors: kBadFormat with the byte: cut short, more collections ended than begun, fields larger than a report can be.
/// Items that are not known are left out.
Expected<HidLayout> parseHidDescriptor(std::span<const std::uint8_t> descriptor);
/// Of an open device's node, from the system: /sys/class/hidraw. Errors: kUnreadable, kNotFound.
Expected<std::vector<std::uint8_t>> readHidDescriptor(const std::string& path);

/// Writes a value into a report that has its number first, if `has_number`; what does not fit is the nearest that does.
void putHidValue(std::span<std::uint8_t> report, bool has_number, const HidField& field, std::uint32_t n,
                 std::int64_t value) noexcept;
/// 0 beyond the report.
std::int64_t getHidValue(std::span<const std::uint8_t> report, bool has_number, const HidField& field,
                         std::uint32_t n) noexcept;

}  // namespace kerf
