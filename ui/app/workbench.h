// What both the window and its scripts work on: what is open, what is cut, what is being done. No OpenGL, no keys.
//
// All calls come from one thread, once a frame update(). Long work is a job: it never blocks that thread. Each step of
// a user is one function here; the table of commands (app_commands.h) gives them names, keys and places in menus.
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
#include "sim/run/live_run.h"
#include "sim/run/run_report.h"
#include "ui/app/cut_stamp.h"
#include "ui/app/exporting.h"
#include "ui/app/hindrance.h"
#include "ui/app/job.h"
#include "ui/app/live_scene.h"
#include "ui/app/loop_rate.h"
#include "ui/app/lost_sessions.h"
#include "ui/app/measure.h"
#include "ui/app/neighbours.h"
#include "ui/app/opening.h"
#include "ui/app/rack.h"
#include "ui/app/stroke.h"
#include "ui/app/tilt.h"
#include "ui/app/timeline.h"
#include "ui/app/trace.h"
#include "ui/app/user_files.h"

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
  /// Where cases and sessions go: "cases", "sessions" below it. Empty: $XDG_DATA_HOME/kerf, or ~/.local/share/kerf.
  std::filesystem::path data_folder;
  std::vector<std::string> tools;  ///< ids or files; empty: all of the rack, those of defaultTools() first
  std::string unit;                ///< of scans that are opened: "mm", "inch"; empty: as the file says, or by its size
  double voxel_mm = 0;             ///< of scans that are opened; 0: 0.1, or coarser for a large one: voxelFor()
  RealTimeRequest real_time;       ///< of the haptic thread
  std::string device;              ///< a force-feedback device to open: ArmLead::open(); empty: none
  bool keeps_recent = false;       ///< what is opened is put on the list of recent files
  bool asks_about_runs = false;    ///< whether a run is gone on with or watched: askedRun()
};

/// Something the user should read, until it is dismissed.
struct Notice {
  bool is_error = false;
  std::string text;
};

/// Another line of cutting, kept as a run or in the log of one.
struct Branch {
  std::filesystem::path run;
  BranchPoint point{};  ///< in its log; neither: its end
  std::string text;     ///< for people
};

/// What became of a session.
struct EndedSession {
  Expected<RunManifest> run;
  std::optional<RunReport> report{};
  /// When nothing was left of it: runs of what had been taken back, by BranchPoint::step_began.
  std::map<std::uint64_t, std::filesystem::path> saved{};
  std::optional<Error> failed{};  ///< what could not be saved: its folder is still there, with its log
};
/// Ends a session.   @param dropped  of its steps that were taken back: BranchPoint::step_began.
EndedSession endSession(LiveRun& run, const std::vector<std::uint64_t>& dropped,
                        const std::filesystem::path& data_folder, const std::string& name);

/// The part of a tool that goes first, in the frame of the scan.
struct ToolFront {
  Vec3d point = Vec3d::Zero();   ///< mm
  Vec3d into = -Vec3d::UnitZ();  ///< unit: the way it goes in
  double depth = 0;              ///< below the surface as loaded, along that way, mm; negative in air
};

/// A tool beside what must be kept.
struct NearStructure {
  std::string name;         ///< "pulp", "nerve canal"
  double distance_mm = 0;   ///< negative: the tool is in it
  bool is_far = true;       ///< farther than is measured: distance_mm is the reach
  bool is_stopped = false;  ///< the stroke stops short of it, here
};

class Workbench {
 public:
  explicit Workbench(WorkbenchOptions options = {});
  ~Workbench();  ///< as close(), and waits
  Workbench(const Workbench&) = delete;
  Workbench& operator=(const Workbench&) = delete;

  // ---- Once a frame

