// A run that a person makes: a case, its tools, the three threads, the log; at the end a run folder like any other.
//
//   device ──▶ HapticThread ──bricks──▶ MesherThread ──chunks──▶ window
//                   ├──bricks of pieces───▶ a MesherThread each
//                   └──samples, commands──▶ SessionRecorder ──▶ RUN/session.kerflog
//
// The folder is there from the beginning: what a crash leaves behind, recoverRun() (session_run.h) finishes.
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
#include "sim/live/haptic_thread.h"
#include "sim/live/mesher_thread.h"
#include "sim/live/scan_colours.h"
#include "sim/run/session_run.h"

namespace kerf {

/// A case that stands beside the one that is worked on.
struct CaseBeside {
  std::filesystem::path folder;
  std::string name;  ///< for people: "35"
};

struct LiveRunOptions {
  std::vector<SessionTool> tools;  ///< of the rack; the first is in hand
  Rigid3 start;                    ///< of the tool, object frame, in air
  StepSettings step;
  /// `felt` is set by the tools, if the device can be felt; `pieces.on_piece` by the run.
  HapticOptions haptic;
  RecorderOptions recorder;
  MesherThreadOptions mesher;
  /// A run that has ended, from which this one goes on: what it cut is cut, and undo reaches back to here. Empty: none.
  std::filesystem::path from;
  /// They stand where their scans stand, are met by the tool, and what is cut off them is recorded. At most
  /// LiveRun::kMostNeighbours. Of a run that is gone on from: further ones, behind those that stood there.
  std::vector<CaseBeside> beside;
  bool is_felt = false;       ///< the device renders force
  bool is_looked_at = false;  ///< chunks of the surface get colours and occlusion
};

/// Chunks of one object that changed.
struct ObjectChunks {
  std::uint32_t id = 0;  ///< CutObject::id
  std::vector<MeshChunkPtr> chunks;
};

/// What is in the scene at a moment: where its objects are, and who knows what was cut off them.
struct SceneView {
  struct Object {
    std::uint32_t id = 0;
    std::uint32_t loaded = 0;  ///< ObjectReport::loaded
    std::string name;
    Rigid3 T_world_object;
    std::shared_ptr<MesherThread> mesher;
  };
  std::vector<Object> objects;
};

/// The same, to work on while the cut goes on.
struct SceneCopy {
  struct Object {
    std::uint32_t id = 0;
    std::uint32_t loaded = 0;
    std::string name;
    Rigid3 T_world_object;
    std::shared_ptr<const BrickField> begin;  ///< of a piece, as it came off; null: as loaded
    BrickField changed;                       ///< bricks that are other now
  };
  std::vector<Object> objects;
};

struct LiveResult {
  PostOpMesh post_op;                      ///< all pieces where they were loaded
  std::vector<RunManifest::Piece> pieces;  ///< for placedPieces(); none: one object, neither moved nor named
};

/// What stands beside the object that is worked on, as loaded.
struct LiveNeighbour {
  SessionNeighbour known;                      ///< known.removed_mm3: what the run before had removed
  std::shared_ptr<const BakedObject> object;   ///< as this session begins with it
  std::shared_ptr<const BrickField> original;  ///< as in its case
};

/// All calls from one thread, the window's; the haptic thread's own interface is thread().
class LiveRun {
 public:
  /// Loads the case and makes the run folder, its parent if need be. Nothing runs yet.
  /// Errors: those of loading; kWriteFailed, kBadValue without a tool; kCancelled, and then nothing is left behind.
  /// @cost  seconds for a tooth, 15 for a mandible at 0.05 mm. May run on any thread, as a job.
  static Expected<std::unique_ptr<LiveRun>> open(const std::filesystem::path& case_folder,
                                                 const std::filesystem::path& run_folder, LiveRunOptions options,
                                                 const Progress& progress = {});
  /// As finish(), but the result is lost. One that was never started leaves no folder.
  ~LiveRun();
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;

  /// Starts the threads. @param device  must outlive this. Once.
  Expected<void> start(DeviceSource& device);

