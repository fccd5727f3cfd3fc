// From a file to a session for cutting: detects the file's kind, bakes a scan into a case, loads a case as a run.
//
// Long work without a thread of its own: the workbench calls it in a job.
#pragma once

#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"
#include "preprocess/close/scan_trim.h"
#include "sim/monitor/structures.h"
#include "sim/run/session/live_run.h"
#include "sim/run/session/run_branch.h"
#include "ui/app/session/neighbours.h"
#include "ui/app/view/upright.h"

namespace kerf {

struct CloseOptions;

/// Kinds of paths that a user opens.
enum class FileKind {
  kScan,         ///< a mesh file, or an unknown one: only reading it tells
  kLabels,       ///< a label volume of a CT, by its name; or a folder with slices of one and no mesh
  kRecipe,       ///< combines meshes and labels
  kCase,         ///< baked already
  kTool,         ///< for the rack
  kRun,          ///< an ended session: a new one continues it
  kSessionFile,  ///< the same, packed into one file (session_file.h)
};
/// Reads only a manifest or the first lines.
FileKind kindOf(const std::filesystem::path& path);
/// True if a file in it is a mesh, by its name. False if it is no folder.
bool isFolderOfMeshes(const std::filesystem::path& path);

/// Closing of a scan into a solid: the user's part of CloseOptions (preprocess/close/close.h).
struct ClosingChoice {
  enum class Way {
    kAutomatic,  ///< fills holes, adds a base to a missing underside; wraps on failure, with a warning
    kBase,       ///< the longest boundary gets a base, however short it is
    kHolesOnly,  ///< rejects a scan without underside
    kWrap,       ///< an approximation around everything: the last resort
  };
  Way way = Way::kAutomatic;
  bool is_full_base = false;             ///< true: the arch stands on a plate; false: a horseshoe, the walls follow the
                                         ///< rim
  double base_mm = 2;                    ///< thickness of the base below the lowest point of the scan
  double smooth_mm = 12;                 ///< walls have no waves shorter than this; 0: straight under the rim
  bool follows_occlusal_plane = false;   ///< the base is parallel to it
  std::optional<double> holes_up_to_mm;  ///< a longer boundary is no hole; none: closing decides
  double trim_rim_mm = 0;                ///< tongues of the rim narrower than this go; 0: none
  std::vector<ScanTrim> trims{};         ///< parts to cut away first
  double wrap_mm = 1;                    ///< a wrap bridges hollows narrower than this

  bool operator==(const ClosingChoice&) const = default;
};
CloseOptions closeOptionsOf(const ClosingChoice& choice);

/// Preparation of a scan or a recipe.
struct PrepareOptions {
  std::string unit;     ///< "mm", "inch"; empty: from the file, or by its size
  double voxel_mm = 0;  ///< 0: voxelFor() of a scan, that of a recipe
  ClosingChoice closing{};
  /// For a label volume: the text of its recipe. Empty: each label's name gives its tissue.
  std::string recipe{};
};

/// A neighbour to open.
struct OpenBeside {
  std::filesystem::path path;  ///< a scan, a label volume, a recipe or a case
  std::string name{};          ///< empty: that of the file
  PrepareOptions prepare{};    ///< of a scan
};

struct OpeningOptions {
  std::filesystem::path data_folder;  ///< "cases", "sessions" and "demo" are below it
  PrepareOptions prepare;
  std::vector<SessionTool> tools;  ///< of the rack; the first is in hand
  RealTimeRequest real_time;       ///< of the haptic thread
  /// Of a force-feedback device that leads the tool; none: no device leads.
  std::optional<CouplingSettings> coupling{};
  std::vector<OpenBeside> beside{};
  std::vector<std::string> without{};  ///< ids of cases that come not back as neighbours
  /// The rack while it is still being read: opening waits for it and uses it instead of `tools`. Not valid: the rack is
  /// read.
  std::shared_future<std::vector<SessionTool>> coming_tools{};
};

/// A session before its start.
struct Opened {
  std::unique_ptr<LiveRun> run;
  std::vector<std::string> notes;  ///< sentences: changes by preparation, the unit and its reason, the voxel size
  std::string name;                ///< of the file, without its ending
  std::filesystem::path source;    ///< the opened file: never written to
  std::optional<PrepareOptions> prepared;             ///< of a source that was prepared; none: a case or a session
  std::filesystem::path tool;                         ///< to take in hand; empty: the first of the rack
  OcclusalSide occlusal;                              ///< of its solid
  std::shared_ptr<const Structures> structures;       ///< of the case: pulp, nerve canals
  NeighbourFields neighbours;                         ///< of run->neighbours()
  std::vector<std::filesystem::path> sources_beside;  ///< files of the neighbours: never written to
};

/// Opens a case, or prepares a scan or recipe first. Reuses the case of a scan prepared in the same way before. For a
/// label volume it writes a recipe below the data folder and bakes that. For a run it opens the case with all cuts and
/// neighbours; it recovers a session of a killed program first, and the notes say so. It unpacks a session file below
/// the data folder first, unless that session is there already. One jaw of a pair opens with its partner as a
/// neighbour, if that still exists. The notes name a neighbour that hardly fits the frame. Errors: those of reading,
/// closing and loading; kUnsupported for a session that another program works on; those of recoverRun(); kCancelled,
/// which leaves nothing behind.
/// @cost seconds; a jaw at 0.1 mm 10 to 20 s.
Expected<Opened> openToCut(const std::filesystem::path& path, const OpeningOptions& options,
                           const Progress& progress = {});

/// The same for a run at a moment: keeps that state as a new run first and continues from it.
/// Errors: also those of branchRun().   @cost  also that of branchRun().
Expected<Opened> openBranchToCut(const std::filesystem::path& run_folder, const BranchPoint& point,
                                 const OpeningOptions& options, const Progress& progress = {});

/// Message about a recovered session.
std::string tellRecovery(const Recovery& recovery);

/// A new session folder below the data folder.   @param name  of the object.
std::filesystem::path newSessionFolder(const std::filesystem::path& data_folder, const std::string& name);

/// A neighbour as a case: prepares a scan or recipe first.
/// Errors: those of openToCut(); kUnsupported for a session and for a tool.
Expected<std::filesystem::path> prepareToStandBeside(const OpenBeside& asked, const OpeningOptions& options,
                                                     std::vector<std::string>& notes, const Progress& progress = {});

/// Kerf's own anatomy, made at the first request.   @param name  of demoNames().
Expected<Opened> openDemoToCut(const std::string& name, const OpeningOptions& options, const Progress& progress = {});
std::span<const char* const> demoNames();

/// Voxel size for a scan, mm: 0.1, or coarser so that its surface in the window has about 800 000 triangles; 0.25 at
/// most.   @param area_mm2  of the scan.
double voxelFor(double area_mm2);

}  // namespace kerf
