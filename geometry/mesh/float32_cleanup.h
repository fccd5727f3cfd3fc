// Rounds a closed mesh to single precision and keeps it valid, without moving fixed vertices.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct CleanupReport {
  std::size_t collapsed = 0;       ///< edges collapsed
  std::size_t flipped = 0;         ///< edges flipped
  std::size_t relaxed = 0;         ///< moves of free vertices towards their neighbours, against a crossing
  int targeted_rounds = 0;         ///< rounds that worked on crossing pairs only
  double largest_move_mm = 0;      ///< largest move of a moved or merged vertex, rounding included
  std::size_t crossings_left = 0;  ///< pairs of triangles that still meet where they should not (crossingPairs)
  std::vector<std::array<std::uint32_t, 2>> pairs_left{};  ///< these pairs
  std::size_t fixed_moved = 0;  ///< fixed vertices not representable in float32, and so rounded
};

/// What the caller knows of the triangles all of whose corners are fixed.
enum class FixedPart {
  kMayCross,
  kFreeOfCrossings,  ///< no two of them cross: they come from an exact arrangement. Spares most of the search
};

/// Rounds a closed 2-manifold to float32 coordinates and repairs the damage. The recipe, measured on 823 exports: (a)
/// collapse edges shorter than `length_mm`, shortest first, with at least one free end, under the link condition,
/// unless a surrounding normal would turn by more than 60 degrees; (b) flip the longest edge of needles lower than a
/// tenth of it that have a free vertex (or no area at all), if both new normals stay within 25 degrees of the
/// neighbour's; (a), (b) again; (c) while triangles cross: 1.6 times the length, on the crossing triangles only, at
/// most 8 rounds; from the third round on their free vertices also move towards the mean of their neighbours, by at
/// most that length.
/// @param mesh          closed, 2-manifold (keeps edges with other than two triangles); vertex and face
///                      colours follow.
/// @param fixed_vertex  one flag per vertex: never moves, never vanishes. Follows the vertices: on return one per
///                      vertex left.
/// @param face_tag      optional label per triangle; follows the triangles. A flip keeps the labels of the two.
/// @param length_mm     e.g. 1e-3 (0.01 voxel); at most 2.6 times as much in (c) rounds 1-2, 43 times in round 8.
/// @return counts; `crossings_left` has the remaining crossings. Errors: sizes that do not fit, non-finite coordinates.
/// Vertices and triangles keep their order; vertices no triangle uses are dropped unless fixed.
/// @cost about 65-100 ms per 60k triangles, and one crossingPairs(); see FixedPart. @thread any; deterministic.
Expected<CleanupReport> cleanUpForFloat32(Mesh& mesh, std::vector<char>& fixed_vertex,
                                          std::vector<std::uint32_t>* face_tag, double length_mm,
                                          FixedPart fixed_part = FixedPart::kMayCross);

}  // namespace kerf
