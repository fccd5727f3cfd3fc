// Crumbs made by closing: closed pieces of a solid, far smaller than a voxel and absent from the scan.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf::internal {

struct MadeCrumbs {
  std::vector<char> keep;  ///< per triangle of the solid; empty if there is no crumb
  std::size_t count = 0;
  double volume_mm3 = 0;  ///< volume of all crumbs
};

/// Finds pieces and cavities below `most_mm3` that closing added, cut off or separated.
/// Exceptions: a piece of the scan with at least half its triangles in the solid; the largest piece; a piece around one
/// that stays.
/// @param imported  the scan, mm; may be unwelded.
/// @param solid     closed, 2-manifold, mm.   @param source  per triangle of the solid: triangle of the scan or kAdded.
/// @cost  O(n) without a piece that small. Otherwise that of welding the scan and sorting its edges, and
/// O(log pieces) for each crumb.
MadeCrumbs findMadeCrumbs(const Mesh& imported, const Mesh& solid, std::span<const std::uint32_t> source,
                          double most_mm3);

}  // namespace kerf::internal
