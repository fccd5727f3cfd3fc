// The open document, its session and the running job, shared by the window and its scripts. No OpenGL, no keys.
//
// All calls come from one thread, once a frame update(). Long work is a job and never blocks that thread. Each user
// step is one function here. The command table (app_commands.h) adds names, keys and menu places.
#pragma once

#include <chrono>
#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/field/material.h"
#include "sim/hand/guided_hand.h"
#include "sim/hand/hand_switch.h"
#include "sim/hand/mouse_hand.h"
#include "sim/monitor/structures.h"
#include "sim/run/report/run_report.h"
#include "sim/run/session/live_run.h"
#include "ui/app/base/job.h"
#include "ui/app/base/user_files.h"
#include "ui/app/import/lost_sessions.h"
#include "ui/app/import/opening.h"
#include "ui/app/session/exporting.h"
#include "ui/app/session/loop_rate.h"
#include "ui/app/session/neighbours.h"
#include "ui/app/session/timeline.h"
#include "ui/app/session/trace.h"
#include "ui/app/tool/cut_stamp.h"
#include "ui/app/tool/hindrance.h"
#include "ui/app/tool/rack.h"
#include "ui/app/tool/stroke.h"
#include "ui/app/tool/tilt.h"
#include "ui/app/view/live_scene.h"
#include "ui/app/view/measure.h"

namespace kerf {

class ArmLead;
class ExportPlan;
class Sawing;
class TissueDisplay;
class ImportPlan;
class ImportSet;
class WatchedRun;
struct MeshToolOrder;

struct WorkbenchOptions {
  /// Parent of "cases" and "sessions". Empty: $XDG_DATA_HOME/kerf, or ~/.local/share/kerf.
  std::filesystem::path data_folder;
  std::vector<std::string> tools;  ///< ids or files; empty: the whole rack, defaultTools() first
  std::string unit;                ///< of opened scans: "mm", "inch"; empty: from the file, or by its size
  double voxel_mm = 0;             ///< of opened scans; 0: 0.1, or coarser for a large scan: voxelFor()
  RealTimeRequest real_time;       ///< of the haptic thread
  std::string device;              ///< a force-feedback device to open: ArmLead::open(); empty: none
  bool keeps_recent = false;       ///< adds opened files to the list of recent files
  bool asks_about_runs = false;    ///< asks whether to continue or watch a run: askedRun()
};

/// A message for the user, shown until dismissed.
struct Notice {
  bool is_error = false;
  std::string text;
};

/// Another line of cutting, kept as a run or in the log of one.
struct Branch {
  std::filesystem::path run;
  BranchPoint point{};  ///< in its log; if neither is set: the end of the log
  std::string text;     ///< shown to the user
};

/// Result of ending a session.
struct EndedSession {
  Expected<RunManifest> run;
  std::optional<RunReport> report{};
  /// If the session holds no steps: runs of the undone steps, by BranchPoint::step_began.
  std::map<std::uint64_t, std::filesystem::path> saved{};
  std::optional<Error> failed{};  ///< a failed save: the session folder with its log remains
};
/// Ends a session.   @param dropped  its undone steps: BranchPoint::step_began.
EndedSession endSession(LiveRun& run, const std::vector<std::uint64_t>& dropped,
                        const std::filesystem::path& data_folder, const std::string& name);

/// The leading point of a tool, in the frame of the scan.
struct ToolFront {
  Vec3d point = Vec3d::Zero();   ///< mm
  Vec3d into = -Vec3d::UnitZ();  ///< unit: its direction of travel into the object
  double depth = 0;              ///< below the surface as loaded, along `into`, mm; negative in air
};

/// Distance from the tool to a protected structure.
struct NearStructure {
  std::string name;         ///< "pulp", "nerve canal"
  double distance_mm = 0;   ///< negative: the tool is inside it
  bool is_far = true;       ///< beyond the measured range: distance_mm is the reach
  bool is_stopped = false;  ///< the stroke stops short of it here
};

class Workbench {
 public:
  explicit Workbench(WorkbenchOptions options = {});
  ~Workbench();  ///< as close(), and waits
  Workbench(const Workbench&) = delete;
  Workbench& operator=(const Workbench&) = delete;

