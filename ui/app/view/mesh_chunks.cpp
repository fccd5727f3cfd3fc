#include "ui/app/view/mesh_chunks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "geometry/mesh/shading_normals.h"

namespace kerf {
namespace {

constexpr std::size_t kMostVertices = 65536, kMostTriangles = kMostVertices / 3;
constexpr int kFarthest = 1 << 30;  // cell: triangles beyond it belong to it
constexpr Rgba8 kIvoryColour = {233, 221, 197, 255};
constexpr std::uint8_t kGloss = 150;

using Cell = std::array<int, 3>;
using TrianglesOf = std::map<Cell, std::vector<std::size_t>>;

/// A drawn vertex: a mesh vertex with one of its normals and colours.
using VertexKey = std::tuple<std::uint32_t, std::array<float, 3>, Rgba8>;

int cellAt(double mm, double cell) {
  return static_cast<int>(std::min(std::max(std::floor(mm / cell), double{-kFarthest}), double{kFarthest}));
}

TrianglesOf byCell(const Mesh& mesh, double cell) {
  TrianglesOf out;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3d middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
    out[{cellAt(middle[0], cell), cellAt(middle[1], cell), cellAt(middle[2], cell)}].push_back(t);
  }
  return out;
}

// Divides oversized cells by triangle count: smaller cells would not separate triangles on one spot, and would leave
// every other triangle a chunk of its own. The parts get unused cells beyond the farthest one.
void divide(TrianglesOf& triangles_of) {
  TrianglesOf parts;
  int next = kFarthest;
  for (auto& [at, triangles] : triangles_of) {
    while (triangles.size() > kMostTriangles) {
      const auto from = triangles.end() - static_cast<std::ptrdiff_t>(kMostTriangles);
      parts[{++next, 0, 0}].assign(from, triangles.end());
      triangles.erase(from, triangles.end());
    }
  }
  triangles_of.merge(parts);
}

}  // namespace

std::vector<ColouredChunk> chunksOf(const Mesh& mesh, double cell) {
  const std::vector<Vec3f> normals = cornerNormals(mesh, 40 * std::numbers::pi / 180);
  TrianglesOf triangles_of = byCell(mesh, cell);
  divide(triangles_of);

  std::vector<ColouredChunk> out;
  for (const auto& [at, triangles] : triangles_of) {
    ColouredChunk& made = out.emplace_back();
    made.chunk.brick = {at[0], at[1], at[2]};
    made.chunk.version = 1;
    std::map<VertexKey, std::uint16_t> known;
    for (const std::size_t t : triangles) {
      std::array<std::uint16_t, 3>& triangle = made.chunk.triangles.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = mesh.triangles[t][k];
        const Vec3f& n = normals[3 * t + k];
        Rgba8 colour = mesh.hasFaceColors()     ? mesh.face_colors[t]
                       : mesh.hasVertexColors() ? mesh.vertex_colors[v]
                                                : kIvoryColour;
        colour[3] = kGloss;
        const auto [entry, is_new] = known.try_emplace(VertexKey{v, {n[0], n[1], n[2]}, colour},
                                                       static_cast<std::uint16_t>(made.chunk.vertices.size()));
        if (is_new) {
          made.chunk.vertices.push_back(mesh.vertices[v].cast<float>());
          made.chunk.normals.push_back(n);
          made.colours.push_back(colour);
        }
        triangle[k] = entry->second;
      }
    }
  }
  return out;
}

}  // namespace kerf
