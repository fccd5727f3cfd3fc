// A live run by a person: a case, its tools, the three threads, the log; at the end a run folder like any other.
//
//   device ──▶ HapticThread ──bricks──▶ MesherThread ──chunks──▶ window
//                   ├──bricks of pieces───▶ a MesherThread each
//                   └──samples, commands──▶ SessionRecorder ──▶ RUN/session.kerflog
//
// The folder exists from the beginning. After a crash recoverRun() (session_run.h) finishes it.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/boolean/post_op_mesh.h"
#include "sim/live/checkpoint_maker.h"
#include "sim/live/haptic_thread.h"
#include "sim/live/mesher_thread.h"
#include "sim/live/scan_colours.h"
#include "sim/run/session/session_run.h"

namespace kerf {

/// A neighbour of the case.
struct CaseBeside {
  std::filesystem::path folder;
  std::string name;  ///< for display: "35"
};

struct LiveRunOptions {
  std::vector<SessionTool> tools;  ///< of the rack; the first is in hand
  Rigid3 start;                    ///< of the tool, object frame, in air
  StepSettings step;
  /// The tools set `felt`, if the device can be felt; the run sets `pieces.on_piece`.
  HapticOptions haptic;
  RecorderOptions recorder;
  MesherThreadOptions mesher;
  CheckpointOptions checkpoints;
  /// An ended run to continue: its cuts remain, and undo reaches back to its end. Empty: none.
  std::filesystem::path from;
  /// Neighbours stand where their scans stand. The tool meets them, and cuts of them are recorded. At most
  /// LiveRun::kMostNeighbours. When continuing a run: further ones, after those of that run.
  std::vector<CaseBeside> beside;
  std::vector<std::string> without;  ///< ids of cases that the user took away from beside it: kept for the next opening
  bool is_felt = false;              ///< the device renders force
  bool is_looked_at = false;         ///< chunks of the surface get colours and occlusion
};

/// Chunks of one object that changed.
struct ObjectChunks {
  std::uint32_t id = 0;  ///< CutObject::id
  std::vector<MeshChunkPtr> chunks;
};

/// The scene at a moment: its objects, their poses, and their meshers, which know the cuts.
struct SceneView {
  struct Object {
    std::uint32_t id = 0;
    std::uint32_t loaded = 0;  ///< ObjectReport::loaded
    std::string name;
    Rigid3 T_world_object;
    std::shared_ptr<MesherThread> mesher;
    PlaneSides plane_sides;
  };
  std::vector<Object> objects;
};

/// A copy of the scene, for work while the cut goes on.
struct SceneCopy {
  struct Object {
    std::uint32_t id = 0;
    std::uint32_t loaded = 0;
    std::string name;
    Rigid3 T_world_object;
    std::shared_ptr<const BrickField> begin;  ///< of a piece, at its split; null: as loaded
    BrickField changed;                       ///< bricks changed since then
    PlaneSides plane_sides;
  };
  std::vector<Object> objects;
};

struct LiveResult {
  PostOpMesh post_op;                      ///< all pieces where they were loaded
  std::vector<RunManifest::Piece> pieces;  ///< for placedPieces(); empty: one object, neither moved nor named
};

/// A neighbour of the case, as loaded.
struct LiveNeighbour {
  SessionNeighbour known;                      ///< known.removed_mm3: volume removed in the earlier run
  std::shared_ptr<const BakedObject> object;   ///< at the start of this session
  std::shared_ptr<const BrickField> original;  ///< as in its case
};

/// All calls from one thread, the window's; the haptic thread's own interface is thread().
class LiveRun {
 public:
  /// Loads the case and makes the run folder, and its parent if needed. Nothing runs yet.
  /// Errors: those of loading; kWriteFailed, kBadValue without a tool; kCancelled, which leaves nothing behind.
  /// @cost  seconds for a tooth, 15 for a mandible at 0.05 mm. May run on any thread, as a job.
  static Expected<std::unique_ptr<LiveRun>> open(const std::filesystem::path& case_folder,
                                                 const std::filesystem::path& run_folder, LiveRunOptions options,
                                                 const Progress& progress = {});
  /// As finish(), but the result is lost. A run that was never started leaves no folder.
  ~LiveRun();
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;

  /// Starts the threads. @param device  must outlive this. Once.
  Expected<void> start(DeviceSource& device);

