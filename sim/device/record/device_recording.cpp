#include "sim/device/record/device_recording.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <iterator>

#include "geometry/base/atomic_file.h"
#include "geometry/base/text.h"

namespace kerf {
namespace {

class Lines {
 public:
  Lines(std::string_view text, const std::string& file) : rest_(text), file_(file) {}
  // The next one that is neither empty nor a comment. False: the end.
  bool next() {
    while (!rest_.empty()) {
      const std::size_t end = rest_.find('\n');
      line_ = rest_.substr(0, end);
      rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
      ++number_;
      if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
      if (!line_.empty() && line_.front() != '#') return true;
    }
    return false;
  }
  std::string_view line() const { return line_; }
  tl::unexpected<Error> refuse(std::string found, std::string expected,
                               Error::Code code = Error::Code::kBadFormat) const {
    return fail({.code = code,
                 .file = file_,
                 .place = fmt::format("line {}", number_),
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .hint = "record it again with kerf devices --record"});
  }
  // Up to the next blank.
  std::string_view word() {
    const std::size_t end = line_.find(' ');
    const std::string_view out = line_.substr(0, end);
    line_.remove_prefix(end == std::string_view::npos ? line_.size() : end + 1);
    return out;
  }

 private:
  std::string_view rest_, line_;
  const std::string& file_;
  int number_ = 0;
};

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text.substr(0, 40)) out += c >= 0x20 && c < 0x7F ? c : '?';
  return out + "\"";
}

template <class Number>
bool parseAll(std::string_view word, Number& out, int base = 10) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out, base);
  return error == std::errc() && end == word.data() + word.size() && !word.empty();
}

Expected<void> parseHead(Lines& lines, DeviceRecording& out) {
  if (!lines.next() || lines.word() != "kerf-device") return lines.refuse("something else", "\"kerf-device 1\"");
  int version = 0;
  if (!parseAll(lines.line(), version) || version < 1) return lines.refuse(quoted(lines.line()), "version 1");
  if (version != 1)
    return lines.refuse(fmt::format("version {}", version), "version 1, the only one this Kerf reads",
                        Error::Code::kUnsupported);

  if (!lines.next() || lines.word() != "driver") return lines.refuse("something else", "\"driver NAME\"");
  const DeviceDriver* const driver = findDriver(lines.line());
  if (driver && driver->axes) out.driver = driver;
  if (findTakeHand(lines.line())) out.arm = std::string(lines.line());
  if (!out.driver && out.arm.empty())
    return lines.refuse("the driver " + quoted(lines.line()), "a driver of this Kerf", Error::Code::kUnsupported);

  if (!lines.next() || lines.word() != "device")
    return lines.refuse("something else", "\"device VENDOR:PRODUCT NAME\"");
  out.device = std::string(lines.line());
  return {};
}

// Interface, then bytes.
Expected<void> parseBytes(Lines& lines, int& interface, std::vector<std::uint8_t>& bytes) {
  const std::string_view number = lines.word();
  if (!parseAll(number, interface)) return lines.refuse(quoted(number), "the number of an interface");
  while (!lines.line().empty()) {
    const std::string_view byte = lines.word();
    std::uint8_t value = 0;
    if (byte.size() != 2 || !parseAll(byte, value, 16))
      return lines.refuse(quoted(byte), "a byte of two digits, 00 to ff");
    if (bytes.size() == DeviceRecording::kLongestReport)
      return lines.refuse("more bytes", fmt::format("at most {}", DeviceRecording::kLongestReport));
    bytes.push_back(value);
  }
  if (bytes.empty()) return lines.refuse("no bytes", "at least one");
  return {};
}

Expected<RecordedReport> parseReport(Lines& lines, std::int64_t not_before) {
  RecordedReport out;
  const std::string_view time = lines.word();
  if (!parseAll(time, out.time_us) || out.time_us < 0 || out.time_us > DeviceRecording::kLongestUs)
    return lines.refuse(quoted(time), "us since the first report, whole, of a year at most");
  if (out.time_us < not_before)
    return lines.refuse(fmt::format("{} us after {} us", out.time_us, not_before), "times that do not decrease");
  KERF_CHECK(parseBytes(lines, out.interface, out.bytes));
  return out;
}

// One ns more than recorded: a time of zero means no data.
std::int64_t clockOf(const RecordedReport& report) { return 1000 * report.time_us + 1; }

}  // namespace

Expected<DeviceRecording> parseRecording(std::string_view text, const std::string& file) {
  Lines lines(text, file);
  DeviceRecording out;
  KERF_CHECK(parseHead(lines, out));
  std::int64_t not_before = 0;
  while (lines.next()) {
    KERF_TRY(report, parseReport(lines, not_before));
    not_before = report.time_us;
    out.reports.push_back(std::move(report));
  }
  return out;
}

Expected<DeviceRecording> readRecording(const std::filesystem::path& file) {
  auto text = readSmallFile(file, DeviceRecording::kLargestFile);
  if (text) return parseRecording(*text, file.string());
  text.error().hint = "make one with kerf devices --record";
  return fail(std::move(text).error());
}

Expected<void> writeRecording(const std::filesystem::path& file, const DeviceRecording& recording) {
  KERF_TRY(out, AtomicFile::create(file));
  const std::string driver = recording.driver ? recording.driver->id : recording.arm;
  out.stream() << fmt::format("kerf-device 1\ndriver {}\ndevice {}\n", driver, recording.device);
  for (const RecordedReport& report : recording.reports)
    out.stream() << fmt::format("{} {} {:02x}\n", report.time_us, report.interface, fmt::join(report.bytes, " "));
  return out.commit();
}

std::vector<DeviceReading> replayRecording(const DeviceRecording& recording) {
  std::vector<DeviceReading> out;
  if (!recording.driver) return out;
  DeviceReading reading;
  for (const RecordedReport& report : recording.reports) {
    takeReport(*recording.driver, report.bytes, clockOf(report), reading);
    out.push_back(reading);
  }
  return out;
}

RecordedHands replayHands(const DeviceRecording& recording) {
  RecordedHands out;
  TakeHand* const take = findTakeHand(recording.arm);
  if (!take) return out;
  HandFrame hand;
  for (const RecordedReport& report : recording.reports) {
    if (take(report.bytes, hand) == FrameFault::kNone)
      out.hands.push_back({report.time_us, hand});
    else
      ++out.refused;
  }
  return out;
}

void DeviceTape::add(std::int64_t time_ns, int interface, std::span<const std::uint8_t> report) {
  if (last_ns_ != 0) gaps_.add(time_ns - last_ns_);
  last_ns_ = time_ns;
  if (!keeps_reports_) return;

  constexpr std::size_t kOfAByte = 3, kOfALine = 40;  // characters, at most
  const std::size_t size = kOfALine + kOfAByte * report.size();
  constexpr std::size_t kHead = 1 << 20;  // the lines before the reports
  const bool is_full = kHead + size_ + size > DeviceRecording::kLargestFile;
  if (report.empty() || report.size() > DeviceRecording::kLongestReport || is_full) {
    ++lost_;
    return;
  }
  if (recording_.reports.empty()) first_ns_ = time_ns;
  size_ += size;
  recording_.reports.push_back({(time_ns - first_ns_) / 1000, interface, {report.begin(), report.end()}});
}

}  // namespace kerf
