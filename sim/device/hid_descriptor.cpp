#include "sim/device/hid_descriptor.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace kerf {
namespace {

constexpr std::uint32_t kMostBits = 8 * 4096;  // of a report
constexpr std::uint32_t kMostValues = 4096;    // of a field
constexpr std::size_t kMostUsages = 1024, kMostFields = 4096, kMostNesting = 32;

// Of global items; pushed and popped together.
struct Globals {
  std::uint32_t page = 0;
  std::int32_t logical_min = 0, logical_max = 0, physical_min = 0, physical_max = 0;
  int unit_exponent = 0;
  std::uint32_t bits = 0, count = 0;
  std::uint8_t report = 0;
};

std::uint32_t unsignedOf(std::span<const std::uint8_t> bytes) {
  std::uint32_t out = 0;
  for (std::size_t n = 0; n < bytes.size(); ++n) out |= std::uint32_t{bytes[n]} << (8 * n);
  return out;
}
std::int32_t signedOf(std::span<const std::uint8_t> bytes) {
  const std::uint32_t raw = unsignedOf(bytes);
  if (bytes.size() == 1) return static_cast<std::int8_t>(raw);
  if (bytes.size() == 2) return static_cast<std::int16_t>(raw);
  return static_cast<std::int32_t>(raw);
}

class Parser {
 public:
  explicit Parser(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  Expected<HidLayout> run() {
    while (at_ < bytes_.size()) {
      const std::uint8_t head = bytes_[at_];
      if (head == 0xFE) {
        KERF_CHECK(skipLong());
        continue;
      }
      const std::size_t size = (head & 3) == 3 ? 4 : head & 3;
      if (at_ + 1 + size > bytes_.size()) return wrong("an item that ends behind the descriptor", "all of it");
      const auto data = bytes_.subspan(at_ + 1, size);
      KERF_CHECK(take(head & 0xFC, data));
      at_ += 1 + size;
    }
    if (!collections_.empty()) return wrong("a collection that does not end", "one end each");
    return std::move(layout_);
  }

 private:
  tl::unexpected<Error> wrong(std::string found, std::string expected) const {
    return fail({.code = Error::Code::kBadFormat,
                 .place = fmt::format("HID descriptor, byte {}", at_),
                 .found = std::move(found),
                 .expected = std::move(expected)});
  }
  Expected<void> skipLong() {
    if (at_ + 3 > bytes_.size() || at_ + 3 + bytes_[at_ + 1] > bytes_.size())
      return wrong("a long item that ends behind the descriptor", "all of it");
    at_ += 3 + std::size_t{bytes_[at_ + 1]};
    return {};
  }

  Expected<void> take(std::uint8_t tag, std::span<const std::uint8_t> data) {
    switch (tag) {
      case 0x80:
        return addField(HidReportKind::kInput, unsignedOf(data));
      case 0x90:
        return addField(HidReportKind::kOutput, unsignedOf(data));
      case 0xB0:
        return addField(HidReportKind::kFeature, unsignedOf(data));
      case 0xA0:
        return begin();
      case 0xC0:
        return end();
      default:
        break;
    }
    const bool is_local = (tag & 0x0C) == 0x08;
    if ((tag & 0x0C) == 0x04) return takeGlobal(tag, data);
    if (is_local) return takeLocal(tag, data);
    return {};
  }

  Expected<void> takeGlobal(std::uint8_t tag, std::span<const std::uint8_t> data) {
    const std::uint32_t value = unsignedOf(data);
    switch (tag) {
      case 0x04:
        now_.page = value & 0xFFFF;
        break;
      case 0x14:
        now_.logical_min = signedOf(data);
        break;
      case 0x24:
        // Many write an unsigned largest value where a signed one is meant.
        now_.logical_max = signedOf(data);
        if (now_.logical_max < now_.logical_min) now_.logical_max = static_cast<std::int32_t>(value & 0x7FFFFFFF);
        break;
      case 0x34:
        now_.physical_min = signedOf(data);
        break;
      case 0x44:
        now_.physical_max = signedOf(data);
        if (now_.physical_max < now_.physical_min) now_.physical_max = static_cast<std::int32_t>(value & 0x7FFFFFFF);
        break;
      case 0x54:
        now_.unit_exponent = static_cast<int>(value & 15) - ((value & 8) ? 16 : 0);
        break;
      case 0x74:
        if (value > 64) return wrong(fmt::format("values of {} bits", value), "at most 64");
        now_.bits = value;
        break;
      case 0x84:
        if (value == 0 || value > 255) return wrong(fmt::format("report number {}", value), "1 to 255");
        now_.report = static_cast<std::uint8_t>(value);
        layout_.has_numbers = true;
        break;
      case 0x94:
        if (value > kMostValues) return wrong(fmt::format("{} values", value), fmt::format("at most {}", kMostValues));
        now_.count = value;
        break;
      case 0xA4:
        if (pushed_.size() >= kMostNesting) return wrong("too many states pushed", "at most 32");
        pushed_.push_back(now_);
        break;
      case 0xB4:
        if (pushed_.empty()) return wrong("a pop without a push", "one of each");
        now_ = pushed_.back();
        pushed_.pop_back();
        break;
      default:
        break;
    }
    return {};
  }

  Expected<void> takeLocal(std::uint8_t tag, std::span<const std::uint8_t> data) {
    const std::uint32_t value = unsignedOf(data);
    const HidUsage usage = data.size() == 4 ? value : (now_.page << 16) | (value & 0xFFFF);
    if (tag == 0x08 && usages_.size() < kMostUsages) usages_.push_back(usage);
    if (tag == 0x18) first_ = usage;
    if (tag != 0x28 || !first_) return {};
    if (usage < *first_ || usage - *first_ >= kMostUsages) return wrong("a range of usages", "at most 1024 of them");
    for (HidUsage u = *first_; u <= usage && usages_.size() < kMostUsages; ++u) usages_.push_back(u);
    first_.reset();
    return {};
  }

  Expected<void> begin() {
    if (collections_.size() >= kMostNesting) return wrong("collections too deep in each other", "at most 32");
    collections_.push_back(usages_.empty() ? now_.page << 16 : usages_.front());
    forgetLocals();
    return {};
  }
  Expected<void> end() {
    if (collections_.empty()) return wrong("the end of a collection that did not begin", "one end each");
    collections_.pop_back();
    forgetLocals();
    return {};
  }
  void forgetLocals() {
    usages_.clear();
    first_.reset();
  }

  Expected<void> addField(HidReportKind kind, std::uint32_t flags) {
    std::uint32_t& used = used_[static_cast<std::size_t>(kind)][now_.report];
    const std::uint64_t size = std::uint64_t{now_.bits} * now_.count;
    if (used + size > kMostBits) return wrong("a report of more than 4096 bytes", "less");
    if (layout_.fields.size() >= kMostFields) return wrong("too many fields", "at most 4096");
    HidField field;
    field.kind = kind;
    field.report = now_.report;
    field.usages = usages_;
    field.collections = collections_;
    field.is_constant = flags & 1;
    field.is_array = !(flags & 2) && !field.is_constant;
    field.logical_min = now_.logical_min;
    field.logical_max = now_.logical_max;
    field.physical_min = now_.physical_min;
    field.physical_max = now_.physical_max;
    field.unit_exponent = now_.unit_exponent;
    field.bit = used;
    field.bits = now_.bits;
    field.count = now_.count;
    used += static_cast<std::uint32_t>(size);
    layout_.fields.push_back(std::move(field));
    forgetLocals();
    return {};
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  Globals now_;
  std::vector<Globals> pushed_;
  std::vector<HidUsage> usages_, collections_;
  std::optional<HidUsage> first_;
  std::uint32_t used_[3][256] = {};  // bits
  HidLayout layout_;
};

// The bits of a value; one that lies partly behind the report is none.
struct Place {
  std::size_t bit = 0;
  bool is_there = false;
};
Place placeOf(std::size_t bytes, bool has_number, const HidField& field, std::uint32_t n) {
  const std::size_t bit = (has_number ? 8 : 0) + field.bit + std::size_t{n} * field.bits;
  return {bit, n < field.count && bit + field.bits <= 8 * bytes};
}

}  // namespace

std::size_t HidLayout::bytesOf(HidReportKind kind, std::uint8_t report) const {
  std::size_t bits = 0;
  bool is_there = false;
  for (const HidField& field : fields) {
    if (field.kind != kind || field.report != report) continue;
    is_there = true;
    bits = std::max<std::size_t>(bits, field.bit + std::size_t{field.bits} * field.count);
  }
  return is_there ? (has_numbers ? 1 : 0) + (bits + 7) / 8 : 0;
}

Expected<HidLayout> parseHidDescriptor(std::span<const std::uint8_t> descriptor) { return Parser(descriptor).run(); }

Expected<std::vector<std::uint8_t>> readHidDescriptor(const std::string& path) {
  namespace fs = std::filesystem;
  const fs::path file = fs::path("/sys/class/hidraw") / fs::path(path).filename() / "device/report_descriptor";
  std::ifstream in(file, std::ios::binary);
  if (!in.is_open())
    return fail({.code = Error::Code::kUnreadable,
                 .file = file.string(),
                 .found = "it cannot be read",
                 .expected = "the descriptor of " + path,
                 .hint = "kerf devices lists what is plugged in"});
  return std::vector<std::uint8_t>(std::istreambuf_iterator<char>(in), {});
}

void putHidValue(std::span<std::uint8_t> report, bool has_number, const HidField& field, std::uint32_t n,
                 std::int64_t value) noexcept {
  const Place place = placeOf(report.size(), has_number, field, n);
  if (!place.is_there || field.bits == 0) return;
  if (field.logical_max > field.logical_min)
    value = std::clamp<std::int64_t>(value, field.logical_min, field.logical_max);
  const auto raw = static_cast<std::uint64_t>(value);
  for (std::uint32_t bit = 0; bit < field.bits; ++bit) {
    const std::size_t at = place.bit + bit;
    const auto mask = static_cast<std::uint8_t>(1U << (at % 8));
    const bool is_set = raw >> bit & 1;
    report[at / 8] = static_cast<std::uint8_t>(is_set ? report[at / 8] | mask : report[at / 8] & ~mask);
  }
}

std::int64_t getHidValue(std::span<const std::uint8_t> report, bool has_number, const HidField& field,
                         std::uint32_t n) noexcept {
  const Place place = placeOf(report.size(), has_number, field, n);
  if (!place.is_there || field.bits == 0) return 0;
  std::uint64_t raw = 0;
  for (std::uint32_t bit = 0; bit < field.bits; ++bit) {
    const std::size_t at = place.bit + bit;
    raw |= std::uint64_t{(report[at / 8] >> (at % 8)) & 1U} << bit;
  }
  const bool is_negative = field.logical_min < 0 && field.bits < 64 && (raw >> (field.bits - 1) & 1);
  if (is_negative) raw |= ~std::uint64_t{0} << field.bits;
  return static_cast<std::int64_t>(raw);
}

}  // namespace kerf
