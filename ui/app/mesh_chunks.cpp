#include "ui/app/mesh_chunks.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <tuple>

#include "geometry/mesh/shading_normals.h"

namespace kerf {
namespace {

constexpr std::size_t kMostVertices = 65536;
constexpr Rgba8 kIvoryColour = {233, 221, 197, 255};
constexpr std::uint8_t kGloss = 150;

using Cell = std::array<int, 3>;

/// A vertex as it is drawn: one of the mesh with one of its normals and colours.
using Key = std::tuple<std::uint32_t, std::array<float, 3>, Rgba8>;

}  // namespace

std::vector<ColouredChunk> chunksOf(const Mesh& mesh, double cell) {
  const std::vector<Vec3f> normals = cornerNormals(mesh, 40 * std::numbers::pi / 180);
  std::map<Cell, std::vector<std::size_t>> triangles_of;
  for (bool fits = false; !fits; cell /= 2) {
    triangles_of.clear();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Vec3d middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
      const Vec3i at = (middle / cell).array().floor().cast<int>().matrix();
      triangles_of[{at[0], at[1], at[2]}].push_back(t);
    }
    fits = std::all_of(triangles_of.begin(), triangles_of.end(),
                       [](const auto& entry) { return 3 * entry.second.size() <= kMostVertices; });
  }

  std::vector<ColouredChunk> out;
  for (const auto& [at, triangles] : triangles_of) {
    ColouredChunk& made = out.emplace_back();
    made.chunk.brick = {at[0], at[1], at[2]};
    made.chunk.version = 1;
    std::map<Key, std::uint16_t> known;
    for (const std::size_t t : triangles) {
      std::array<std::uint16_t, 3>& triangle = made.chunk.triangles.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = mesh.triangles[t][k];
        const Vec3f& n = normals[3 * t + k];
        Rgba8 colour = mesh.hasFaceColors()     ? mesh.face_colors[t]
                       : mesh.hasVertexColors() ? mesh.vertex_colors[v]
                                                : kIvoryColour;
        colour[3] = kGloss;
        const auto [entry, is_new] = known.try_emplace(Key{v, {n[0], n[1], n[2]}, colour},
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