  // ---- Once a frame

  /// Collects results of jobs, mesher and haptic thread. @return chunks of the surface that changed.
  std::vector<ObjectChunks> update();
  /// The running job, or null. Meanwhile Kerf rejects open, export and close with a notice.
  const AnyJob* job() const { return job_.get(); }
  void cancelJob();
  /// The job writes a file for the user: the program waits for it before it ends.
  bool isWriting() const { return job_ && job_writes_; }
  const std::vector<Notice>& notices() const { return notices_; }
  void say(std::string text) { notices_.push_back({false, std::move(text)}); }
  /// Adds a notice. A cancel by the user is no error.
  void complain(const Error& error) { notices_.push_back({error.code != Error::Code::kCancelled, error.message()}); }

  // ---- The open document

  /// Opens a case, or bakes a mesh first with the default remedies and lists their changes in a notice. Closes the open
  /// document.
  void open(const std::filesystem::path& path);
  /// Kerf's own anatomy, made at the first request.   @param name  of demoNames().
  void openDemo(const std::string& name);
  /// Reads a scan or a label volume and waits for the user's decisions: importSet(). Opens a single recipe, case or run
  /// at once. A job.
  void beginImport(const std::filesystem::path& path);
  /// The same for several files: the first is cut, the others become neighbours, unless the user changes this. Tools
  /// among them go into the rack. A job.
  void beginImports(const std::vector<std::filesystem::path>& paths);
  /// Reads more neighbours into the current import. Without an import: as beginImports(). A job.
  void importMore(const std::vector<std::filesystem::path>& paths);
  /// The current import, or null. It stays until it is open for cutting, or cancelled.
  ImportSet* importSet() const { return import_.get(); }
  bool isImporting() const { return import_ != nullptr; }
  /// The scan of the import whose choices are shown. Null: no import, or the shown entry is no scan.
  ImportPlan* importPlan() const;
  /// Prepares all entries as decided and opens them. Writes future tools below the data folder first and adds them to
  /// the rack. A job. If it fails, the plans stay for another remedy.
  void startImport();
  void cancelImport();
  bool isOpen() const { return run_ != nullptr; }
  /// Increases with each newly opened document: earlier pictures are outdated.
  std::uint64_t generation() const { return generation_; }
  std::string name() const { return name_; }
  /// Unit vector out of the teeth: best view direction of a scan of several teeth. None: it has no occlusal plane.
  const std::optional<Vec3d>& occlusalNormal() const { return occlusal_.normal; }
  /// The dental arch, in the scan's frame. None: the scan is no full arch.
  const std::optional<DentalArch>& arch() const { return occlusal_.arch; }
  /// Tooth sides set by the user, in the scan's frame. They override arch() until another document is open. None: not
  /// set.
  std::optional<ToothSides> told_sides;
  const LiveRun* run() const { return run_.get(); }
  const LiveScene& scene() const { return scene_; }
  /// Pulp and nerve canals as loaded. Null: nothing is open.
  const Structures* structures() const { return structures_.get(); }
  /// Distance of the tool to them: its pose in a stroke or led by a device, else its touch point. None: no structures.
  std::optional<NearStructure> nearStructure(const std::optional<ToolOverSurface>& over) const;
  TissueDisplay& tissues() { return *tissues_; }
  const TissueDisplay& tissues() const { return *tissues_; }
  /// Display name of a tissue: "enamel".
  std::string nameOf(Material material) const;
  const HapticReport& report() const { return report_; }
  /// Forces and cutting of the last 20 s.
  const Trace& trace() const { return trace_; }
  /// Speed of the drive as a share of its free speed, 0 to 1.
  double driveShare() const;
  /// Load of the drive as a share of its stall load; 0: nothing stalls it.
  double driveLoadShare() const;
  HapticTimes times() const { return times_; }
  /// Ticks per second of the 1 kHz thread, mean of the last second. None in the first second.
  std::optional<double> loopHz() const { return loop_rate_.hz(); }
  /// Ends the session and writes the run to sessionFolder(). A job.
  void close();
  const std::filesystem::path& sessionFolder() const { return session_; }
  /// Report of the last ended session. None: nothing was cut in it.
  const std::optional<RunReport>& lastResult() const { return last_result_; }

