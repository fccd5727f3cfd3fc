// Marching cubes on a sparse field: a closed, 2-manifold triangle mesh of the zero set.
//
// After Lorensen & Cline, SIGGRAPH 1987, with a generated table that is consistent on shared faces: on an ambiguous
// face the negative corners stay separate, seen from either side. Hence no holes and no edge with other than two
// triangles, as long as every sign change lies between stored nodes. Loops of six and more corners are closed by a fan
// about their centroid, shorter ones by a fan about their first corner.
#pragma once

#include <algorithm>
#include <compare>

#include "geometry/field/brick_field.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct MarchingCubesOptions {
  /// Moves values nearer to zero than this many voxels away from it (same sign; zero counts as positive), so that no
  /// vertex lands on a node and no triangle collapses. 0.02 costs at most 0.02 voxels of accuracy.
  double snap_voxels = 0.02;
  /// Subtracts this times the field's discrete Laplacian (h^2 times twice the mean curvature) before meshing, 0 = off.
  /// Triangles are chords of the surface and linear interpolation moves their corners further in: a plain mesh of a
  /// ball of radius r is short by about 0.5 (h/r)^2 of its volume. The default places the mesh as much outside as
  /// inside. Flat walls do not change; too large a value (> 0.16) makes the field oscillate.
  float chord_balance = 0.1f;
};

/// A brick with the 26 around it: the input of its cells. The cells of a brick are those whose lowest corner is one of
/// its nodes; with their corners and the corners' neighbours (chord_balance) they reach from one node below the brick
/// to two above it.
struct BrickNeighbours {
  Vec3i brick = Vec3i::Zero();  ///< brick coordinate
  double voxel = 0;             ///< mm
  float clamped = 0;            ///< smallest |value| that a constant stands for, mm
  /// In the order of (dx, dy, dz) + 1 with z fastest; null where the field is `constant`.
  std::array<const BrickValues*, 27> values{};
  std::array<float, 27> constant{};
};

/// @param field  BrickField, or anything with its valuesAt(), constantAt(), voxel(), background() and interior().
/// Views, does not own.
template <class Field>
BrickNeighbours neighboursOf(const Field& field, const Vec3i& brick) {
  BrickNeighbours out;
  out.brick = brick;
  out.voxel = field.voxel();
  out.clamped = std::min(field.background(), -field.interior());
  for (int n = 0; n < 27; ++n) {
    const Vec3i c = brick + Vec3i{n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1};
    const auto at = static_cast<std::size_t>(n);
    out.values[at] = field.valuesAt(c);
    out.constant[at] = out.values[at] ? 0 : field.constantAt(c);
  }
  return out;
}

/// The part of a surface that lies in the cells of one brick.
struct BrickSurface {
  /// Place of a vertex: a grid edge (its lower node, axis 0..2) or the middle of a loop of a cell (the cell's lowest
  /// node, 3 + loop). Bricks with a common vertex give it the same name and, bit for bit, the same position and normal.
  struct Name {
    std::uint64_t node = 0;
    std::uint32_t what = 0;
    auto operator<=>(const Name&) const = default;
  };
  std::vector<Name> names;          ///< one per vertex, each once
  std::vector<Vec3d> positions;     ///< mm
  std::vector<Vec3f> normals;       ///< unit, outward, of the field's gradient; empty unless requested
  std::vector<Triangle> triangles;  ///< counter-clockwise seen from outside
};

/// Marching cubes of one brick's cells, as marchingCubes() does for every brick. Replaces `out` and reuses its memory.
/// About 1 us away from the surface (comparison of values only), 20 us at the surface.
void marchingCubesOfBrick(const BrickNeighbours& field, const MarchingCubesOptions& options, bool with_normals,
                          BrickSurface& out);

/// Surface of {field < 0}, outward-oriented, mm. Vertices and triangles come in an order that depends on the field
/// only. O(stored bricks); parallel inside.
Mesh marchingCubes(const BrickField& field, const MarchingCubesOptions& options = {});

}  // namespace kerf
