// Records a session while it runs: takes what the haptic thread hands over without making it wait. One thread writes
// the log, and prints commands for it; another one syncs, so that a slow disk does not hold up the writing.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "sim/session/command.h"
#include "sim/session/session_log.h"

namespace kerf {

/// What became of one thing to be recorded.
enum class RecordStatus : std::uint8_t {
  kRecorded,   ///< taken; it is in the file within RecorderOptions::write_every
  kQueueFull,  ///< lost: the disk is slower than the session. Counted, and a SessionGap stands in its place
  kFailed,     ///< lost: the file has failed or is closed; RecorderStatus::error says why. Counted
  kRefused     ///< lost: a sample whose tick is not later than the last one's. Counted, and a SessionGap stands there
};

struct RecorderOptions {
  /// Samples, commands, checks and marks that may wait for the disk; each takes 176 bytes, allocated once. 8192 is
  /// eight seconds of samples. Too few and a slow disk makes gaps.
  std::size_t queue_capacity = 8192;
  /// How long what was recorded stays in memory: that much is lost when the program is killed. Well below it, a write
  /// holds no more than a few samples.
  std::chrono::milliseconds write_every{50};
  /// How long what was written may miss from the disk itself: that much, a write and the sync are lost when the power
  /// fails. Every sync costs the disk a few milliseconds.
  std::chrono::milliseconds sync_every{200};
};

struct RecorderStatus {
  std::uint64_t recorded = 0;       ///< entries taken
  std::uint64_t lost = 0;           ///< entries not taken; with an error also those of the write that failed and after
  std::uint64_t bytes_written = 0;  ///< handed to the system: they survive the end of the program
  std::uint64_t bytes_synced = 0;   ///< on the disk: they survive a power failure
  std::optional<Error> error;       ///< why the file failed, such as a full disk. Nothing is recorded after it
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
  /// As close(), but an error is lost.
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

  /// Writes what waits and the mark of a clean end, syncs, ends the threads. The error is the first one of the whole
  /// recording; entries lost to a full queue are no error here, status() counts them. Call it once, from the haptic
  /// thread or when that one records no more.
  Expected<void> close();

 private:
  struct State;
  explicit SessionRecorder(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
