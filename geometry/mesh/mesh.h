// Kerf's triangle mesh: positions, triangles, colours. A plain value.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/base/types.h"

namespace kerf {

using Triangle = std::array<std::uint32_t, 3>;  ///< vertex indices, counter-clockwise seen from outside

/// Indexed triangle mesh. May be open, non-manifold or degenerate, as in files, unless a function requires more;
/// indices are always in range and coordinates finite.
struct Mesh {
  std::vector<Vec3d> vertices;  ///< mm (a freshly read mesh: the file's own unit)
  std::vector<Triangle> triangles;
  std::vector<Rgba8> vertex_colors;  ///< empty, or one per vertex
  std::vector<Rgba8> face_colors;    ///< empty, or one per triangle

  Vec3d corner(std::size_t t, int k) const { return vertices[triangles[t][static_cast<std::size_t>(k)]]; }
  bool hasVertexColors() const { return !vertex_colors.empty(); }
  bool hasFaceColors() const { return !face_colors.empty(); }
};

Box3 bounds(const Mesh& mesh);
/// Twice the area times the unit normal of triangle t, mm^2.
Vec3d doubleAreaVector(const Mesh& mesh, std::size_t t);
double surfaceArea(const Mesh& mesh);  ///< mm^2
/// Signed enclosed volume by the divergence theorem, mm^3: positive for a closed, outward-oriented mesh. Summed about
/// the box's centre, so a scan 200 mm from the origin loses no digits. Meaningless for an open mesh.
double signedVolume(const Mesh& mesh);
/// Appends `other` with its colours; a side without colours gets `fill`.
void append(Mesh& mesh, const Mesh& other, Rgba8 fill = {200, 200, 200, 255});
/// Label per triangle, 0..count-1, of pieces connected through edges, numbered in order of first triangle.
struct Pieces {
  std::vector<std::uint32_t> label;
  std::uint32_t count = 0;
};
Pieces edgeConnectedPieces(const Mesh& mesh);
/// The triangles `keep[t] != 0` with the vertices they use, in the original order; colours follow.
Mesh subset(const Mesh& mesh, const std::vector<char>& keep);

}  // namespace kerf
