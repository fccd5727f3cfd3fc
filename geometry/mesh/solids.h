// The solids that a closed mesh bounds: each an outer shell with the cavities in it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf {

struct Solids {
  std::vector<std::uint32_t> label;  ///< per triangle, 0 to count - 1, in order of the first triangle
  std::uint32_t count = 0;
};

/// A cavity belongs to the smallest outer shell around it; a cavity without one is a separate solid.
/// @pre closed, each shell outward or, a cavity, inward.   @cost  O(n), and 30 ns a triangle for each cavity.
Solids solidsOf(const Mesh& mesh);

/// The solids one by one, each a subset().   @cost  O(n log n).
std::vector<Mesh> separated(const Mesh& mesh, const Solids& solids);

inline constexpr double kLargestSpeck = 1;       ///< mm3
inline constexpr double kSpeckOfLargest = 0.01;  ///< share of the largest piece's volume

/// Number of pieces of a closed mesh; the wall of a cavity is no piece.
struct PieceCount {
  std::size_t pieces = 0;    ///< shells of positive volume
  std::size_t cavities = 0;  ///< shells of negative volume
  std::size_t specks = 0;    ///< pieces below kLargestSpeck and below kSpeckOfLargest of the largest
  double specks_mm3 = 0;     ///< all specks together
};

/// @param volumes_mm3  signed, of the shells.
PieceCount countPieces(std::span<const double> volumes_mm3);
/// @pre closed, each shell outward or, a cavity, inward.   @cost  O(n).
PieceCount countPieces(const Mesh& mesh);

/// "1 piece", "37 pieces, 36 of them specks (below 1 mm3, 3.2 mm3 together)", "1 piece with 2 cavities".
std::string describe(const PieceCount& count);

/// The solid with material at a point; empty: air. A point on the surface may be either.
/// @cost  30 ns a triangle. Van Oosterom & Strackee 1983: the solid angle of a triangle.
std::optional<std::uint32_t> solidAt(const Mesh& mesh, const Solids& solids, const Vec3d& point);

/// True if a ray from the point crosses the surface an odd number of times: nested shells alternate between solid and
/// air.
/// @pre closed. A point on the surface may be either.   @cost  30 ns a triangle, as solidAt().
bool isInside(const Mesh& mesh, const Vec3d& point);

}  // namespace kerf