  // ---- Watching an ended session: sim/run/session/watched_run.h. No cutting meanwhile: isOpen() is false.

  /// Loads a run and shows its beginning. Closes the open document. A job.
  void watch(const std::filesystem::path& run_folder);
  /// Null if no run is watched.
  WatchedRun* watched() { return watched_.get(); }
  const WatchedRun* watched() const { return watched_.get(); }
  bool isPlaying() const;
  /// An object is shown, for cutting or watching.
  bool isShown() const { return run_ || watched_; }
  void endWatching();
  /// Opens the watched run to continue cutting from the shown moment. Before its end, it keeps that state as a new run
  /// first.   Error kUnsupported: the run is seeking another moment.
  Expected<void> goOnCutting();
  /// A run given to beginImport() that awaits the choice of open() or watch(). None in scripts.
  const std::optional<std::filesystem::path>& askedRun() const { return asked_run_; }
  void forgetAskedRun() { asked_run_.reset(); }

  // ---- Tools

  std::size_t toolCount() const;
  const Tool& tool(std::size_t n) const;
  std::size_t toolInHand() const { return tool_; }
  void selectTool(std::size_t n);
  bool selectTool(const std::string& id);
  /// The rack is still being read in the background. update() fills the rack and reports errors. Opening a document
  /// waits in its job for the tools.
  bool isReadingTools() const { return rack_ != nullptr; }
  /// Waits for them, for callers without a window.
  void waitForTools() { takeRack(true); }
  /// Number of leading tools for a first look. A rack chosen by the user: all of it.
  std::size_t firstLookTools() const { return first_look_ ? first_look_ : tools_.size(); }
  /// Error in a tool's file or mesh found since it was read, or null. The tool itself stays as read.
  const Error* toolError(std::size_t n) const;
  using BrokenTool = kerf::BrokenTool;
  const std::vector<BrokenTool>& brokenTools() const { return broken_tools_; }
  /// Adds a tool's file to the rack, or rereads it, and takes the tool in hand. The open document continues in a new
  /// session: undo reaches back to here. Rejects a file that is no tool and names the fault.
  void addTool(const std::filesystem::path& file);
  /// The document was only reopened for another tool: the view stays.
  bool keepsView() const { return keeps_view_; }

  // ---- By mouse: rays in the world's frame

  double force = 1;       ///< N
  double depth_mm = 0.5;  ///< below the surface as loaded
  double irrigation = 1;  ///< 0 to 1
  double speed = 1;       ///< set speed of the spindle as a share of the nominal one, 0 to 1
  /// Least distance of a stroke to pulp or nerve canal, mm: it stops short of them. None: it may enter them, with a
  /// warning. A planned cut ignores it: Sawing::clearance() gives its distance.
  std::optional<double> stop_short_mm;
  /// Tilt of the tool before it touches, and of later strokes. A guided blade has no tilt.
  Tilt tilt;
  static constexpr double kLeastForce = 0.1, kMostForce = 8, kMostDepth = 5;

  Measure measure;
  /// Hides the side its normal points to from view and pointing. None: shows all.
  std::optional<Plane> section;
  /// The ray from its exit out of the hidden side of the section. None: that point is inside an object.
  std::optional<Ray> behindSection(const Ray& ray) const;

