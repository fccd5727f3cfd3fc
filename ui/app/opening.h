// From a file to a session that can be cut: what the file is, a scan baked into a case, a case loaded as a run.
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
#include "sim/monitor/structures.h"
#include "sim/run/live_run.h"
#include "sim/run/run_branch.h"
#include "ui/app/neighbours.h"
#include "ui/app/upright.h"

namespace kerf {

struct CloseOptions;

/// What can stand behind a path that a user opens.
enum class FileKind {
  kScan,    ///< a mesh file, or what will be refused as none: only reading it tells
  kLabels,  ///< a label volume of a CT, by its name; or a folder that holds slices of one, and no mesh
  kRecipe,  ///< puts meshes and labels together
  kCase,    ///< baked already
  kTool,    ///< for the rack
  kRun,     ///< a session that has ended: a new one goes on from it
};
/// Reads a manifest or the first lines, no more.
FileKind kindOf(const std::filesystem::path& path);
/// Some file in it is a mesh, by its name. False of what is no folder.
bool isFolderOfMeshes(const std::filesystem::path& path);

/// How a scan becomes a solid: what of CloseOptions (preprocess/close/close.h) a user decides.
struct ClosingChoice {
  enum class Way {
    kAutomatic,  ///< holes are filled, a missing underside gets a base; what fails is wrapped, with a warning
    kBase,       ///< the longest boundary gets a base, however short it is
    kHolesOnly,  ///< a scan without underside is refused
    kWrap,       ///< an approximation around everything: the last resort
  };
  Way way = Way::kAutomatic;
  bool is_full_base = false;             ///< the arch stands on a plate; false: a horseshoe, the walls follow the rim
  double base_mm = 2;                    ///< thickness of the base below the lowest point of the scan
  double smooth_mm = 12;                 ///< walls have no waves shorter than this; 0: straight under the rim
  bool follows_occlusal_plane = false;   ///< the base is parallel to it
  std::optional<double> holes_up_to_mm;  ///< a longer boundary is no hole; none: as closing decides
  double wrap_mm = 1;                    ///< hollows narrower than this are bridged by a wrap

  bool operator==(const ClosingChoice&) const = default;
};
CloseOptions closeOptionsOf(const ClosingChoice& choice);

/// How a scan or a recipe is prepared.
struct PrepareOptions {
  std::string unit;     ///< "mm", "inch"; empty: as the file says, or by its size
  double voxel_mm = 0;  ///< 0: voxelFor() of a scan, that of a recipe
  ClosingChoice closing{};
  /// Of a label volume: the text of the recipe it is baked by. Empty: every label is what its name says it is.
  std::string recipe{};
};

/// What stands beside.
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
  /// Of a force-feedback device that is to lead the tool and be felt; none: no arm is led.
  std::optional<CouplingSettings> coupling{};
  std::vector<OpenBeside> beside{};
  /// The rack while it is still being read: waited for, and taken in the place of `tools`. Not valid: it is not.
  std::shared_future<std::vector<SessionTool>> coming_tools{};
};

/// A session that has not been started yet.
struct Opened {
  std::unique_ptr<LiveRun> run;
  std::vector<std::string> notes;  ///< sentences: what preparing changed, the unit and its reason, the voxel size
  std::string name;                ///< of the file, without its ending
  std::filesystem::path source;    ///< what was opened: never written to
  OcclusalSide occlusal;           ///< of its solid
  std::shared_ptr<const Structures> structures;       ///< of the case: pulp, nerve canals
  NeighbourFields neighbours;                         ///< of run->neighbours()
  std::vector<std::filesystem::path> sources_beside;  ///< what they were opened from: never written to
};

/// Opens a case, or prepares a scan or recipe first. A scan that was prepared in the same way before is not baked
/// again. Of a label volume a recipe is written below the data folder, and baked. Of a run the case is opened, with all
/// that was cut, and what stood beside it. One jaw of a pair is opened with its partner beside, if that is there still.
/// A neighbour that hardly fits the frame is said in the notes. Errors: those of reading, closing and loading;
/// kUnsupported for a session that has not ended; kCancelled, and then nothing is left behind.
/// @cost seconds; a jaw at 0.1 mm 10 to 20 s.
Expected<Opened> openToCut(const std::filesystem::path& path, const OpeningOptions& options,
                           const Progress& progress = {});

/// The same of a run as it was at a moment: that is kept as a run of its own first, and the session goes on from it.
/// Errors: also those of branchRun().   @cost  also that of branchRun().
Expected<Opened> openBranchToCut(const std::filesystem::path& run_folder, const BranchPoint& point,
                                 const OpeningOptions& options, const Progress& progress = {});

/// A new folder for a session, below the data folder.   @param name  of what is cut.
std::filesystem::path newSessionFolder(const std::filesystem::path& data_folder, const std::string& name);

/// What is to stand beside, as a case: a scan or recipe is prepared first.
/// Errors: those of openToCut(); kUnsupported for a session and for a tool.
Expected<std::filesystem::path> prepareToStandBeside(const OpenBeside& asked, const OpeningOptions& options,
                                                     std::vector<std::string>& notes, const Progress& progress = {});

/// Our own anatomy: made when it is first asked for.   @param name  of demoNames().
Expected<Opened> openDemoToCut(const std::string& name, const OpeningOptions& options, const Progress& progress = {});
std::span<const char* const> demoNames();

/// Voxel size for a scan, mm: 0.1, or so much more that its surface is about 800 000 triangles in the window; 0.25 at
/// most.   @param area_mm2  of the scan.
double voxelFor(double area_mm2);

}  // namespace kerf