  static constexpr std::size_t kMostNeighbours = 8;
  const std::filesystem::path& folder() const noexcept { return folder_; }
  const std::filesystem::path& caseFolder() const noexcept { return case_folder_; }
  const std::filesystem::path& from() const noexcept { return options_.from; }
  const std::vector<std::string>& without() const noexcept { return options_.without; }
  const CaseManifest& caseManifest() const noexcept { return case_; }
  const BakedObject& object() const noexcept { return *object_; }
  /// The same, for work that may outlive the run.
  std::shared_ptr<const BakedObject> sharedObject() const noexcept { return object_; }
  /// The field of the case, before the earlier run if this run continues one.
  std::shared_ptr<const BrickField> original() const noexcept { return original_; }
  /// Colours of the case's scan. Null: it has none, or options.is_looked_at is false.
  std::shared_ptr<const ScanColours> scanColours() const noexcept { return scan_colours_; }
  /// Whether anything in the scene has the colours of its scan.
  bool hasScanColours() const noexcept { return has_scan_colours_; }
  /// Volume removed in the earlier run, mm^3; 0 without one.
  double removedBefore() const noexcept { return removed_before_; }
  /// RunManifest::added_before_mm3.
  double addedBefore() const noexcept { return added_before_; }
  /// Labels of the earlier run's pieces. These pieces are apart and in their places from the beginning.
  const PieceLabels& labels() const noexcept { return labels_; }
  /// Names of the pieces that were not found again.
  const std::vector<std::string>& missingPieces() const noexcept { return missing_; }
  /// In the order of ObjectReport::loaded, starting at 1.
  std::span<const LiveNeighbour> neighbours() const noexcept { return neighbours_; }
  /// Whether an object is a neighbour, or a piece of one.   @param id  CutObject::id.
  bool isBeside(std::uint32_t id) const;
  std::span<const SessionTool> tools() const noexcept { return options_.tools; }
  const Model& model() const noexcept { return haptic_->session().model(); }
  HapticThread& thread() noexcept { return *haptic_; }
  /// As HapticThread::send(); also records chosen tools for the manifest.
  bool send(const Command& command);
  RecorderStatus recorderStatus() const { return recorder_->status(); }
  /// Null: not wanted.
  const CheckpointMaker* checkpoints() const noexcept { return checkpoints_.get(); }

  // Display: each object has a mesher of its own, with its id. An object that was split, or a piece that an undo
  // joined, keeps its mesher as long as it may return.

  /// Chunks that changed since the last call, object by object. Starts the meshers of new pieces.
  std::vector<ObjectChunks> takeChunks();
  /// Edits meshed so far, of all objects: see MesherThread::editsDone().
  std::uint64_t editsDone() const noexcept;

  /// The current scene. Empty: a new piece has no mesher yet; try again some ms later.
  std::optional<SceneView> viewScene();
  /// The current cuts from the meshers, a few ms old. The cut goes on. Any thread; waits for the meshers: some ms, for
  /// a new piece some seconds.   Error kNotFound: one of the objects is gone.
  static Expected<SceneCopy> copyOf(const SceneView& view);
  /// The post-operative mesh of a copy. Any thread.   Errors: as exportBundle().
  /// @param beside  0: of the case; n: of its n-th neighbour, where its scan stands.
  Expected<LiveResult> postOperative(const SceneCopy& scene, const PostOpOptions& options = {},
                                     const Progress& progress = {}, std::size_t beside = 0) const;
  /// Sets a name for the manifest and exports, in place of "piece N". Stored beside the log, so that it survives a
  /// crash.
  void namePiece(std::uint32_t id, const std::string& name);
  /// Sets the colour in the same way. Empty: none.
  void colourPiece(std::uint32_t id, const std::string& colour);

  /// Stops the threads and writes the run; once. kEmpty: nothing was cut, and the folder is deleted. After any other
  /// error the folder is open, and its log is whole.
  /// @param keeps_log  keeps the log on kEmpty too: it has the undone cuts, for branchRun() (run_branch.h).
  Expected<RunManifest> finish(bool keeps_log = false);

 private:
  LiveRun(LiveRunOptions options, std::filesystem::path case_folder, std::filesystem::path run_folder);
  Expected<void> load(const Progress& progress);
  Expected<void> loadWhatIsCut();
  Expected<void> loadNeighbours();
  Expected<void> loadNeighbour(SessionNeighbour known, const BrickField* begin);
  LoadedObjects loaded() const;
  Expected<void> chooseColours();
  std::uint32_t loadedIndexOf(const BakedObject* object) const;
  Expected<void> makeFolder();
  struct Shown {
    std::uint32_t id = 0;
    std::uint32_t loaded = 0;
    std::shared_ptr<MesherThread> mesher;  // shared with views of the scene
    PlaneSides plane_sides{};
  };
  struct CameOff {
    std::shared_ptr<const PieceOrigin> origin;
    std::shared_ptr<BrickFeed> feed;
  };
  void showNewPieces();
  std::vector<Command> putPiecesBack(Session& session);
  const Shown* shownOf(std::uint32_t id) const;
  void label(std::uint32_t id, const PieceLabel& label);

  LiveRunOptions options_;
  std::filesystem::path case_folder_, folder_;
  CaseManifest case_;
  RunManifest manifest_;
  std::shared_ptr<const BakedObject> object_;
  std::shared_ptr<const BrickField> original_;  // the field in object_, unless the run continues another one
  std::shared_ptr<const ScanColours> scan_colours_;
  bool has_scan_colours_ = false;
  double removed_before_ = 0;
  double added_before_ = 0;
  std::vector<RunManifest::Piece> pieces_before_;
  std::vector<std::string> missing_;
  std::vector<LiveNeighbour> neighbours_;
  std::deque<BrickFeed> feeds_;                      // of the loaded objects
  std::vector<MesherThreadOptions> mesher_options_;  // of the same
  std::optional<RunLock> lock_;
  std::unique_ptr<CheckpointMaker> checkpoints_;  // outlives the recorder
  std::optional<SessionRecorder> recorder_;
  std::unique_ptr<HapticThread> haptic_;
  std::mutex mutex_;
  std::vector<CameOff> came_off_;  // filled by the maker of pieces; guarded by mutex_
  std::vector<Shown> shown_;       // loaded objects, unless they began in pieces, and new pieces
  std::uint64_t edits_of_forgotten_ = 0;
  PieceLabels labels_;
  bool is_started_ = false, is_finished_ = false;
};

}  // namespace kerf