  /// The tool's pose over the surface there. None: the ray misses the object, or nothing is open.
  std::optional<ToolOverSurface> over(const Ray& ray) const;
  /// @return  false: nothing to cut there.
  bool press(const Ray& ray);
  void drag(const Ray& ray);
  /// Changes the depth during a stroke or before it, mm; positive is deeper.
  void deepen(double mm);
  void setForce(double newtons);
  void setSpeed(double of_nominal);
  void setIrrigation(double of_full);
  /// Reverses the drive until another tool is taken. A one-way drive (air turbine, saw, piezo tip) gives an error with
  /// a remedy.
  Expected<void> setReversed(bool is_reversed);
  bool isReversed() const { return is_reversed_; }
  bool canReverse() const;
  /// Factor on the speed until the stroke ends: trigger travel, 0 to 1.
  void drill(double pedal);
  /// Factor on the force, until it is 1 again.
  void pushHarder(double factor);
  /// Ends the stroke, mouse or pedal.
  void release();
  /// Moves the tool along its axis, mm, positive is in. It stays at that depth until the stroke ends or the depth is
  /// set. Range: from kClearance above the surface as loaded to the depth. Without a stroke: no effect.
  void moveAlong(double mm);
  /// Moves the stroke's pointer over the surface as loaded, in mm of the picture. Without a stroke: no effect.
  void nudge(const Camera& camera, double right_mm, double up_mm);
  /// A foot pedal holds the stroke: it needs no button, and the mouse does not lead it. Begins a stroke if there is
  /// none.
  /// @param at  pointing ray; none: the place of the last press or drag.
  /// @return  false: nothing to cut there.
  bool stepOnPedal(const std::optional<Ray>& at);
  bool isOnPedal() const { return is_on_pedal_; }
  /// Position of the stroke's pointer, world, mm.
  const Vec3d& strokePointer() const { return aim_.pointer; }
  bool isPressed() const { return stroke_.has_value(); }
  /// Depth of the tool below the surface as loaded; none: no stroke.
  std::optional<double> depthNow() const;
  /// Depth of the tool's leading point below the surface as loaded, mm, along its direction of travel; negative in air.
  /// For mouse, device and planned cut. None: nothing leads the tool, or there is no surface above or below.
  std::optional<double> tipDepth() const;
  /// Leading point of the same tool.
  std::optional<ToolFront> toolFront() const;
  /// Reason why the stroke removes nothing and a remedy, in English. Empty: no hindrance.
  const char* hindrance() const { return hindrance_.text(); }
  void stopShort(std::optional<double> mm);
  static constexpr double kMostShort = 5, kUsualShort = 0.5;  ///< mm

  void undo();
  void redo();
  const Timeline& timeline() const { return timeline_; }
  /// Number of steps done once all requested Undo and Redo are: timeline().steps() up to there.
  std::size_t stepsDone() const;
  /// Undoes or redoes all steps between now and the end of a step. 0: the beginning. Blocks cutting until then.
  /// @param step  its number as displayed.
  /// Errors: kUnsupported for a step before timeline().older(), or during a plane cut; kBadValue for an unknown step.
  Expected<void> goToStep(std::uint64_t step);
  /// Branches beside the current line: steps undone before a new cut, in this session and in those it continues by a
  /// branch, a tool or a neighbour; and lines left for a branch.
  std::vector<Branch> branches() const;
  std::size_t branchCount() const { return left_.size() + timeline_.branches().size(); }
  /// Continues a branch in a new session. Writes the open session, which becomes a branch. A job.
  /// Errors: kEmpty; kBadValue for an unknown branch; kUnsupported during a plane cut.
  Expected<void> takeBranch(std::size_t n);

  // ---- Pieces, by SceneObject::id

  /// One undo step. Rejected with a notice during a stroke, and for an unusable pose.
  void movePiece(std::uint32_t id, const Rigid3& T_world_object);
  /// Shows the piece at this pose until movePiece(), or until a call with none.
  void dragPiece(std::uint32_t id, const std::optional<Rigid3>& T_world_object);
  void hidePiece(std::uint32_t id, bool is_hidden);
  void namePiece(std::uint32_t id, const std::string& name);
  /// Display colour, kept with the session like the name.   @param colour  of pieceColours(); empty: none.
  void colourPiece(std::uint32_t id, const std::string& colour);
  /// The piece that moves act on. Null: none chosen, or not in the scene.
  const SceneObject* chosenPiece() const;
  void choosePiece(std::optional<std::uint32_t> id) { chosen_ = id; }

