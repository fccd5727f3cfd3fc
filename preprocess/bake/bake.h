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
  /// Adds finer grids there; overrides a recipe's region. A voxel size of 0 means half the object's.
  std::optional<FineRegion> region;
  bool voxel_is_given = false;  ///< `voxelize.voxel_mm` overrides a recipe's voxel
  /// Bake again and replace an existing case. If false, a case of the same inputs and settings stays unchanged, and any
  /// other case is an error.
  bool overwrite = false;
};

/// Seconds. Checking runs beside closing; `check` is only its excess time.
struct BakeTimes {
  double read = 0, check = 0, close = 0, voxelize = 0, write = 0;
  double total() const { return read + check + close + voxelize + write; }
};

/// Relative position of two jaws with a common frame.
struct PairCheck {
  std::optional<double> planes_disagree_deg;  ///< angle between the occlusal planes; set if both were found
  double boxes_apart_mm = 0;                  ///< gap between the boxes
  double overlap_mm = 0;                      ///< overlap of the jaws along the occlusal normal
  std::vector<std::string> notes, warnings;   ///< sentences
};

struct BakeReport {
  CaseManifest manifest;
  std::vector<MeshReport> source_checks;        ///< defects found, per source, in mm
  std::vector<std::vector<std::string>> notes;  ///< notes of the readers, per source
  std::vector<bool> unit_is_doubtful;
  CloseReport close;                    ///< report of the object; includes the warnings of a recipe's parts
  std::optional<PairCheck> pair_check;  ///< set by bakePair()
  PieceCount pieces;                    ///< pieces of the solid
  bool was_up_to_date = false;          ///< the case existed already; only `manifest` and `pieces` are filled
  BakeTimes times;
};

/// Bakes one or several meshes, united, into a case folder. The case appears complete or not at all; a cancelled or
/// failed bake leaves nothing behind. Errors name the file and a remedy. Parallel inside.
Expected<BakeReport> bake(const std::vector<std::filesystem::path>& meshes, const std::filesystem::path& case_folder,
                          const BakeOptions& options, const Progress& progress = {});

/// Bakes the object of a recipe (preprocess/bake/case_recipe.h). Its meshes share one unit unless they declare their
/// own. The object is the union of the outline meshes and labels, exact where possible. If parts almost touch and no
/// exact union exists, bakeRecipe() rebuilds it from their distance fields (preprocess/voxelize/voxel_union.h), and
/// reports it.
Expected<BakeReport> bakeRecipe(const std::filesystem::path& recipe, const std::filesystem::path& case_folder,
                                const BakeOptions& options, const Progress& progress = {});

/// Warnings for the user of a case before any cut, as sentences: warnings of closing, a shrink-wrap, parts without
/// volume, surface too fine for the voxels. doubtsOfUnits() reports doubtful units separately.
std::vector<std::string> warningsOf(const BakeReport& report);
/// A sentence for each source with an ambiguous guessed unit.
std::vector<std::string> doubtsOfUnits(const BakeReport& report);

/// Warnings of closing among the warnings of a case.   @pre  manifest.warnings is set.
std::vector<std::string> closingWarningsOf(const CaseManifest& manifest);

/// Report for display: inputs, assumptions, changes and results.
std::string describe(const BakeReport& report);

}  // namespace kerf
