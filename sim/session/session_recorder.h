// Records a running session from the haptic thread without making it wait. One thread writes the log, and prints
// commands for it; another one syncs, so that a slow disk does not hold up the writing.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "sim/session/command.h"
#include "sim/session/session_log.h"

namespace kerf {

/// Result of one call of record().
enum class RecordStatus : std::uint8_t {
  kRecorded,   ///< accepted; in the file within RecorderOptions::write_every
  kQueueFull,  ///< lost: the disk is slower than the session. Counted, and a SessionGap stands in its place
  kFailed,     ///< lost: the file has failed or is closed; RecorderStatus::error says why. Counted
  kRefused     ///< lost: a sample whose tick is not later than the last one's. Counted, and a SessionGap stands there
};

/// One record as the log holds it.
struct RecordedEntry {
  std::uint64_t tick = 0;
  std::variant<DeviceSample, Command, StateCheck, StrokeMark, SessionGap> what;
};

struct RecorderOptions {
  /// Samples, commands, checks and marks that may wait for the disk; each takes 448 bytes, allocated once. 8192 is
  /// eight seconds of samples. Too few and a slow disk makes gaps.
  std::size_t queue_capacity = 8192;
  /// Longest time in memory: a killed program loses that much. Well below it, a write holds no more than a few samples.
  std::chrono::milliseconds write_every{50};
  /// Longest time between write and sync: a power failure loses that much, a write and the sync. Every sync costs the
  /// disk a few milliseconds.
  std::chrono::milliseconds sync_every{200};
  /// Receives the records of each write, in their order, on the recording thread. May be empty.
  std::function<void(std::vector<RecordedEntry>)> on_written;
};

struct RecorderStatus {
  std::uint64_t recorded = 0;       ///< accepted entries
  std::uint64_t lost = 0;           ///< lost entries; with an error also those of the failed write and after
  std::uint64_t bytes_written = 0;  ///< handed to the system: they survive the end of the program
  std::uint64_t bytes_synced = 0;   ///< on the disk: they survive a power failure
  std::optional<Error> error;       ///< why the file failed, such as a full disk. Recording ends then
};

/// One session log being written. When the file fails (disk full, device gone), the log stays valid up to the last
/// whole record, recording ends, and status() and close() say so.
class SessionRecorder {
 public:
  /// Makes the log, which must not exist, and starts the threads.
  static Expected<SessionRecorder> start(const std::filesystem::path& path, const SessionHeader& header,
                                         const RecorderOptions& options = {});
  SessionRecorder(SessionRecorder&&) noexcept;
  SessionRecorder& operator=(SessionRecorder&&) = delete;
  /// Like close(), but an error is lost.
  ~SessionRecorder();

  // For one thread, the haptic one: no allocation, lock or system call. In the order in which they happen: commands
  // and marks of a tick, its sample, its check.

  /// @param tick  > that of the sample before.    @rt safe.
  RecordStatus record(const DeviceSample& sample, std::uint64_t tick) noexcept;
  /// @param tick  of the sample it comes before.    @rt safe.
  RecordStatus record(const Command& command, std::uint64_t tick) noexcept;
  RecordStatus record(StrokeMark mark, std::uint64_t tick) noexcept;
  /// @param tick  of the sample it comes after.    @rt safe.
  RecordStatus record(const StateCheck& check, std::uint64_t tick) noexcept;

  // For any other thread.

  RecorderStatus status() const;

  /// Writes the waiting entries and the mark of a clean end, syncs, ends the threads. Returns the first error of the
  /// whole recording; entries lost to a full queue are no error here, status() counts them. Call it once, from the
  /// haptic thread or when that one records no more.
  Expected<void> close();

 private:
  struct State;
  explicit SessionRecorder(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