  // ---- Neighbours: workbench_neighbours.cpp

  /// Opens the first file for cutting and the others as neighbours, at their scan positions: each a scan, prepared with
  /// the default remedies, a recipe or a case. Tools among them go into the rack. A single file: as beginImport().
  /// To let the user decide first: beginImports().
  void openAll(const std::vector<std::filesystem::path>& paths);
  /// Adds a neighbour. The open document continues in a new session: undo reaches back to here. A job.
  void openBeside(const std::filesystem::path& path);
  /// Swaps roles: that neighbour is cut, the current object becomes a neighbour, both as in their cases. Writes the
  /// current session first.
  void workOn(std::size_t number);
  std::vector<Neighbour> neighbours() const;
  /// Null: no such neighbour.   @param name  or its number.
  const SceneObject* findNeighbour(const std::string& name) const;
  /// Makes it translucent and not selectable.
  void ghostNeighbour(std::uint32_t id, bool is_ghost);
  /// The neighbour nearest to the tool, measured as nearStructure(). None: no neighbours.
  std::optional<NearNeighbour> nearNeighbour(const std::optional<ToolOverSurface>& over) const;
  /// Least distance of a stroke to neighbours, mm, as stop_short_mm. None: it may cut them, with a warning.
  std::optional<double> stop_short_beside_mm;
  void stopShortBeside(std::optional<double> mm);
  static constexpr double kUsualShortBeside = 0.2;  ///< mm

  // ---- By a force-feedback device: workbench_hand.cpp

  /// All queries also work on a device that is not open.
  ArmLead& arm() { return *arm_; }
  const ArmLead& arm() const { return *arm_; }
  /// Opens the device. The open document continues in a session with a coupling that suits it.
  Expected<void> openDevice(const std::string& name);
  /// Continues the open document in a session with a coupling for the device as it is now.
  Expected<void> fitToDevice();
  /// Maps the hand's present position to this tip position and moves the tool there.
  Expected<void> placeHand(const Vec3d& tip);
  /// A device leads the tool, not the mouse.
  bool isLed() const;

  // ---- By plan

  Sawing& saw() { return *saw_; }
  const Sawing& saw() const { return *saw_; }

  // ---- Results

  /// Exports the present post-operative mesh, reads it back and compares. A job; cutting may go on.
  void exportTo(const std::filesystem::path& file, const ExportChoice& choice = {});
  /// Step-by-step export, with the results of a check before any writing.
  ExportPlan& exporting() { return *exporting_; }
  const ExportPlan& exporting() const { return *exporting_; }
  /// The object in work was cut or moved since its last complete export, if any. An export of one piece of several
  /// does not count. The session itself is always kept. False during an export.
  bool hasUnexportedCut() const;
  double removedMm3() const { return removed_mm3_; }
  /// Removed volume of one tissue in this session, mm^3. Slightly below 0 where a border crosses the cut.
  double removedOf(Material material) const;

  // ---- Recent files

  RecentFiles& recent() { return recent_; }
  void forgetRecent(std::size_t n);
  /// The open scan, recipe or case. It stays until another document is open.
  const std::filesystem::path& source() const { return source_; }

  // ---- After a crash

  const std::vector<LostSession>& lostSessions() const { return lost_; }
  /// Size of its folder, mostly the log.
  std::uintmax_t bytesOfLost(std::size_t n) const;
  /// Deletes the folder with its log for good, after the caller has asked the user.
  void forgetLost(std::size_t n);
  /// Finishes the session from its log into a run for `kerf export`. A job.
  void recover(std::size_t n);

  /// Deepest stroke, mm: along a guide right through a jaw.
  double mostDepth() const;

