#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <limits>

#include "geometry/base/atomic_file.h"
#include "sim/session/session_format.h"
#include "sim/session/session_log.h"

namespace kerf {
namespace {

using namespace internal;
namespace fs = std::filesystem;

Error writeError(const std::string& file, const char* step, int reason) {
  std::string hint = "check the path and its permissions";
  if (reason == ENOSPC || reason == EDQUOT || reason == EFBIG)
    hint = "free some space; the log holds everything up to here";
  if (reason == ENOENT) hint = "make the folder first";
  if (reason == EEXIST) hint = "choose another name; a log is never overwritten";
  return {.code = Error::Code::kWriteFailed,
          .file = file,
          .place = step,
          .found = std::strerror(reason),
          .expected = "",
          .hint = hint};
}

void append(std::vector<std::byte>& to, std::span<const std::byte> bytes) {
  // Not insert(): g++ 12 warns of an impossible overflow in it.
  to.resize(to.size() + bytes.size());
  std::copy(bytes.begin(), bytes.end(), to.end() - static_cast<std::ptrdiff_t>(bytes.size()));
}
void append(std::vector<std::byte>& to, std::uint32_t value) {
  std::array<std::byte, 4> bytes;
  BytePacker(bytes.data()).u32(value);
  append(to, bytes);
}

}  // namespace

Expected<SessionLogWriter> SessionLogWriter::create(const fs::path& path, const SessionHeader& header) {
  std::vector<std::byte> text;
  for (const auto& [key, value] : header)
    for (const std::string& word : {key, value}) {
      append(text, static_cast<std::uint32_t>(word.size()));
      append(text, std::as_bytes(std::span(word)));
    }
  if (text.size() > std::numeric_limits<std::uint32_t>::max())
    return fail({.code = Error::Code::kBadValue,
                 .file = path.string(),
                 .place = "header",
                 .found = "more than 4 GiB of text",
                 .expected = "settings",
                 .hint = ""});

  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd < 0) return fail(writeError(path.string(), "making the log", errno));

  SessionLogWriter log(fd, path.string());
  append(log.pending_, std::as_bytes(std::span(kLogMagic)));
  append(log.pending_, kLogVersion);
  append(log.pending_, static_cast<std::uint32_t>(text.size()));
  append(log.pending_, text);
  log.checksum_ = checksum(0, log.pending_);
  append(log.pending_, log.checksum_);
  log.record_ends_.push_back(log.pending_.size());

  KERF_CHECK(log.write());
  KERF_CHECK(log.sync());
  KERF_CHECK(syncFolder(path.parent_path()));
  return log;
}