  /// Takes what jobs, mesher and haptic thread have done since. @return chunks of the surface that changed.
  std::vector<ObjectChunks> update();
  /// The job under way; null: none. While there is one, open, export and close are refused with a notice.
  const AnyJob* job() const { return job_.get(); }
  void cancelJob();
  /// It writes something a user has asked for: to be waited for before the program ends.
  bool isWriting() const { return job_ && job_writes_; }
  const std::vector<Notice>& notices() const { return notices_; }
  void say(std::string text) { notices_.push_back({false, std::move(text)}); }
  /// Adds one. What the user cancelled is no error.
  void complain(const Error& error) { notices_.push_back({error.code != Error::Code::kCancelled, error.message()}); }

  // ---- What is open

  /// A case is opened, a mesh is baked first with the default remedies, what they change said as a notice. What was
  /// open is finished.
  void open(const std::filesystem::path& path);
  /// Our own anatomy: made when it is first asked for.   @param name  of demoNames().
  void openDemo(const std::string& name);
  /// Reads a scan or a label volume and waits for what the user decides about it: importSet(). A recipe, a case or a
  /// run alone is opened at once. A job.
  void beginImport(const std::filesystem::path& path);
  /// The same for several files together: the first is cut, the others stand beside it, until the user says otherwise.
  /// Tools among them go into the rack. A job.
  void beginImports(const std::vector<std::filesystem::path>& paths);
  /// Reads more, to stand beside those that are looked at; without such: as beginImports(). A job.
  void importMore(const std::vector<std::filesystem::path>& paths);
  /// What is looked at; null: nothing. It stays until it is open to be cut, or cancelled.
  ImportSet* importSet() const { return import_.get(); }
  bool isImporting() const { return import_ != nullptr; }
  /// The scan among it whose choices are shown; null: none is looked at, or that one is no scan.
  ImportPlan* importPlan() const;
  /// Prepares all as decided and opens it. What is to be a tool is written below the data folder first, and is in the
  /// rack then. A job; when it fails the plans stay, for another remedy.
  void startImport();
  void cancelImport();
  bool isOpen() const { return run_ != nullptr; }
  /// Rises when something else was opened: pictures of what was there are outdated.
  std::uint64_t generation() const { return generation_; }
  std::string name() const { return name_; }
  /// Out of the teeth, unit: the way a scan of several teeth is best looked at. None: it has no occlusal plane.
  const std::optional<Vec3d>& occlusalNormal() const { return occlusal_.normal; }
  /// The arch its teeth stand along, in the scan's frame. None: it is no full arch.
  const std::optional<DentalArch>& arch() const { return occlusal_.arch; }
  /// Which side is which, told by a person, in the scan's frame: goes before what the arch says, until something else
  /// is open. None: nobody has told.
  std::optional<ToothSides> told_sides;
  const LiveRun* run() const { return run_.get(); }
  const LiveScene& scene() const { return scene_; }
  /// Pulp and nerve canals as loaded. Null: nothing is open.
  const Structures* structures() const { return structures_.get(); }
  /// How near the tool is to them: during a stroke where it is, else where it would touch. None: there are none.
  std::optional<NearStructure> nearStructure(const std::optional<ToolOverSurface>& over) const;
  TissueDisplay& tissues() { return *tissues_; }
  const TissueDisplay& tissues() const { return *tissues_; }
  /// A tissue's name for people: "enamel".
  std::string nameOf(Material material) const;
  const HapticReport& report() const { return report_; }
  /// The last 20 s of what was felt and cut.
  const Trace& trace() const { return trace_; }
  /// Speed of the drive, of its free speed, 0 to 1.
  double driveShare() const;
  /// What the drive has to bear, of what stalls it; 0: nothing stalls it.
  double driveLoadShare() const;
  HapticTimes times() const { return times_; }
  /// Ticks of the 1 kHz thread a second, the mean of the last one. None in the first second.
  std::optional<double> loopHz() const { return loop_rate_.hz(); }
  /// Ends the session: the run is written where sessionFolder() says. A job.
  void close();
  const std::filesystem::path& sessionFolder() const { return session_; }
  /// Of the session that ended last. None: nothing was cut in it.
  const std::optional<RunReport>& lastResult() const { return last_result_; }