 private:
  friend class ExportPlan;
  friend class Sawing;
  void takeNews();
  void addToTrace();
  void warnOfHeat();
  bool isSettled();
  void handOverScene();
  bool mayExportTo(const std::filesystem::path& file);
  std::shared_ptr<std::future<SceneView>> orderScene();
  std::optional<CutStamp> stampNow() const;
  void takeWatched();
  void showWatched(std::unique_ptr<WatchedRun> run, const OcclusalSide& occlusal);
  bool isBusy();
  bool isSawing();
  bool send(const Command& command);
  std::uint64_t answered() const { return report_.counts.commands_done + report_.counts.commands_refused; }
  void undoOrRedo(std::ptrdiff_t strokes);
  void sendUndos();
  void goWhereWished();
  std::size_t strokesDone() const;
  void remember(const std::filesystem::path& path);
  void putImportAway();
  void openImported();
  void makeTools(std::vector<MeshToolOrder> orders);
  void takeMadeTools(std::vector<SessionTool> made);
  std::filesystem::path ownToolFolder() const { return options_.data_folder / "tools"; }
  void placeBeside(std::vector<OpenBeside> asked, const std::string& title);
  std::vector<std::filesystem::path> takeTools(const std::vector<std::filesystem::path>& paths);
  void readToImports(std::vector<std::filesystem::path> paths, const std::string& title, bool is_more);
  OpeningOptions openingOptions() const;
  using Load = std::function<Expected<Opened>(const Progress&)>;
  void openBy(const std::string& title, Load load);
  void show(Opened& loaded);
  void sendAim();
  void followDevice();
  void warnThatItIsLed();
  const ToolSamples& samplesOf(std::size_t tool) const;
  void heatByToolInHand();
  void warnOfThinTool();
  void namePieces();
  void readTools();
  void takeRack(bool waits);
  void putIntoRack(RackTool tool);
  void reopenWith(const std::filesystem::path& tool_file, std::vector<CaseBeside> further = {},
                  const std::optional<Branch>& branch = {});
  void endRun(bool keeps_ahead);
  void openBranch(const Branch& branch);
  std::optional<Branch> lineNow() const;
  void leaveBranches();
  std::vector<std::uint64_t> droppedSteps(bool with_ahead) const;
  Branch savedOf(const Branch& branch, const std::filesystem::path& gone) const;
  void takeEnded(const EndedSession& ended, const std::filesystem::path& folder);
  void warnOfNeighbours();
  bool isNeighbour(std::uint32_t id, const std::string& what);
  void watchTools();
  void watchBrokenTools();
  void keepBroken(const BrokenTool& broken);

  WorkbenchOptions options_;
  MaterialTable materials_{{}};
  std::vector<SessionTool> tools_;
  std::vector<Notice> notices_;
  std::vector<LostSession> lost_;
  RecentFiles recent_;

  std::unique_ptr<AnyJob> job_;
  std::function<void()> when_over_;  // takes the job's result
  bool job_writes_ = false;

