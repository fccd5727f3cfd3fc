#include "sim/session/session_log.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <new>

#include "sim/session/session_format.h"

namespace kerf {
namespace {

using namespace internal;

// Reads one log. Each checksum continues the previous one. This detects omitted, doubled or swapped records as well as
// flipped bits.
class Parser {
 public:
  Parser(std::span<const std::byte> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  Expected<SessionLog> parse() {
    KERF_CHECK(header());
    if (version_ == kOldestLogVersion)
      log_.samples.reserve(left() / kSampleBytes);  // upper bound; unused memory is never touched
    while (at_ < bytes_.size() && !log_.damage) KERF_CHECK(record());
    return std::move(log_);
  }

 private:
  std::size_t left() const { return bytes_.size() - at_; }

  tl::unexpected<Error> refuse(Error::Code code, std::size_t at, std::string found, std::string expected,
                               std::string hint) const {
    return fail({.code = code,
                 .file = name_,
                 .place = fmt::format("byte {}", at),
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .hint = std::move(hint)});
  }
  tl::unexpected<Error> badHeader(std::size_t at, std::string found) const {
    return refuse(Error::Code::kBadFormat, at, std::move(found), "the whole header of a session log",
                  "no replay is possible without it; use a copy of the log, if there is one");
  }
  Expected<void> stop(LogDamage::Kind kind, std::string what) {
    log_.damage = LogDamage{kind, at_, left(), std::move(what)};
    return {};
  }
  Expected<void> damaged(std::string what) { return stop(LogDamage::Kind::kDamaged, std::move(what)); }

  // Whether the checksum at `at` is right for the bytes since the previous one.
  bool agrees(std::span<const std::byte> read, std::size_t at) {
    checksum_ = checksum(checksum_, read);
    return ByteUnpacker(bytes_.data() + at).u32() == checksum_;
  }

  // Magic, version, length; then pairs of texts; then a checksum of it all.
  Expected<void> header() {
    KERF_TRY(length, fileHead());
    const std::size_t end = kFileHead + length;
    if (!agrees(bytes_.first(end), end)) return badHeader(end, "a wrong checksum");

    for (at_ = kFileHead; at_ < end;) {
      KERF_TRY(key, headerText(end));
      KERF_TRY(value, headerText(end));
      log_.header.emplace_back(std::move(key), std::move(value));
    }
    at_ = end + kChecksum;
    return {};
  }

  // The length of the header's texts, after checking that header and checksum are complete.
  Expected<std::size_t> fileHead() {
    const std::size_t start = std::min(bytes_.size(), kLogMagic.size());
    if (start == 0 || std::memcmp(bytes_.data(), kLogMagic.data(), start) != 0)
      return refuse(Error::Code::kBadFormat, 0, start == 0 ? "an empty file" : "another kind of file",
                    "a session log (it begins with KERFLOG)", "name a log that Kerf recorded");
    if (bytes_.size() < kFileHead) return badHeader(bytes_.size(), "the end of the file");

    ByteUnpacker head(bytes_.data() + kLogMagic.size());
    version_ = head.u32();
    const std::uint32_t length = head.u32();
    if (version_ < kOldestLogVersion || version_ > kLogVersion)
      return refuse(Error::Code::kUnsupported, kLogMagic.size(), fmt::format("a session log of version {}", version_),
                    fmt::format("version {} or {}", kOldestLogVersion, kLogVersion),
                    version_ > kLogVersion ? "read it with the newer Kerf that recorded it" : "copy the file again");
    if (left() - kFileHead < kChecksum || left() - kFileHead - kChecksum < length)
      return badHeader(bytes_.size(), fmt::format("the end of the file, {} bytes of header missing",
                                                  kFileHead + length + kChecksum - bytes_.size()));
    return length;
  }

  // The text at at_, of a header that ends at `end`.
  Expected<std::string> headerText(std::size_t end) {
    const std::size_t most = end - at_;
    const std::size_t size = most < 4 ? 0 : ByteUnpacker(bytes_.data() + at_).u32();
    if (most < 4 || size > most - 4) return badHeader(at_, "a text longer than the header");
    std::string text(reinterpret_cast<const char*>(bytes_.data() + at_ + 4), size);
    at_ += 4 + size;
    return text;
  }

  Expected<void> record() {
    if (log_.is_closed) return damaged("bytes after the end of the session");

    // Head: kind, length, tick.
    if (left() < kRecordHead) return stop(LogDamage::Kind::kCutShort, "the head of a record is incomplete");
    ByteUnpacker head(bytes_.data() + at_);
    const std::uint32_t kind = head.u32();
    const std::uint32_t length = head.u32();
    const std::uint64_t tick = head.u64();
    if (!agrees(bytes_.subspan(at_, kRecordHead - kChecksum), at_ + kRecordHead - kChecksum))
      return damaged("the checksum of a record's head is wrong");

    // Payload.
    const std::size_t begin = at_ + kRecordHead;
    if (bytes_.size() - begin < kChecksum || bytes_.size() - begin - kChecksum < length)
      return stop(LogDamage::Kind::kCutShort,
                  fmt::format("{} bytes of a record of {} are missing", begin + length + kChecksum - bytes_.size(),
                              kRecordHead + length + kChecksum));
    const auto payload = bytes_.subspan(begin, length);
    if (!agrees(payload, begin + length)) return damaged("the checksum of a record is wrong");

    // The record is intact: errors from here on were written so, they are no damage.
    if (!take(kind, tick, payload)) {
      if (has_too_many_)
        return refuse(Error::Code::kBadValue, at_,
                      fmt::format("more than {} samples in a file of {} bytes", mostSamples(), bytes_.size()),
                      fmt::format("{} MiB of samples at most, and {} bytes more for each byte of the file",
                                  kSampleMemory >> 20, kSampleMemoryPerByte),
                      "Kerf's recorder packs no session so tightly: do not trust this log");
      if (kind > lastKind() && (kind & kMaySkip) == 0)
        return refuse(Error::Code::kUnsupported, at_, fmt::format("a record of kind {}", kind),
                      fmt::format("kinds 1 to {}, or one that may be skipped", lastKind()),
                      "read it with the newer Kerf that recorded it");
      return refuse(Error::Code::kBadFormat, at_,
                    fmt::format("a record of kind {}, tick {}, with {} invalid bytes", kind, tick, length),
                    "a record as in docs/reference/file-formats.md", "Kerf did not write this log");
    }
    at_ = begin + length + kChecksum;
    return {};
  }

  template <class T>
  bool event(std::uint64_t tick, T what) {
    log_.events.push_back({tick, log_.samples.size(), std::move(what)});
    return true;
  }

  // False: an unknown or invalid record.
  bool take(std::uint32_t kind, std::uint64_t tick, std::span<const std::byte> payload) {
    ByteUnpacker in(payload.data());
    switch (kind) {
      case kSamplesRecord:
        return samples(tick, payload);
      case kCommandRecord:
        return event(tick, SessionCommand{{reinterpret_cast<const char*>(payload.data()), payload.size()}});
      case kCheckRecord:
        return payload.size() == kCheckBytes && event(tick, unpackCheck(payload.data()));
      case kSnapshotRecord:
        if (payload.size() < 8) return false;
        return event(tick, SessionSnapshot{in.u64(), {payload.begin() + 8, payload.end()}});
      case kStrokeRecord: {
        const std::uint32_t mark = payload.size() == 4 ? in.u32() : 2;
        return mark <= 1 && event(tick, static_cast<StrokeMark>(mark));
      }
      case kGapRecord:
        return payload.size() == 8 && event(tick, SessionGap{in.u64()});
      case kEndRecord:
        log_.is_closed = payload.empty();
        return log_.is_closed;
      case kPackedSamplesRecord:
        return version_ > kOldestLogVersion && packedSamples(tick, payload);
      default:
        log_.skipped += (kind & kMaySkip) != 0;
        return (kind & kMaySkip) != 0;
    }
  }

  std::uint32_t lastKind() const { return version_ > kOldestLogVersion ? kPackedSamplesRecord : kEndRecord; }

  bool mayFollow(std::uint64_t first_tick, std::size_t count) const {
    if (count == 0 || first_tick + (count - 1) < first_tick) return false;
    return log_.samples.empty() || first_tick > log_.samples.back().tick;
  }

  std::uint64_t mostSamples() const {
    return (kSampleMemory + kSampleMemoryPerByte * bytes_.size()) / sizeof(TimedSample);
  }

  bool packedSamples(std::uint64_t first_tick, std::span<const std::byte> payload) {
    numbers_.clear();
    if (!unpackSamples(payload, history_, numbers_) || !mayFollow(first_tick, numbers_.size())) return false;
    has_too_many_ = log_.samples.size() + numbers_.size() > mostSamples();
    if (has_too_many_) return false;
    for (std::size_t i = 0; i < numbers_.size(); ++i) log_.samples.push_back({first_tick + i, sampleOf(numbers_[i])});
    return true;
  }

  bool samples(std::uint64_t first_tick, std::span<const std::byte> payload) {
    const std::size_t count = payload.size() / kSampleBytes;
    if (payload.size() % kSampleBytes != 0 || !mayFollow(first_tick, count)) return false;
    for (std::size_t i = 0; i < count; ++i)
      log_.samples.push_back({first_tick + i, unpackSample(payload.data() + i * kSampleBytes)});
    return true;
  }

  std::span<const std::byte> bytes_;
  const std::string& name_;
  std::size_t at_ = 0;  // the first byte not yet used
  std::uint32_t version_ = 0;
  SampleHistory history_;            // of packed samples
  std::vector<SampleBits> numbers_;  // of one record
  bool has_too_many_ = false;        // samples for the size of the file
  std::uint32_t checksum_ = 0;
  SessionLog log_;
};

}  // namespace

std::uint32_t internal::checksum(std::uint32_t so_far, std::span<const std::byte> bytes) {
  if (bytes.empty()) return so_far;  // zlib takes a null pointer for the wish to start again
  return static_cast<std::uint32_t>(::crc32_z(so_far, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string_view SessionLog::value(std::string_view key) const {
  for (const auto& [name, text] : header)
    if (name == key) return text;
  return {};
}

Expected<SessionLog> parseSessionLog(std::span<const std::byte> bytes, const std::string& name) {
  return Parser(bytes, name).parse();
}

Expected<SessionLog> readSessionLog(const std::filesystem::path& path) {
  std::error_code error;
  const auto refuse = [&](Error::Code code, std::string found) {
    return fail({.code = code,
                 .file = path.string(),
                 .place = "file",
                 .found = std::move(found),
                 .expected = "a session log",
                 .hint = "check the path and its permissions"});
  };
  if (!std::filesystem::exists(path, error)) return refuse(Error::Code::kNotFound, "no such file");
  if (!std::filesystem::is_regular_file(path, error))
    return refuse(Error::Code::kUnreadable, "not a regular file");  // a pipe or a device would never end

  const std::uintmax_t size = std::filesystem::file_size(path, error);
  std::ifstream in(path, std::ios::binary);
  if (error || !in) return refuse(Error::Code::kUnreadable, std::string("cannot be opened: ") + std::strerror(errno));

  try {
    std::vector<std::byte> bytes(size);
    in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    if (in.bad()) return refuse(Error::Code::kUnreadable, std::string("cannot be read: ") + std::strerror(errno));
    return parseSessionLog(std::span(bytes).first(static_cast<std::size_t>(in.gcount())), path.string());
  } catch (const std::bad_alloc&) {
    return refuse(Error::Code::kUnreadable, fmt::format("{} bytes and their contents do not fit into memory", size));
  }
}

Expected<SessionSnapshot> packSnapshot(std::span<const std::byte> bytes) {
  if (bytes.size() > kMaxSnapshotBytes)
    return fail({.code = Error::Code::kBadValue,
                 .file = "",
                 .place = "snapshot",
                 .found = fmt::format("{} bytes", bytes.size()),
                 .expected = fmt::format("at most {}", kMaxSnapshotBytes),
                 .hint = "keep only what changed"});

  try {
    uLongf size = ::compressBound(bytes.size());
    SessionSnapshot snapshot{bytes.size(), std::vector<std::byte>(size)};
    if (::compress2(reinterpret_cast<Bytef*>(snapshot.packed.data()), &size,
                    reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), Z_BEST_SPEED) != Z_OK)
      throw std::bad_alloc();  // the only possible reason: level and size of the buffer are right
    snapshot.packed.resize(size);
    return snapshot;
  } catch (const std::bad_alloc&) {
    return fail({.code = Error::Code::kWriteFailed,
                 .file = "",
                 .place = "snapshot",
                 .found = fmt::format("no memory to compress {} bytes", bytes.size()),
                 .expected = "",
                 .hint = "close other programs"});
  }
}

Expected<std::vector<std::byte>> unpackSnapshot(const SessionSnapshot& snapshot) {
  const auto refuse = [&](std::string found) {
    return fail({.code = Error::Code::kBadFormat,
                 .file = "",
                 .place = "snapshot",
                 .found = std::move(found),
                 .expected = fmt::format("{} bytes, packed by zlib, at most {}", snapshot.size, kMaxSnapshotBytes),
                 .hint = "start the replay from an earlier snapshot"});
  };
  constexpr std::uint64_t kBestRatio = 1032;  // of deflate (zlib's technical notes): a larger claim is false
  if (snapshot.size > kMaxSnapshotBytes || snapshot.size / kBestRatio > snapshot.packed.size())
    return refuse(fmt::format("{} bytes that claim to hold {}", snapshot.packed.size(), snapshot.size));

  try {
    std::vector<std::byte> bytes(snapshot.size);
    std::byte nothing{};  // zlib wants an address even for no bytes
    uLongf size = bytes.size();
    uLong used = snapshot.packed.size();
    const int result = ::uncompress2(reinterpret_cast<Bytef*>(bytes.empty() ? &nothing : bytes.data()), &size,
                                     reinterpret_cast<const Bytef*>(snapshot.packed.data()), &used);
    if (result != Z_OK || size != bytes.size() || used != snapshot.packed.size())
      return refuse("bytes that do not unpack to that");
    return bytes;
  } catch (const std::bad_alloc&) {
    return refuse("more than there is memory for");
  }
}

}  // namespace kerf