  // ---- Watching a session that has ended: sim/run/watched_run.h. Nothing is cut meanwhile: isOpen() is false.

  /// Loads a run and shows its beginning; what was open is finished. A job.
  void watch(const std::filesystem::path& run_folder);
  /// Null: nothing is watched.
  WatchedRun* watched() { return watched_.get(); }
  const WatchedRun* watched() const { return watched_.get(); }
  bool isPlaying() const;
  /// Something is in the picture: it is cut, or watched.
  bool isShown() const { return run_ || watched_; }
  void endWatching();
  /// Opens the run that is watched, to go on cutting from the moment that is shown: before its end that is kept as a
  /// run of its own first.   Error kUnsupported: it is on its way to another moment.
  Expected<void> goOnCutting();
  /// A run that beginImport() was given, until somebody says what to do with it: open() or watch(). None in scripts.
  const std::optional<std::filesystem::path>& askedRun() const { return asked_run_; }
  void forgetAskedRun() { asked_run_.reset(); }

  // ---- Tools

  std::size_t toolCount() const;
  const Tool& tool(std::size_t n) const;
  std::size_t toolInHand() const { return tool_; }
  void selectTool(std::size_t n);
  bool selectTool(const std::string& id);
  /// From the beginning they are read beside the window: update() puts them into the rack, errors are said then. What
  /// is opened meanwhile waits for them in its job.
  bool isReadingTools() const { return rack_ != nullptr; }
  /// Waits for them, for who has no window to show.
  void waitForTools() { takeRack(true); }
  /// So many of the first ones are for a first look; all: a rack of a person's choice.
  std::size_t firstLookTools() const { return first_look_ ? first_look_ : tools_.size(); }
  /// What is wrong with a tool's file, or its mesh, since it was read; null: nothing. The tool is as it was read.
  const Error* toolError(std::size_t n) const;
  using BrokenTool = kerf::BrokenTool;
  const std::vector<BrokenTool>& brokenTools() const { return broken_tools_; }
  /// A tool's file is put into the rack, or read anew, and the tool taken. What is open goes on in a session of its
  /// own: undo reaches back to here. A file that is no tool is refused with what is wrong in it.
  void addTool(const std::filesystem::path& file);
  /// What is shown was opened only to go on with another tool: the view stays.
  bool keepsView() const { return keeps_view_; }

  // ---- By mouse: rays in the world's frame

  double force = 1;       ///< N
  double depth_mm = 0.5;  ///< below the surface as loaded
  double irrigation = 1;  ///< 0 to 1
  double speed = 1;       ///< that the spindle is set to, of the nominal one, 0 to 1
  /// What a stroke leaves between the tool and pulp or nerve canal, mm: it stops short of them. None: it may go into
  /// them, with a warning. A planned cut does not know of it: Sawing::clearance() says what that leaves.
  std::optional<double> stop_short_mm;
  /// Of the tool before it touches, and of the strokes that begin from then on. A blade in a guide knows of none.
  Tilt tilt;
  static constexpr double kLeastForce = 0.1, kMostForce = 8, kMostDepth = 5;

  Measure measure;
  /// What lies on the side its normal points to is neither seen nor pointed at. None: all is.
  std::optional<Plane> section;
  /// A ray from where it comes out of what a section takes away. None: that is inside of something.
  std::optional<Ray> behindSection(const Ray& ray) const;

