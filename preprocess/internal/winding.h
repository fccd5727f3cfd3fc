// Generalized winding number of a triangle chain, summed exactly over all triangles.
#pragma once

#include <span>

#include "geometry/mesh.h"

namespace kerf::internal {

/// Sum of the signed solid angles of the triangles seen from p, over 4 pi: 1 inside a closed outward surface, 0
/// outside. Triangles t with skip[t] != 0 are left out (skip may be empty). After van Oosterom & Strackee, IEEE Trans.
/// Biomed. Eng. 30, 1983, and Jacobson, Kavan & Sorkine-Hornung, SIGGRAPH 2013. Cost: 30 ns per triangle.
double windingNumber(const Mesh& mesh, const Vec3d& p, std::span<const char> skip = {});
/// The same, leaving out the few triangles listed.
double windingNumberExcept(const Mesh& mesh, const Vec3d& p, std::span<const std::uint32_t> except);

}  // namespace kerf::internal
