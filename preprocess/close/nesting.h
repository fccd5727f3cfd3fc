// Nesting of the closed pieces of a mesh: solids, voids in them, solids in the voids.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf::internal {

/// All pieces at one depth of nesting: 0 = outermost, 1 = void in one, 2 = solid in a void ...
struct NestingLevel {
  std::vector<std::uint32_t> triangles;
  bool is_void = false;
};

/// Outermost first. A piece of a crossing-free solid is a void exactly if its signed volume is negative. @cost O(n log
/// n) unless very many boxes lie in each other.
/// @pre mesh closed, oriented, free of self-intersections.
std::vector<NestingLevel> nestingLevels(const Mesh& mesh);

}  // namespace kerf::internal