  /// What the tool would do there; none: it points beside the object, or nothing is open.
  std::optional<ToolOverSurface> over(const Ray& ray) const;
  /// False: there is nothing there to cut.
  bool press(const Ray& ray);
  void drag(const Ray& ray);
  /// Deeper, or less deep, during a stroke or before it, mm.
  void deepen(double mm);
  void setForce(double newtons);
  void setSpeed(double of_nominal);
  void setIrrigation(double of_full);
  /// The drive turns backwards from now on, until another tool is taken. Refused, with what to do, by a drive that goes
  /// one way: an air turbine, a saw, a piezo tip.
  Expected<void> setReversed(bool is_reversed);
  bool isReversed() const { return is_reversed_; }
  bool canReverse() const;
  /// Times the speed, until the stroke ends: how far a trigger is pulled, 0 to 1.
  void drill(double pedal);
  /// Times the force, until it is 1 again.
  void pushHarder(double factor);
  /// Ends the stroke, whoever holds it.
  void release();
  /// The tool goes along its axis by so many mm, in is positive, and stays at that depth until the stroke ends or the
  /// depth is set: between kClearance above the surface as loaded and the depth. Nothing without a stroke.
  void moveAlong(double mm);
  /// Moves the stroke's pointer over the surface as loaded, by so many mm of the picture. Nothing without a stroke.
  void nudge(const Camera& camera, double right_mm, double up_mm);
  /// A foot pedal holds the stroke: it needs no button, and no move of the mouse leads it. Without a stroke one begins.
  /// @param at  what it points at; none: the place that was pressed or dragged to last.
  /// @return  false: there is nothing there to cut.
  bool stepOnPedal(const std::optional<Ray>& at);
  bool isOnPedal() const { return is_on_pedal_; }
  /// Where the stroke's pointer is, world, mm.
  const Vec3d& strokePointer() const { return aim_.pointer; }
  bool isPressed() const { return stroke_.has_value(); }
  /// Depth of the tool below the surface as loaded; none: no stroke.
  std::optional<double> depthNow() const;
  /// How far what goes first of the tool is below the surface as loaded, mm, along the way it goes in, whoever leads
  /// it; negative in air. None: nobody leads it, or there is no surface above or below.
  std::optional<double> tipDepth() const;
  /// Of the same tool.
  std::optional<ToolFront> toolFront() const;
  /// Why the stroke removes nothing and what to do, in English; empty: nothing hinders it.
  const char* hindrance() const { return hindrance_.text(); }
  void stopShort(std::optional<double> mm);
  static constexpr double kMostShort = 5, kUsualShort = 0.5;  ///< mm

  void undo();
  void redo();
  const Timeline& timeline() const { return timeline_; }
  /// Steps that are done when all Undo and Redo that were asked for are: timeline().steps() up to there.
  std::size_t stepsDone() const;
  /// Takes back or does again what lies between now and the end of a step. 0: the beginning. Until that is done nothing
  /// is cut.   @param step  its number, as people see it.
  /// Errors: kUnsupported for one before timeline().older(), or while a plane is sawn; kBadValue for one that is not.
  Expected<void> goToStep(std::uint64_t step);
  /// Other lines than the one that is cut: what was taken back before something else was cut, in this session and in
  /// those it goes on from by a branch, a tool or a neighbour; and what was left for a branch.
  std::vector<Branch> branches() const;
  std::size_t branchCount() const { return left_.size() + timeline_.branches().size(); }
  /// Goes on with one of them, in a session of its own. What is open is written, and is a branch then. A job.
  /// Errors: kEmpty, kBadValue for one that is not; kUnsupported while a plane is sawn.
  Expected<void> takeBranch(std::size_t n);

  // ---- Pieces, by SceneObject::id

  /// A step of undo of its own. Refused with a notice during a stroke, and for a pose that is not usable.
  void movePiece(std::uint32_t id, const Rigid3& T_world_object);
  /// Shows it there, until it is moved or this is called with none.
  void dragPiece(std::uint32_t id, const std::optional<Rigid3>& T_world_object);
  void hidePiece(std::uint32_t id, bool is_hidden);
  void namePiece(std::uint32_t id, const std::string& name);
  /// In the picture, and kept with the session as its name is.   @param colour  of pieceColours(); empty: none.
  void colourPiece(std::uint32_t id, const std::string& colour);
  /// What moves are made of; null: none is chosen, or it is not in the scene.
  const SceneObject* chosenPiece() const;
  void choosePiece(std::optional<std::uint32_t> id) { chosen_ = id; }

