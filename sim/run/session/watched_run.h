// Playback of an ended session: a thread replays its log, paced by the clock times a speed.
//
//   RUN/session.kerflog ──▶ LogPlayer ──bricks──▶ a MesherThread an object ──chunks──▶ window
//     play, pause, jump ──▶ (its thread)
//                               └──────newest moment──▶ moment(), as live reports
//
// Playback shows the cut bit for bit at any speed: a sample is ticked or it is not, and no tick differs from that of
// the session. Nothing is written.
//
// To go back, the thread replays the log without pictures from the last kept state, or from the beginning. States are
// kept in memory, at the beginnings of strokes. They do not know earlier undo steps: if an undo in the log reaches back
// before one, the replay starts from an earlier one.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "sim/live/haptic_thread.h"
#include "sim/live/live_heat.h"
#include "sim/live/mesher_thread.h"
#include "sim/live/scan_colours.h"
#include "sim/monitor/structures.h"
#include "sim/run/report/log_player.h"
#include "sim/run/session/live_run.h"

namespace kerf {

struct WatchOptions {
  MesherThreadOptions mesher;
  bool is_looked_at = false;  ///< chunks of the surface get colours and occlusion
  /// Most memory for kept states, bytes. Beyond it, every second one is dropped.
  std::size_t kept_bytes = std::size_t{256} << 20;
  /// Least simulated seconds between two kept states.
  double keep_every_s = 5;
};

/// A step in the log that a user may jump to.
struct WatchedStep {
  enum class Kind { kStroke, kMove, kPlaneCut, kDelete, kUndo, kRedo };
  Kind kind = Kind::kStroke;
  std::size_t begin = 0, end = 0;  ///< samples: after `end` ticked samples the log is right behind the step
  std::size_t tool = 0;            ///< in hand at its beginning
};

/// Whether the replay ended like the session.
struct WatchVerdict {
  bool is_same = false;
  bool is_whole = true;  ///< false: the log ends before its session did
  std::string text;      ///< a sentence
};

/// A moment of the session.
struct WatchMoment {
  HapticReport report;     ///< as in the session; counts: ticks, pauses (undo, jumps) and edits only;
                           ///< heat: if is_looked_at
  std::size_t sample = 0;  ///< number of ticked samples
  std::size_t steps = 0;   ///< number of finished steps()
  std::size_t tool = 0;    ///< in hand
  bool is_playing = false;
  bool is_jumping = false;  ///< replaying without pictures to the user's target
  double jump_share = 0;    ///< finished part of the jump, 0 to 1
  bool is_at_end = false;
  double speed = 1;                     ///< times that of the clock; kFastest: no pacing
  std::optional<WatchVerdict> verdict;  ///< at the end, or where the log cannot be replayed further
};

/// All calls from one thread.
class WatchedRun {
 public:
  /// Loads the run; paused at its beginning. May run on any thread, as a job.
  /// Errors: kUnsupported for a session that has not ended (kerf recover) and for a run without a log; those of
  /// loading; kCancelled.   @cost  as LiveRun::open().
  static Expected<std::unique_ptr<WatchedRun>> open(const std::filesystem::path& run_folder, WatchOptions options,
                                                    const Progress& progress = {});
  ~WatchedRun();
  WatchedRun(const WatchedRun&) = delete;
  WatchedRun& operator=(const WatchedRun&) = delete;

  const std::filesystem::path& folder() const noexcept { return folder_; }
  const std::filesystem::path& caseFolder() const noexcept { return recording_.cases.front(); }
  const RunManifest& manifest() const noexcept { return recording_.manifest; }
  std::span<const Tool> tools() const noexcept { return recording_.tools; }
  const Model& model() const noexcept { return recording_.model; }
  const BakedObject& object() const noexcept { return *recording_.objects.front(); }
  /// The loaded objects: the case, then its neighbours.
  std::span<const std::shared_ptr<const BakedObject>> objects() const noexcept { return recording_.objects; }
  /// The field of the case, before any cut.
  std::shared_ptr<const BrickField> original() const noexcept { return original_; }
  /// As in LiveRun.
  std::shared_ptr<const ScanColours> scanColours() const noexcept { return scan_colours_; }
  bool hasScanColours() const noexcept { return has_scan_colours_; }
  /// Pulp and nerve canals, as loaded; null unless options.is_looked_at.
  std::shared_ptr<const Structures> structures() const noexcept { return structures_; }
  /// Volume removed in the continued run, mm^3.
  double removedBefore() const noexcept { return removed_before_; }
  /// Labels of the pieces at the end, by CutObject::id; of the object itself if it stayed in one piece.
  PieceLabels labels() const;
  /// In the order of the log.
  std::span<const WatchedStep> steps() const noexcept { return steps_; }
  std::size_t samples() const noexcept { return recording_.log.samples.size(); }
  double seconds() const noexcept { return kTick * static_cast<double>(samples()); }

