// The solids that a closed mesh bounds: each an outer shell with the cavities in it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf {

struct Solids {
  std::vector<std::uint32_t> label;  ///< per triangle, 0 to count - 1, in order of the first triangle
  std::uint32_t count = 0;
};

/// A cavity belongs to the smallest outer shell around it; one that nothing is around is a solid of its own.
/// @pre closed, each shell outward or, a cavity, inward.   @cost  O(n), and 30 ns a triangle for each cavity.
Solids solidsOf(const Mesh& mesh);

/// The solid whose material is at a point; none: air. A point on the surface may be either.
/// @cost  30 ns a triangle. Van Oosterom & Strackee 1983: the solid angle of a triangle.
std::optional<std::uint32_t> solidAt(const Mesh& mesh, const Solids& solids, const Vec3d& point);

}  // namespace kerf