  // ---- What stands beside: workbench_neighbours.cpp

  /// The first is opened to be worked on, the others stand beside it, where their scans are: each a scan, prepared with
  /// the default remedies, a recipe or a case. Tools among them go into the rack, one alone is as beginImport().
  /// For a hand that is to decide first: beginImports().
  void openAll(const std::vector<std::filesystem::path>& paths);
  /// What is open goes on in a session of its own, with one more beside: undo reaches back to here. A job.
  void openBeside(const std::filesystem::path& path);
  /// The neighbour of that number is worked on instead, and what was worked on stands beside it, all as in their cases.
  /// What was cut is written first.
  void workOn(std::size_t number);
  std::vector<Neighbour> neighbours() const;
  /// Null: it is not what stands beside.   @param name  or its number.
  const SceneObject* findNeighbour(const std::string& name) const;
  /// Translucent, and not pointed at.
  void ghostNeighbour(std::uint32_t id, bool is_ghost);
  /// The one the tool is nearest to, as nearStructure(). None: there is none.
  std::optional<NearNeighbour> nearNeighbour(const std::optional<ToolOverSurface>& over) const;
  /// What a stroke leaves between the tool and neighbours, mm, as stop_short_mm. None: it may cut them, with a warning.
  std::optional<double> stop_short_beside_mm;
  void stopShortBeside(std::optional<double> mm);
  static constexpr double kUsualShortBeside = 0.2;  ///< mm

  // ---- By a force-feedback device: workbench_hand.cpp

  /// Of one that is not open everything can be asked as well.
  ArmLead& arm() { return *arm_; }
  const ArmLead& arm() const { return *arm_; }
  /// Opens it; what is open to be cut goes on in a session whose coupling it can bear.
  Expected<void> openDevice(const std::string& name);
  /// What is open goes on in a session whose coupling is made for the device as it is now.
  Expected<void> fitToDevice();
  /// The hand, where it is now, means that place of the tool's tip from now on; the tool is put there.
  Expected<void> placeHand(const Vec3d& tip);
  /// The tool follows a device, not the mouse.
  bool isLed() const;

  // ---- By plan

  Sawing& saw() { return *saw_; }
  const Sawing& saw() const { return *saw_; }

  // ---- Results

  /// The post-operative mesh as it is now, read back and compared. A job; the cut may go on.
  void exportTo(const std::filesystem::path& file, const ExportChoice& choice = {});
  /// The same decided step by step, with what a check says before anything is written.
  ExportPlan& exporting() { return *exporting_; }
  const ExportPlan& exporting() const { return *exporting_; }
  /// Something was cut or moved since all of what is worked on was exported last, or it never was: one piece of several
  /// does not count. The session itself is kept all the same. False while an export is being written.
  bool hasUnexportedCut() const;
  double removedMm3() const { return removed_mm3_; }
  /// Of one tissue, in this session, mm^3. In small parts below 0 where a border passes through what was cut.
  double removedOf(Material material) const;

  // ---- What was opened before

  RecentFiles& recent() { return recent_; }
  void forgetRecent(std::size_t n);
  /// What is open: a scan, a recipe or a case. It stays until something else is open.
  const std::filesystem::path& source() const { return source_; }

  // ---- After a crash

  const std::vector<LostSession>& lostSessions() const { return lost_; }
  /// Of its folder, the log above all.
  std::uintmax_t bytesOfLost(std::size_t n) const;
  /// Deletes the folder with its log for good. The caller has asked the user.
  void forgetLost(std::size_t n);
  /// A job: finishes the session from its log; it is then a run for `kerf export`.
  void recover(std::size_t n);