  // The thread executes requests some ms later. Playback continues after a jump.

  static constexpr double kFastest = 0, kLeastSpeed = 0.25, kMostSpeed = 16;
  /// No effect at the end.
  void play();
  void pause();
  /// @param speed  clamped to kLeastSpeed and kMostSpeed, or kFastest.
  void setSpeed(double speed);
  /// @param sample  clamped to samples(). Replaces a jump under way.
  void jumpTo(std::size_t sample);

  /// Fetches the newest moment; false: none since the last call.
  bool update();
  const WatchMoment& moment() const noexcept { return moment_; }
  /// Whether all requests except playing are done, and their moment is the newest one and meshed: the next takeChunks()
  /// has the rest of it.
  bool isSettled() const;

  /// Chunks that changed since the last call, object by object, as LiveRun::takeChunks().
  std::vector<ObjectChunks> takeChunks();
  std::uint64_t editsDone() const noexcept;
  /// The current scene, as LiveRun::viewScene().
  std::optional<SceneView> viewScene() const;

 private:
  WatchedRun(std::filesystem::path folder, WatchOptions options)
      : folder_(std::move(folder)), options_(std::move(options)) {}
  Expected<void> load(const Progress& progress);
  Expected<void> chooseColours();
  void findSteps();
  Expected<void> watchHeat(const Progress& progress);

  // The thread.
  struct Orders {
    std::uint64_t number = 0;  // of the last request
    bool is_playing = false, is_over = false;
    double speed = 1;
    std::optional<std::size_t> jump;
  };
  struct Kept {
    std::size_t sample = 0, event = 0;
    std::vector<std::byte> state;
    std::map<std::uint32_t, std::array<double, 256>> removed_before;  // per CutObject::id
    LiveHeat::Memory heat;
  };
  // Bricks sent to the mesher of an object.
  struct Told {
    std::shared_ptr<BrickFeed> feed;
    std::unordered_map<std::uint64_t, Vec3i> bricks;  // bricks that may differ from the mesher's start
    std::vector<Vec3i> again;                         // to be sent again
  };
  void run();
  Orders takeOrders();
  bool isOrdered() const;
  void follow(const Orders& orders);
  void playOn();
  void jump(std::size_t target);
  bool tick();
  const Kept* lastKept(std::size_t before) const;
  void startFrom(const Kept* kept);
  void keepState();
  void arrive();
  void stopPlaying();
  void stopWith(const Error& error);
  Told& toldOf(CutObject& object);
  void sendBricks();
  void publish();
  void restartClock();

  std::filesystem::path folder_;
  WatchOptions options_;
  internal::Recording recording_;
  std::string log_name_;
  Rigid3 place_;
  double removed_before_ = 0;
  std::vector<WatchedStep> steps_;
  std::vector<decltype(RemesherOptions::finish)> looks_;  // of recording_.objects, or empty
  std::shared_ptr<const BrickField> original_;
  std::shared_ptr<const ScanColours> scan_colours_;
  bool has_scan_colours_ = false;
  std::shared_ptr<const Structures> structures_;

  // The thread's.
  std::optional<internal::LogPlayer> player_;
  std::vector<Kept> kept_;                 // by rising samples
  std::optional<std::size_t> began_with_;  // sample of the player's start state
  std::uint64_t jumps_ = 0;
  std::unordered_map<std::uint32_t, Told> told_;
  StepOutput output_;
  std::unique_ptr<LiveHeat> heat_;  // null unless options_.is_looked_at
  LiveHeat::Memory cold_;           // at the beginning
  WatchMoment now_;
  std::chrono::steady_clock::time_point clock_from_{};
  std::size_t sample_from_ = 0;

  // Between the two; guarded by mutex_.
  mutable std::mutex mutex_;
  std::condition_variable ordered_;
  Orders orders_;
  std::uint64_t orders_done_ = 0;
  WatchMoment newest_;
  bool is_fresh_ = false;
  struct CameOff {
    std::shared_ptr<const PieceOrigin> origin;  // null: as loaded
    std::size_t loaded = 0;                     // index in recording_.objects
    std::uint32_t id = 0;
    std::shared_ptr<BrickFeed> feed;
  };
  std::vector<CameOff> came_off_;

  // The caller's.
  WatchMoment moment_;
  struct Shown {
    std::uint32_t id = 0;
    std::shared_ptr<BrickFeed> feed;  // outlives the mesher
    std::size_t loaded = 0;
    std::shared_ptr<MesherThread> mesher;
  };
  std::vector<Shown> shown_;
  std::thread thread_;  // last: everything above exists before it starts
};

}  // namespace kerf
