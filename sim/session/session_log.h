// The session log: the loaded data and all later events. The state of a session is a function of this file: replay,
// undo, recovery after a crash and scoring read it. Byte by byte in docs/reference/file-formats.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "geometry/base/error.h"
#include "sim/session/packed_samples.h"
#include "sim/step/device_sample.h"

namespace kerf {

/// Loaded data: case and its hashes, tools, settings, program version. In order; keys may repeat.
using SessionHeader = std::vector<std::pair<std::string, std::string>>;

/// A command as text, such as `tool.select 0`; takes effect before the sample of its tick. The log keeps any text:
/// parseCommand() (sim/session/command.h) interprets it for this version.
struct SessionCommand {
  std::string text;
};
/// Check of the state after its tick: a replay that differs reveals a difference in program or machine.
struct StateCheck {
  std::uint64_t state_hash = 0;
  Wrench force;  ///< sent to the hand in that tick, N and N mm
};
/// State after its tick, from which a replay can start: packState(), compressed.
struct SessionSnapshot {
  std::uint64_t size = 0;         ///< of the bytes, before compression
  std::vector<std::byte> packed;  ///< by zlib; unpackSnapshot() checks and returns the bytes
};
enum class StrokeMark : std::uint32_t { kBegin = 0, kEnd = 1 };  ///< borders of an undo step
/// Samples, commands or checks missing here, because the recorder's queue was full.
struct SessionGap {
  std::uint64_t lost = 0;
};

/// Largest snapshot, bytes; writer and reader reject larger ones.
inline constexpr std::uint64_t kMaxSnapshotBytes = std::uint64_t{1} << 30;

/// Memory for the samples of a log: so many bytes, and so many more for each byte of its file. A hand at rest packs to
/// next to nothing, so a small file can state that it holds millions of samples. SessionRecorder's samples take 140
/// bytes a byte of file at most; a `kerf cut` along a path reaches the limit after an hour without a motion.
inline constexpr std::uint64_t kSampleMemory = std::uint64_t{256} << 20, kSampleMemoryPerByte = 160;

struct TimedSample {
  std::uint64_t tick = 0;
  DeviceSample sample;
};
struct SessionEvent {
  std::uint64_t tick = 0;
  std::size_t samples_before = 0;  ///< stands before SessionLog::samples[samples_before]
  std::variant<SessionCommand, StateCheck, SessionSnapshot, StrokeMark, SessionGap> what;
};

/// Where reading stopped before the end of the file. All bytes before that are intact.
struct LogDamage {
  enum class Kind {
    kCutShort,  ///< the last record is incomplete: the program was killed, or the disk was full
    kDamaged    ///< bytes changed since they were written
  };
  Kind kind = Kind::kCutShort;
  std::uint64_t at_byte = 0;     ///< start of the first unusable record
  std::uint64_t lost_bytes = 0;  ///< from there to the end of the file
  std::string what;              ///< a sentence
};

struct SessionLog {
  SessionHeader header;
  std::vector<TimedSample> samples;  ///< ticks strictly increasing; gaps are lost samples (SessionGap)
  std::vector<SessionEvent> events;  ///< in the order they were recorded
  bool is_closed = false;            ///< ended properly
  std::optional<LogDamage> damage;   ///< none: every byte was read
  std::size_t skipped = 0;           ///< records of kinds this version may skip

  /// First value of a key; empty if there is none.
  std::string_view value(std::string_view key) const;
};

/// Reads a whole log into memory: 88 bytes a sample, an hour takes 320 MB and a second or two. Reads a cut-off or
/// damaged log up to the last whole record before that place, and reports it in `damage`. Lengths in the file are
/// claims: reading allocates only memory that the file's size covers; samples are packed, and bound by kSampleMemory.
/// Reads logs of older versions as well.
/// Errors name file and byte: no session log, a damaged or incomplete header, a newer version (kUnsupported), an
/// unknown kind of record that must not be skipped, more samples than its size allows.
Expected<SessionLog> readSessionLog(const std::filesystem::path& path);
/// The same for bytes in memory; `name` stands for the file in errors.
Expected<SessionLog> parseSessionLog(std::span<const std::byte> bytes, const std::string& name);

/// The bytes of a snapshot. Errors: it does not unpack to exactly `size` bytes, or is larger than kMaxSnapshotBytes.
/// Its record's checksum was right, so such a log was not written by Kerf.
Expected<std::vector<std::byte>> unpackSnapshot(const SessionSnapshot& snapshot);
/// zlib, level 1: 100 MB/s or so. For the thread with the bytes, never the haptic one. kBadValue above the maximum.
Expected<SessionSnapshot> packSnapshot(std::span<const std::byte> bytes);

/// Writes a log, record by record. Collects records in memory until write(). Not for several threads at once, and not
/// for the haptic one: SessionRecorder stands in between.
class SessionLogWriter {
 public:
  /// Makes the file, which must not exist, with its header, and syncs it and its folder to the disk.
  static Expected<SessionLogWriter> create(const std::filesystem::path& path, const SessionHeader& header);

  SessionLogWriter(SessionLogWriter&& other) noexcept;
  SessionLogWriter& operator=(SessionLogWriter&&) = delete;
  /// Without close(): like a killed program.
  ~SessionLogWriter();

  /// Consecutive samples; the first has tick `first_tick`, > the last one's.
  void addSamples(std::uint64_t first_tick, std::span<const DeviceSample> samples);
  /// The same, each as packed by pack() of sim/session/session_format.h. Compresses: 50 samples in about 50 us.
  void addSampleBytes(std::uint64_t first_tick, std::span<const std::byte> samples);
  void add(std::uint64_t tick, const SessionCommand& command);
  void add(std::uint64_t tick, const StateCheck& check);
  void add(std::uint64_t tick, const SessionSnapshot& snapshot);
  void add(std::uint64_t tick, StrokeMark mark);
  void add(std::uint64_t tick, const SessionGap& gap);
  /// A raw record of the file; see sim/session/session_format.h.
  void addRecord(std::uint32_t kind, std::uint64_t tick, std::span<const std::byte> payload);

  /// Hands all records so far to the system: they survive the end of the program. After an error (disk full) the file
  /// ends with the last whole record that fitted, and every further call returns that error.
  Expected<void> write();
  /// Waits until the written bytes are on the disk (fdatasync): they survive a power failure. Keeps an error like
  /// write().
  Expected<void> sync();
  /// The same for a thread of its own, while another one adds and writes: a slow disk holds up this thread alone. It
  /// keeps no error, and bytesSynced() does not count it. Not during close().
  Expected<void> syncAside() const;
  /// Writes all records and the mark of a clean end, syncs and closes.
  Expected<void> close(std::uint64_t last_tick);

  std::uint64_t bytesWritten() const { return written_; }  ///< handed to the system, whole records
  std::uint64_t bytesSynced() const { return synced_; }

 private:
  SessionLogWriter(int fd, std::string file) : fd_(fd), file_(std::move(file)) {}
  tl::unexpected<Error> failed(const char* step, int reason);

  int fd_ = -1;
  std::string file_;
  std::vector<std::byte> pending_;        // records not yet written
  std::vector<std::size_t> record_ends_;  // in pending_
  std::uint32_t checksum_ = 0;            // of the whole log so far
  internal::SampleHistory history_;       // of the samples so far
  std::uint64_t written_ = 0;
  std::uint64_t synced_ = 0;
  std::optional<Error> error_;
};

}  // namespace kerf