  /// How deep a stroke may go, mm: along a guide right through a jaw.
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
  std::filesystem::path source_;  // what was opened: never written to
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
    std::uint64_t sent = 0;  // answered when that many commands are
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
    std::uint64_t tick = 0;  // when it was last another one
  };
  std::vector<CutOff> cut_off_;                         // of neighbours
  mutable std::map<std::size_t, ToolSamples> samples_;  // of tools that were in hand
  std::vector<Plunge> plunges_;                         // of the same
  std::vector<TouchPoints> touches_;                    // of the same
  ToolTimes toolTimesOf(std::size_t tool) const;
  std::vector<ToolTimes> tool_times_;              // before they were read
  std::vector<std::optional<Error>> tool_errors_;  // since they were read
  std::vector<BrokenTool> broken_tools_;
  std::size_t first_look_ = 0;
  std::unique_ptr<Job<Rack>> rack_;                            // null: it is in the rack
  std::shared_future<std::vector<SessionTool>> coming_tools_;  // of it, for what is opened meanwhile
  std::chrono::steady_clock::time_point next_watch_{};
  std::vector<char> is_outdated_;                  // its file was read anew since something was opened
  bool has_written_ = false, has_failed_ = false;  // the last close()
  bool is_reopening_ = false, keeps_view_ = false;
  std::optional<Stroke> stroke_;
  std::optional<Ray> pointed_;   // last, by a stroke
  std::optional<double> along_;  // depth that the stroke was led to, mm
  bool is_on_pedal_ = false, is_reversed_ = false;
  MouseAim aim_;
  double push_factor_ = 1, drill_ = 1;
  double removed_mm3_ = 0;
  std::uint64_t sent_ = 0;  // commands
  Timeline timeline_;
  std::vector<Branch> left_;                              // branches of sessions that ended before this one
  std::optional<Branch> opened_;                          // that this session goes on from
  std::map<std::uint64_t, std::filesystem::path> saved_;  // EndedSession::saved of the last one
  Trace trace_;
  Hindrance hindrance_;
  std::optional<RunReport> last_result_;
  struct Wish {
    std::uint64_t step = 0;
    std::uint64_t tick = 0;  // from which on the stroke that was ended for it is counted
  };
  std::optional<Wish> wish_;             // of goToStep(), until all that came before it is done
  std::ptrdiff_t undos_left_ = 0;        // to be sent: Redo, or as a negative number Undo
  std::ptrdiff_t strokes_then_ = 0;      // that are done when they all are
  std::uint64_t undos_answered_at_ = 0;  // when so many commands are answered
  bool has_told_of_log_ = false, has_told_that_it_is_led_ = false;
  std::set<std::string> told_thin_;  // tools of this session, by their ids
  bool has_told_of_pulp_ = false, has_told_of_bone_ = false, has_told_of_dead_bone_ = false;  // that they got warm
  /// A job that waits for what it exports: until the last stroke is meshed.
  struct Handover {
    std::promise<SceneView> scene;
    std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();
    std::uint64_t sent = 0;                  // commands until then: answered before anything is handed over
    std::optional<std::uint64_t> done_at{};  // tick at which all that was asked for was done
  };
  std::optional<Handover> handover_;
  std::optional<CutStamp> handed_over_;  // what was, last; none: it was still being cut
  std::optional<CutStamp> exported_;     // last
  bool has_unexported_before_ = false;   // in the session that this one goes on from, for a tool or a neighbour
  std::vector<ObjectChunks> fresh_;      // not handed out yet
  std::unique_ptr<Sawing> saw_;
  std::unique_ptr<ExportPlan> exporting_;
  std::unique_ptr<WatchedRun> watched_;
  bool has_told_of_verdict_ = false;
  std::optional<std::filesystem::path> asked_run_;
};

}  // namespace kerf
