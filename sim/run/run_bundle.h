// The run bundle: a folder that holds one cutting session on a case.
//
//   run.toml     manifest: case, tool, path, what came of it
//   tool.toml    the tool as used, with its mesh if it has one        path.csv | path.toml   the path as used
//   run.vdb      grids phi (the cut field, bricks that changed) and, geometry only, sweep (union of tool sweeps, mm);
//                beside_1, beside_2, ...: phi of further cases that stood beside the one that was cut
//   forces.csv, summary.json   of a cut against resistance: haptic_cut.h
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/boolean/post_op_mesh.h"
#include "geometry/case/case_bundle.h"
#include "geometry/field/brick_field.h"

namespace kerf {

inline constexpr const char* kRunManifest = "run.toml";
inline constexpr const char* kModeGeometry = "geometry";  ///< the tool removed whatever it swept
inline constexpr const char* kModeHaptic = "haptic";      ///< cut against resistance, by the 1 kHz step

struct RunManifest {
  int version = 1;
  std::string kerf_version;
  std::string case_path;  ///< relative to the run folder, or absolute
  std::string case_id;    ///< must match the case
  std::string mode = kModeGeometry;
  std::string tool_id, tool_sha256, path_file, path_sha256;
  std::size_t segments = 0;  ///< cutting motions
  double path_length_mm = 0, duration_s = 0;
  double voxel_mm = 0;
  std::string state_hash;    ///< 16 hexadecimal digits, of the sweep field or of the step's state: same inputs, same
  std::string field_sha256;  ///< of run.vdb: a damaged file is refused
  /// A further case of the same scene, cut against resistance only. It stood where its scan stands.
  struct Beside {
    std::string case_path, case_id;  ///< as those of the case
    double voxel_mm = 0;
    double removed_mm3 = 0;  ///< what was cut off it
  };
  std::vector<Beside> beside;  ///< the first is "beside_1": neighbourId(1)
  /// Not stored: how far a cut that met the case's fine region reaches out of it, mm; then it was cut on the object's
  /// own voxels. 0: no region, or inside.
  double beyond_region_mm = 0;
};

bool isRun(const std::filesystem::path& folder);
Expected<RunManifest> readRunManifest(const std::filesystem::path& folder);

/// The folder of the case a run was cut from. An error if it is not there, or was baked anew since.
Expected<std::filesystem::path> caseOfRun(const std::filesystem::path& run_folder);
/// The same of the cases that stood beside it, in their order; none in most runs.
Expected<std::vector<std::filesystem::path>> casesBesideRun(const std::filesystem::path& run_folder);
/// The union of the tool's sweeps, mm, negative where the tool has been; cut out of the case's field it is the cut
/// object. Checked against the manifest. At the voxel size the run was cut at: the case's, or its region's finer one.
/// Only of a run cut geometry-only.
Expected<BrickField> readRunSweep(const std::filesystem::path& run_folder);
/// The cut field phi, mm, in the bricks where it differs from the baked one; of either kind of run.
/// @param beside  0: of the case; n: of the n-th case beside it, which may have no such bricks.
Expected<BrickField> readRunCutField(const std::filesystem::path& run_folder, std::size_t beside = 0);

struct CutOptions {
  bool overwrite = false;
};
/// Cuts a case along a path in lockstep, geometry only, and writes the run.
/// A cut that stays within the case's fine region is computed on the fine grid, any other one on the object's.
/// @param tool_file  a tool's TOML file.
/// @param path_file  CSV of poses or TOML of strokes: docs/reference/path-files.md.
///
/// Errors name the file; a tool that never meets the object is an error too (kEmpty): most often a wrong frame or unit.
Expected<RunManifest> cutCase(const std::filesystem::path& case_folder, const std::filesystem::path& tool_file,
                              const std::filesystem::path& path_file, const std::filesystem::path& run_folder,
                              const CutOptions& options = {}, const Progress& progress = {});

/// How far the cut walls of an exported mesh lie from the exact sweep of the tool, at the vertices.
struct WallAccuracy {
  std::size_t vertices = 0;
  double rms_mm = 0, max_mm = 0;
};

struct Export {
  PostOpMesh post_op;
  WallAccuracy accuracy;         ///< vertices = 0 for a case without a cut
  std::string accuracy_missing;  ///< why the walls could not be measured; empty if they were, or there is no cut
};

/// The post-operative mesh of a run, or the solid of a case.
/// @param beside  0: the case that was cut; n: the n-th case that stood beside it, with what was cut off that.
Expected<Export> exportBundle(const std::filesystem::path& run_or_case, const PostOpOptions& options = {},
                              const Progress& progress = {}, std::size_t beside = 0);

}  // namespace kerf
