// Print check of a mesh, from a slicer's point of view.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// mm: limits of the longest side of a print-ready mesh. Beyond them the unit is wrong.
inline constexpr double kSmallestPrint = 0.1, kLargestPrint = 2000;

struct MeshCheckOptions {
  bool self_intersections = true;  ///< the most expensive check; without it the result is never print-ready
  /// Count at most so many crossing pairs. A small number is faster on a bad mesh; the verdict stays the same.
  std::size_t max_self_intersections = 1'000'000;
  /// crossingPairs() found none in this mesh with float32 positions: skips the search. Equal positions would be a
  /// crossing, so welding joins nothing.
  bool known_free_of_crossings = false;
};

struct BoundaryLoop {
  std::size_t edges = 0;
  double length = 0;  ///< mm
};

/// All counts follow rounding to float32, as in the printed file, and welding equal positions, the first step of a
/// slicer.
struct MeshReport {
  std::size_t triangles = 0;             ///< as given
  std::size_t vertices = 0;              ///< as given
  std::size_t duplicate_vertices = 0;    ///< vertices lying exactly on an earlier one (used by some triangle); welded
  std::size_t degenerate_triangles = 0;  ///< exactly zero area. Those with a repeated corner count nowhere below
  std::size_t duplicate_triangles = 0;   ///< the same three corners as an earlier one, either way round
  std::size_t boundary_edges = 0;        ///< edges of one triangle
  std::vector<BoundaryLoop> boundary_loops;  ///< chains of boundary edges joined at their ends, longest first
  std::size_t non_manifold_edges = 0;        ///< edges of three or more triangles
  std::size_t non_manifold_vertices = 0;     ///< bow ties: the triangles around the vertex form more than one fan
  std::size_t flipped_edges = 0;             ///< edges whose two triangles run through them in the same direction
  std::size_t pieces = 0;                    ///< connected through edges; the walls of cavities are none
  std::size_t cavities = 0;                  ///< in these pieces
  std::size_t specks = 0;                    ///< specks among the closed pieces; see PieceCount
  double specks_mm3 = 0;                     ///< all specks together
  std::size_t inward_pieces = 0;             ///< closed pieces turned inside out that are not a cavity of another piece
  std::size_t self_intersections = 0;        ///< pairs of triangles that meet where they are not joined
  bool self_intersections_checked = false;
  double area = 0;    ///< mm^2
  double volume = 0;  ///< mm^3, signed; meaningless while there are boundary edges
  Box3 box;           ///< mm, of the vertices in use

  bool isClosed() const { return triangles > 0 && boundary_edges == 0; }
  bool print_ready = false;
  std::vector<std::string> reasons;  ///< reasons against printing; plain sentences, the gravest first. Empty when
                                     ///< print-ready
};

/// Judges `mesh` as printed. Print-ready means: not empty, closed, every edge shared by exactly two triangles that
/// agree in direction, no bow-tie vertex, no degenerate or repeated triangle, no self-intersection, solids turned
/// outwards, positive volume.
/// @pre indices in range, finite coordinates.   @cost O(n log n); 200 000 triangles 0.12 s on two cores.
MeshReport checkMesh(const Mesh& mesh, const MeshCheckOptions& options = {});

/// One JSON object, the fields of MeshReport by name; lengths in mm.
std::string toJson(const MeshReport& report);
/// The same as text: a few lines, the verdict first.
std::string describe(const MeshReport& report);

}  // namespace kerf