  std::unique_ptr<ImportSet> import_;
  std::vector<std::unique_ptr<ImportSet>> ending_imports_;  // their previews are being cancelled
  std::string name_;
  std::filesystem::path source_;  // the opened file: never written to
  OcclusalSide occlusal_;
  std::filesystem::path session_;
  std::unique_ptr<ArmLead> arm_;        // outlives hands_
  std::unique_ptr<MouseHand> hand_;     // outlives hands_
  std::shared_ptr<HandSwitch> hands_;   // mouse or arm; outlives guided_
  std::unique_ptr<GuidedHand> guided_;  // outlives run_
  std::unique_ptr<LiveRun> run_;
  std::unique_ptr<TissueDisplay> tissues_;  // ends before run_
  LiveScene scene_;
  std::optional<std::uint32_t> chosen_;  // piece
  struct Moving {
    std::uint32_t id = 0;
    std::uint64_t sent = 0;  // done when so many commands are answered
  };
  std::vector<Moving> moving_;
  std::uint64_t generation_ = 0;
  HapticReport report_;
  HapticTimes times_;
  LoopRate loop_rate_;
  std::size_t tool_ = 0;
  std::vector<Mesh> heads_;  // of the tools
  std::shared_ptr<const Structures> structures_;
  NeighbourFields neighbour_fields_;
  std::vector<std::filesystem::path> sources_beside_;
  struct CutOff {
    double told_mm3 = 0, now_mm3 = 0;
    std::uint64_t tick = 0;  // of the last change
  };
  std::vector<CutOff> cut_off_;                         // of neighbours
  mutable std::map<std::size_t, ToolSamples> samples_;  // of tools that were in hand
  std::vector<Plunge> plunges_;                         // of all tools
  std::vector<TouchPoints> touches_;                    // of all tools
  ToolTimes toolTimesOf(std::size_t tool) const;
  std::vector<ToolTimes> tool_times_;              // before reading
  std::vector<std::optional<Error>> tool_errors_;  // since reading
  std::vector<BrokenTool> broken_tools_;
  std::size_t first_look_ = 0;
  std::unique_ptr<Job<Rack>> rack_;                            // null: reading is over
  std::shared_future<std::vector<SessionTool>> coming_tools_;  // result of rack_, for documents opened meanwhile
  std::chrono::steady_clock::time_point next_watch_{};
  std::vector<char> is_outdated_;                  // its file was reread since a document was opened
  bool has_written_ = false, has_failed_ = false;  // at the last close()
  bool is_reopening_ = false, keeps_view_ = false;
  std::optional<Stroke> stroke_;
  std::optional<Ray> pointed_;   // last stroke ray
  std::optional<double> along_;  // depth set by moveAlong(), mm
  bool is_on_pedal_ = false, is_reversed_ = false;
  MouseAim aim_;
  double push_factor_ = 1, drill_ = 1;
  double removed_mm3_ = 0;
  std::uint64_t sent_ = 0;  // commands
  Timeline timeline_;
  std::vector<Branch> left_;                              // branches of sessions that ended before this one
  std::optional<Branch> opened_;                          // continued by this session
  std::map<std::uint64_t, std::filesystem::path> saved_;  // EndedSession::saved of the last session
  Trace trace_;
  Hindrance hindrance_;
  std::optional<RunReport> last_result_;
  struct Wish {
    std::uint64_t step = 0;
    std::uint64_t tick = 0;  // first tick that counts the stroke ended for the wish
  };
  std::optional<Wish> wish_;             // of goToStep(), until all earlier commands are done
  std::ptrdiff_t undos_left_ = 0;        // not yet sent: positive Redo, negative Undo
  std::ptrdiff_t strokes_then_ = 0;      // strokes done after them
  std::uint64_t undos_answered_at_ = 0;  // when so many commands are answered
  bool has_told_of_log_ = false, has_told_that_it_is_led_ = false;
  std::set<std::string> told_thin_;  // tools of this session, by their ids
  bool has_told_of_pulp_ = false, has_told_of_bone_ = false, has_told_of_dead_bone_ = false;  // heat warnings given
  /// A job that waits for its export data until the last stroke is meshed.
  struct Handover {
    std::promise<SceneView> scene;
    std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();
    std::uint64_t sent = 0;                  // commands sent so far: answered before the handover
    std::optional<std::uint64_t> done_at{};  // tick at which all commands were done
  };
  std::optional<Handover> handover_;
  std::optional<CutStamp> handed_over_;  // the last exported state; none: cutting was going on
  std::optional<CutStamp> exported_;     // last
  bool has_unexported_before_ = false;   // in the session that this one continues, for a tool or a neighbour
  std::vector<ObjectChunks> fresh_;      // not handed out yet
  std::unique_ptr<Sawing> saw_;
  std::unique_ptr<ExportPlan> exporting_;
  std::unique_ptr<WatchedRun> watched_;
  bool has_told_of_verdict_ = false;
  std::optional<std::filesystem::path> asked_run_;
};

}  // namespace kerf
