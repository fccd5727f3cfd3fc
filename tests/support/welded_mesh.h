// The chunks of a surface as one mesh.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "geometry/mesh/mesh.h"
#include "sim/live/remesher.h"

namespace kerf {

/// Chunks of different bricks, welded where positions are bit-equal: vertices in order of position, triangles in order
/// of the chunks.
inline Mesh weldedMesh(std::span<const MeshChunkPtr> chunks) {
  const auto less = [](const Vec3f& a, const Vec3f& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::vector<Vec3f> positions;
  for (const MeshChunkPtr& c : chunks) positions.insert(positions.end(), c->vertices.begin(), c->vertices.end());
  std::sort(positions.begin(), positions.end(), less);
  positions.erase(std::unique(positions.begin(), positions.end()), positions.end());
  Mesh mesh;
  mesh.vertices.reserve(positions.size());
  for (const Vec3f& p : positions) mesh.vertices.push_back(p.cast<double>());
  for (const MeshChunkPtr& c : chunks)
    for (const auto& t : c->triangles) {
      Triangle& made = mesh.triangles.emplace_back();
      for (std::size_t k = 0; k < 3; ++k)
        made[k] = static_cast<std::uint32_t>(
            std::lower_bound(positions.begin(), positions.end(), c->vertices[t[k]], less) - positions.begin());
    }
  return mesh;
}

}  // namespace kerf
