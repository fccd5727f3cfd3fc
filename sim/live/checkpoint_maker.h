// Makes checkpoints of a running session, beside the 1 kHz thread.
//
//   HapticThread ──samples, commands──▶ SessionRecorder ──log──▶ session.kerflog
//                                             └──the same──▶ CheckpointMaker ──▶ checkpoint-*.kerfstate
//
// A thread of low priority replays the session a moment behind it, as recovery would, and writes the state that it has
// reached. So the 1 kHz thread gives nothing and waits for nothing, and a checkpoint equals a replay of the log. Each
// check of the log is compared: after a difference, or a gap in the log, there are no more checkpoints.
//
// Cost: that of a replay, 2 to 5 % of a core on average and up to a quarter during heavy cutting; the memory of a
// second session. A checkpoint is due when the replay since the last one took CheckpointOptions::replay_s of CPU time,
// so that is what recovery needs at most, and at least four times the cost of writing one.
//
// Disk: at most kMostFiles files and kMostBytes, except for the newest. They thin out towards the past, so that an undo
// in the rest of the log, which reaches back before the newest, finds an older one. Removed when the session ends.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "sim/session/session.h"
#include "sim/session/session_recorder.h"

namespace kerf {

struct CheckpointOptions {
  bool is_wanted = true;
  /// CPU seconds of replay between two checkpoints. Smaller: faster recovery, more writing.
  double replay_s = 1.5;
  /// Records that may wait, 300 B each: five minutes. When the machine is too slow for more, there are no more
  /// checkpoints.
  std::size_t most_waiting = 300'000;
  /// Bytes of undo steps above which the maker forgets them at a checkpoint. An undo that reaches behind that ends the
  /// checkpoints; recovery then uses the older ones, or the whole log.
  std::size_t most_history = std::size_t{256} << 20;
};

struct CheckpointStatus {
  std::uint64_t written = 0;
  std::uintmax_t last_bytes = 0;
  double write_s = 0, replay_s = 0;  ///< CPU seconds so far
  std::optional<std::string> ended;  ///< why there are no more checkpoints
};

class CheckpointMaker {
 public:
  static constexpr std::size_t kMostFiles = 8;
  static constexpr std::uintmax_t kMostBytes = std::uintmax_t{256} << 20;

  /// Like Session's constructor: the session at its beginning. Starts the thread.
  CheckpointMaker(std::filesystem::path run_folder, Model model, LoadedObjects loaded, const Rigid3& start,
                  const CheckpointOptions& options = {});
  ~CheckpointMaker();  ///< as stop()
  CheckpointMaker(const CheckpointMaker&) = delete;
  CheckpointMaker& operator=(const CheckpointMaker&) = delete;

  /// The next records: RecorderOptions::on_written. One thread. Does not wait.
  void add(std::vector<RecordedEntry> records);
  /// Ends the thread, at once. May be called again.
  void stop();
  CheckpointStatus status() const;

 private:
  void run();
  bool follow(const RecordedEntry& record);
  void write();
  void thinOut();
  void end(std::string why);

  const std::filesystem::path folder_;
  const CheckpointOptions options_;

  // The thread's.
  Model model_;
  LoadedObjects loaded_;
  Rigid3 start_;
  std::optional<Session> session_;
  std::size_t samples_ = 0, events_ = 0;
  StepOutput output_;
  struct File {
    std::uint64_t number = 0;
    std::filesystem::path path;
    std::uintmax_t bytes = 0;
  };
  std::vector<File> files_;  // newest first
  double last_write_s_ = 0;

  // Shared.
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::vector<RecordedEntry>> waiting_;
  std::size_t waiting_count_ = 0;
  bool is_stopping_ = false;
  CheckpointStatus status_;
  std::thread thread_;  // last
};

}  // namespace kerf
