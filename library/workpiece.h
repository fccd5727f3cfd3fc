// A solid in memory that can be cut, and its cuts. The same functions as the commands bake, cut and export of `kerf`:
// the same input gives the same mesh, bit for bit.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/case/case_bundle.h"
#include "preprocess/bake/bake.h"
#include "sim/hand/path.h"
#include "sim/run/cut/cut_remarks.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/report/run_series.h"

namespace kerf {

/// A tool of the rack, of a file, or from text.
struct ToolChoice {
  std::string id_or_file;  ///< empty: `text`
  std::string text;        ///< content of a tool file (assets/tools/README.md)

  static ToolChoice named(std::string id) { return {std::move(id), {}}; }  ///< of the rack: "856-016"; or a TOML file
  static ToolChoice ofText(std::string toml) { return {{}, std::move(toml)}; }
};

/// The path of a tool, from a file or from poses.
struct PathChoice {
  std::filesystem::path path;  ///< empty: `poses`
  std::vector<PathPose> poses;

  /// CSV of poses or TOML of strokes: docs/reference/path-files.md.
  static PathChoice file(std::filesystem::path file) { return {std::move(file), {}}; }
  /// Every motion from pose to pose cuts. At least two, times increasing.
  static PathChoice ofPoses(std::vector<PathPose> poses) { return {{}, std::move(poses)}; }
};

struct CutRequest {
  /// Set: a virtual hand holds the tool against resistance, as `kerf cut --hand`. Else the tool removes its volume.
  std::optional<HapticCutOptions> hand{};
};

/// A finished cut. Copies share the run. It keeps its model alive.
class WorkpieceCut {
 public:
  PostOpMesh post_op;                    ///< the mesh, its cut walls, and counts of the vertices of the source
  WallAccuracy accuracy;                 ///< of the cut walls, from the exact sweep of the tool
  double removed_mm3 = 0;                ///< of the mesh
  std::vector<CutRemark> remarks;        ///< all that `kerf cut` says
  std::optional<HapticSummary> summary;  ///< of a cut against resistance

  /// Forces, speed, temperature and distances at every tick of a cut against resistance. Error kUnsupported without.
  Expected<RunSeries> series(const Progress& progress = {}) const;
  /// Writes the run as a folder that `kerf` and the window open.
  /// Errors: kUnsupported as long as the model has no folder (Workpiece::save()); kWriteFailed; an existing folder.
  Expected<void> save(const std::filesystem::path& run_folder) const;

 private:
  friend class Workpiece;
  struct State;
  std::shared_ptr<State> state_;
};

/// A solid with its distance field. Copies share it. Until save() it lives in the folder for temporary files, and goes
/// with its last copy and the last of its cuts. Several threads may use it at once.
class Workpiece {
 public:
  /// Opens a case.   Errors: as readCaseManifest().
  static Expected<Workpiece> open(const std::filesystem::path& case_folder);
  /// Closes the surface and bakes the field, as `kerf bake` does with a file of this mesh.
  /// @param options  `unit` empty: judged by size.   Errors: as kerf::bake().   @cost as kerf::bake().
  static Expected<Workpiece> bake(const Mesh& mesh, const BakeOptions& options = {}, const Progress& progress = {});

  const CaseManifest& manifest() const;
  /// What closing and baking did. Null for a model that was opened.
  const BakeReport* report() const;
  /// Doubts about unit, closing and voxels; empty: none.
  std::vector<std::string> warnings() const;
  /// The closed solid, mm.
  Expected<Mesh> solid() const;
  /// Signed distance to the solid's surface, mm, negative inside; beyond the band of the field (about 3 voxels outside)
  /// the value stays at the end of the band.   @cost  the first call reads the field: seconds for a jaw.
  Expected<std::vector<double>> distance(std::span<const Vec3d> points) const;

  /// Writes the case as a folder; from then on the model is there.   Errors: kWriteFailed; an existing folder.
  Expected<void> save(const std::filesystem::path& case_folder);
  /// The folder of the case; that for temporary files before save().
  std::filesystem::path folder() const;

  /// Cuts and makes the mesh. The model stays as it is.
  /// Errors: as cutCase(), cutCaseByHand() and exportBundle(): kEmpty for a tool that never meets the solid.
  Expected<WorkpieceCut> cut(const ToolChoice& tool, const PathChoice& path, const CutRequest& request = {},
                             const Progress& progress = {}) const;

 private:
  friend class WorkpieceCut;
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace kerf