  static constexpr std::size_t kMostNeighbours = 8;
  const std::filesystem::path& folder() const noexcept { return folder_; }
  const std::filesystem::path& caseFolder() const noexcept { return case_folder_; }
  const std::filesystem::path& from() const noexcept { return options_.from; }
  const CaseManifest& caseManifest() const noexcept { return case_; }
  const BakedObject& object() const noexcept { return *object_; }
  /// The same, for work that may go on after the run is gone.
  std::shared_ptr<const BakedObject> sharedObject() const noexcept { return object_; }
  /// The field of the case: of one that goes on from another run, as it was before that.
  std::shared_ptr<const BrickField> original() const noexcept { return original_; }
  /// Of what is worked on. Null: its scan has no colours, or nobody looks at it.
  std::shared_ptr<const ScanColours> scanColours() const noexcept { return scan_colours_; }
  /// Whether anything in the scene has the colours of its scan.
  bool hasScanColours() const noexcept { return has_scan_colours_; }
  /// What the run before had removed, mm^3; 0: there was none.
  double removedBefore() const noexcept { return removed_before_; }
  /// RunManifest::added_before_mm3.
  double addedBefore() const noexcept { return added_before_; }
  /// Of the pieces it left; they are apart and where they were put from the beginning.
  const PieceLabels& labels() const noexcept { return labels_; }
  /// Of those that were not found again.
  const std::vector<std::string>& missingPieces() const noexcept { return missing_; }
  /// In the order of ObjectReport::loaded, from 1 on.
  std::span<const LiveNeighbour> neighbours() const noexcept { return neighbours_; }
  /// Whether an object is one of them, or a piece of one.   @param id  CutObject::id.
  bool isBeside(std::uint32_t id) const;
  std::span<const SessionTool> tools() const noexcept { return options_.tools; }
  const Model& model() const noexcept { return haptic_->session().model(); }
  HapticThread& thread() noexcept { return *haptic_; }
  /// As HapticThread::send(); the manifest names the tools that were chosen.
  bool send(const Command& command);
  RecorderStatus recorderStatus() const { return recorder_->status(); }

  // What there is to see: each object has a mesher of its own, with its id. An object that was split, or a piece that
  // an undo put back, keeps its mesher as long as it may come back.

  /// Chunks that changed since the last call, object by object; pieces that came off since are begun.
  std::vector<ObjectChunks> takeChunks();
  /// Edits meshed so far, of all objects: see MesherThread::editsDone().
  std::uint64_t editsDone() const noexcept;

  /// What is in the scene. None: a piece that has just come off has no mesher yet; try again some ms later.
  std::optional<SceneView> viewScene();
  /// What is cut by now, as the meshers know it, a few ms old. The cut goes on. Any thread; waits for the meshers, some
  /// ms, for a piece that has just come off some seconds.   Error kNotFound: one of the objects is gone.
  static Expected<SceneCopy> copyOf(const SceneView& view);
  /// The post-operative mesh of a copy. Any thread.   Errors: as exportBundle().
  /// @param beside  0: of the object that is worked on; n: of the n-th neighbour, where its scan stands.
  Expected<LiveResult> postOperative(const SceneCopy& scene, const PostOpOptions& options = {},
                                     const Progress& progress = {}, std::size_t beside = 0) const;
  /// For the manifest and for what is exported, in the place of "piece N". Kept beside the log: a crash does not lose
  /// it.
  void namePiece(std::uint32_t id, const std::string& name);
  /// The same of its colour. Empty: none.
  void colourPiece(std::uint32_t id, const std::string& colour);

  /// Stops the threads and writes the run; once. kEmpty: nothing was cut, and the folder is gone again. After any other
  /// error the folder is open, and its log is whole.
  /// @param keeps_log  also of kEmpty: what was cut and taken back is in the log, for branchRun() (run_branch.h).
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
  };
  struct CameOff {
    std::shared_ptr<const PieceOrigin> origin;
    std::shared_ptr<BrickFeed> feed;
  };
  void showNewPieces();
  std::vector<Command> putPiecesBack(Session& session);
  std::shared_ptr<MesherThread> mesherOf(std::uint32_t id);
  void label(std::uint32_t id, const PieceLabel& label);

  LiveRunOptions options_;
  std::filesystem::path case_folder_, folder_;
  CaseManifest case_;
  RunManifest manifest_;
  std::shared_ptr<const BakedObject> object_;
  std::shared_ptr<const BrickField> original_;  // within object_, unless it goes on from a run
  std::shared_ptr<const ScanColours> scan_colours_;
  bool has_scan_colours_ = false;
  double removed_before_ = 0;
  double added_before_ = 0;
  std::vector<RunManifest::Piece> pieces_before_;
  std::vector<std::string> missing_;
  std::vector<LiveNeighbour> neighbours_;
  std::deque<BrickFeed> feeds_;                      // of what was loaded
  std::vector<MesherThreadOptions> mesher_options_;  // of the same
  std::optional<RunLock> lock_;
  std::optional<SessionRecorder> recorder_;
  std::unique_ptr<HapticThread> haptic_;
  std::mutex mutex_;
  std::vector<CameOff> came_off_;  // told by the maker of pieces; guarded by mutex_
  std::vector<Shown> shown_;       // what was loaded, unless it began in pieces, and what came off
  std::uint64_t edits_of_forgotten_ = 0;
  PieceLabels labels_;
  bool is_started_ = false, is_finished_ = false;
};

}  // namespace kerf