SessionLogWriter::SessionLogWriter(SessionLogWriter&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      file_(std::move(other.file_)),
      pending_(std::move(other.pending_)),
      record_ends_(std::move(other.record_ends_)),
      checksum_(other.checksum_),
      history_(other.history_),
      written_(other.written_),
      synced_(other.synced_),
      error_(std::move(other.error_)) {}

SessionLogWriter::~SessionLogWriter() {
  if (fd_ >= 0) ::close(fd_);
}

tl::unexpected<Error> SessionLogWriter::failed(const char* step, int reason) {
  error_ = writeError(file_, step, reason);
  return fail(*error_);
}

void SessionLogWriter::addRecord(std::uint32_t kind, std::uint64_t tick, std::span<const std::byte> payload) {
  assert(payload.size() <= std::numeric_limits<std::uint32_t>::max());
  if (error_) return;  // writing has ended: nothing is kept
  std::array<std::byte, kRecordHead - kChecksum> head;
  BytePacker(head.data()).u32(kind).u32(static_cast<std::uint32_t>(payload.size())).u64(tick);
  checksum_ = checksum(checksum_, head);
  append(pending_, head);
  append(pending_, checksum_);
  checksum_ = checksum(checksum_, payload);
  append(pending_, payload);
  append(pending_, checksum_);
  record_ends_.push_back(pending_.size());
}

void SessionLogWriter::addSamples(std::uint64_t first_tick, std::span<const DeviceSample> samples) {
  std::vector<std::byte> bytes(samples.size() * kSampleBytes);
  for (std::size_t i = 0; i < samples.size(); ++i)
    pack(samples[i], std::span<std::byte, kSampleBytes>(bytes.data() + i * kSampleBytes, kSampleBytes));
  addSampleBytes(first_tick, bytes);
}

void SessionLogWriter::addSampleBytes(std::uint64_t first_tick, std::span<const std::byte> samples) {
  const std::size_t count = samples.size() / kSampleBytes;
  std::vector<SampleBits> numbers(count);
  for (std::size_t i = 0; i < count; ++i) numbers[i] = bitsOfSample(samples.data() + i * kSampleBytes);
  for (std::size_t i = 0; i < count; i += kMostPackedSamples) {
    const std::size_t n = std::min(count - i, kMostPackedSamples);
    addRecord(kPackedSamplesRecord, first_tick + i, packSamples(std::span(numbers).subspan(i, n), history_));
  }
}

void SessionLogWriter::add(std::uint64_t tick, const SessionCommand& command) {
  addRecord(kCommandRecord, tick, std::as_bytes(std::span(command.text)));
}

void SessionLogWriter::add(std::uint64_t tick, const StateCheck& check) {
  std::array<std::byte, kCheckBytes> payload;
  pack(check, payload);
  addRecord(kCheckRecord, tick, payload);
}

void SessionLogWriter::add(std::uint64_t tick, const SessionSnapshot& snapshot) {
  std::vector<std::byte> payload(8);
  BytePacker(payload.data()).u64(snapshot.size);
  append(payload, snapshot.packed);
  addRecord(kSnapshotRecord, tick, payload);
}

void SessionLogWriter::add(std::uint64_t tick, StrokeMark mark) {
  std::array<std::byte, 4> payload;
  BytePacker(payload.data()).u32(static_cast<std::uint32_t>(mark));
  addRecord(kStrokeRecord, tick, payload);
}

void SessionLogWriter::add(std::uint64_t tick, const SessionGap& gap) {
  std::array<std::byte, 8> payload;
  BytePacker(payload.data()).u64(gap.lost);
  addRecord(kGapRecord, tick, payload);
}

Expected<void> SessionLogWriter::write() {
  if (error_) return fail(*error_);
  std::size_t done = 0;
  int reason = 0;
  while (done < pending_.size() && reason == 0) {
    const ssize_t n = ::write(fd_, pending_.data() + done, pending_.size() - done);
    if (n > 0)
      done += static_cast<std::size_t>(n);
    else if (n == 0 || errno != EINTR)
      reason = n == 0 ? EIO : errno;
  }

  const auto first_cut = std::upper_bound(record_ends_.begin(), record_ends_.end(), done);
  written_ += first_cut == record_ends_.begin() ? 0 : *(first_cut - 1);
  pending_.clear();
  record_ends_.clear();
  if (reason == 0) return {};
  // Cuts off an incomplete record. If that fails, readers stop before it.
  if (::ftruncate(fd_, static_cast<off_t>(written_)) != 0) errno = 0;
  return failed("writing the log", reason);
}

Expected<void> SessionLogWriter::sync() {
  if (error_) return fail(*error_);
  if (synced_ == written_) return {};
  if (auto done = syncAside(); !done) {
    error_ = done.error();
    return done;
  }
  synced_ = written_;
  return {};
}

Expected<void> SessionLogWriter::syncAside() const {
  if (::fdatasync(fd_) != 0) return fail(writeError(file_, "syncing the log to the disk", errno));
  return {};
}

Expected<void> SessionLogWriter::close(std::uint64_t last_tick) {
  addRecord(kEndRecord, last_tick, {});
  KERF_CHECK(write());
  KERF_CHECK(sync());
  if (::close(std::exchange(fd_, -1)) != 0) return failed("closing the log", errno);
  return {};
}

}  // namespace kerf
