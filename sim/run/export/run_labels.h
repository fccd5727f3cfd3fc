// The tissues of a run or case as voxels, for a segmentation file: each tissue after the cut, and the removed volume.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/formats/segmentation_file.h"

namespace kerf {

/// Number of the removed volume in a segmentation: no material has it.
inline constexpr std::uint16_t kRemovedNumber = 31;
/// Step between the numbers of pieces: 2 * kPieceNumbers + 1 is enamel in piece 2.
inline constexpr std::uint16_t kPieceNumbers = 256;

struct RunLabels {
  Segmentation segmentation;

  /// A volume in voxels, and as the ledger counts it: surface nodes there count in part.
  struct Volume {
    std::string name;
    std::uint64_t voxels = 0;
    double voxels_mm3 = 0, ledger_mm3 = 0;
  };
  std::vector<Volume> tissues;    ///< left in the object, all pieces together
  std::optional<Volume> removed;  ///< none: of a case
  std::vector<Volume> pieces;  ///< of a session with several, in its order; else of a cut that divided, largest first
  std::uint64_t loose_voxels = 0;  ///< connected to no piece: crumbs
  bool has_moved = false;          ///< some piece was moved: its voxels are at its place in the scan
  double fine_mm = 0;              ///< voxel size of the region in which the run cut, resampled here; 0: none
};

/// A voxel belongs to the object if its centre does: phi < 0, trilinear between nodes. It has the material of the
/// nearest node inside. The removed volume is {phi0 < 0 <= phi}. Faces of plane cuts without kerf take no voxel.
/// @param grid  empty: the nodes of the case's field, around the object.
/// @param beside  as in exportBundle().
/// Errors: those of reading the bundle; kUnsupported for a grid that needs more than 4/5 of the free memory.
/// @cost  2 bytes a node of the object's box and a voxel of the grid; 20 ns each.
Expected<RunLabels> labelsOfBundle(const std::filesystem::path& run_or_case, const std::optional<VoxelGrid>& grid = {},
                                   const Progress& progress = {}, std::size_t beside = 0);

}  // namespace kerf
