// Mesh files or a case recipe -> case bundle: read, choose the unit, close, voxelize, write. The whole offline stage
// for one object.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/case/case_bundle.h"
#include "geometry/mesh/mesh_check.h"
#include "geometry/mesh/solids.h"
#include "preprocess/close/close.h"
#include "preprocess/voxelize/voxelize.h"

namespace kerf {

struct BakeOptions {
  std::string unit;    ///< empty: chooseUnit()
  CloseOptions close;  ///< its cleanup length is set to a hundredth of a voxel
  VoxelizeOptions voxelize;
  std::optional<CasePair> pair;  ///< recorded in the manifest; see bakePair()
  /// Finer grids there too; goes before a recipe's region. A voxel size of 0 means half the object's.
  std::optional<FineRegion> region;
  bool voxel_is_given = false;  ///< `voxelize.voxel_mm` goes before a recipe's voxel
  /// Bake again and replace an existing case. Without it a case of the same inputs and settings is left as it is, and
  /// any other case is an error.
  bool overwrite = false;
};

/// Seconds. `check` is only what checking took longer than closing, beside which it runs.
struct BakeTimes {
  double read = 0, check = 0, close = 0, voxelize = 0, write = 0;
  double total() const { return read + check + close + voxelize + write; }
};

/// How two jaws that are to share a frame lie to each other.
struct PairCheck {
  std::optional<double> planes_disagree_deg;  ///< angle between the occlusal planes; set if both were found
  double boxes_apart_mm = 0;                  ///< gap between the boxes
  double overlap_mm = 0;                      ///< how far the jaws reach into each other along the occlusal normal
  std::vector<std::string> notes, warnings;   ///< sentences
};

struct BakeReport {
  CaseManifest manifest;
  std::vector<MeshReport> source_checks;        ///< defects as found, per source, in mm
  std::vector<std::vector<std::string>> notes;  ///< of the readers, per source
  std::vector<bool> unit_is_doubtful;
  CloseReport close;                    ///< of the object; its warnings are those of a recipe's parts too
  std::optional<PairCheck> pair_check;  ///< set by bakePair()
  PieceCount pieces;                    ///< of the solid
  bool was_up_to_date = false;          ///< the case was there already; only `manifest` and `pieces` are filled
  BakeTimes times;
};

/// Bakes one or several meshes, united, into a case folder. The case appears complete or not at all; a cancelled or
/// failed bake leaves nothing behind. Errors name the file and what to try. Parallel inside.
Expected<BakeReport> bake(const std::vector<std::filesystem::path>& meshes, const std::filesystem::path& case_folder,
                          const BakeOptions& options, const Progress& progress = {});

/// Bakes what a recipe (preprocess/bake/case_recipe.h) puts together. Its meshes share one unit unless they declare
/// their own. The object is the union of the outline meshes and labels, exact where possible; where parts almost touch
/// and no exact union exists, it is rebuilt from their distance fields (preprocess/voxelize/voxel_union.h), which the
/// report says.
Expected<BakeReport> bakeRecipe(const std::filesystem::path& recipe, const std::filesystem::path& case_folder,
                                const BakeOptions& options, const Progress& progress = {});

/// What the user of a case should know before anything is cut, sentences: what closing warned of, a shrink-wrap, parts
/// that got nothing, surface that the voxels are too coarse for. Not of doubtful units, which doubtsOfUnits() tells.
std::vector<std::string> warningsOf(const BakeReport& report);
/// A sentence for each source whose unit was guessed and could be another.
std::vector<std::string> doubtsOfUnits(const BakeReport& report);

/// Of the warnings that a case keeps those of closing it.   @pre  manifest.warnings is set.
std::vector<std::string> closingWarningsOf(const CaseManifest& manifest);

/// For people: what was read, assumed, changed and made.
std::string describe(const BakeReport& report);

}  // namespace kerf
