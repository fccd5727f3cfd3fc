#include "geometry/mesh/mesh.h"

#include <algorithm>
#include <numeric>

namespace kerf {

Box3 bounds(const Mesh& mesh) {
  Box3 box;
  for (const Vec3d& p : mesh.vertices) box.add(p);
  return box;
}

Vec3d doubleAreaVector(const Mesh& mesh, std::size_t t) {
  const Vec3d a = mesh.corner(t, 0);
  return (mesh.corner(t, 1) - a).cross(mesh.corner(t, 2) - a);
}

double surfaceArea(const Mesh& mesh) {
  double twice = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) twice += doubleAreaVector(mesh, t).norm();
  return 0.5 * twice;
}

double signedVolume(const Mesh& mesh) {
  if (mesh.vertices.empty()) return 0;
  const Vec3d c = bounds(mesh).center();
  double six = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    six += (mesh.corner(t, 0) - c).dot((mesh.corner(t, 1) - c).cross(mesh.corner(t, 2) - c));
  return six / 6.0;
}

void append(Mesh& mesh, const Mesh& other, Rgba8 fill) {
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  if (other.hasVertexColors() || mesh.hasVertexColors()) {
    mesh.vertex_colors.resize(mesh.vertices.size(), fill);
    if (other.hasVertexColors())
      mesh.vertex_colors.insert(mesh.vertex_colors.end(), other.vertex_colors.begin(), other.vertex_colors.end());
    else
      mesh.vertex_colors.resize(mesh.vertices.size() + other.vertices.size(), fill);
  }
  if (other.hasFaceColors() || mesh.hasFaceColors()) {
    mesh.face_colors.resize(mesh.triangles.size(), fill);
    if (other.hasFaceColors())
      mesh.face_colors.insert(mesh.face_colors.end(), other.face_colors.begin(), other.face_colors.end());
    else
      mesh.face_colors.resize(mesh.triangles.size() + other.triangles.size(), fill);
  }
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  mesh.triangles.reserve(mesh.triangles.size() + other.triangles.size());
  for (const Triangle& t : other.triangles) mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

Pieces edgeConnectedPieces(const Mesh& mesh) {
  const std::size_t n = mesh.triangles.size();
  std::vector<std::uint32_t> parent(n);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto find = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };

  // Uses of edges, grouped by their lower vertex: a counting sort and many tiny ones by (other vertex, triangle).
  std::vector<std::uint32_t> begin(mesh.vertices.size() + 1);
  for (const Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++begin[std::min(t[k], t[(k + 1) % 3]) + std::size_t{1}];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());

  std::vector<std::uint64_t> uses(3 * n);
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (std::uint32_t t = 0; t < n; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      uses[next[std::min(a, b)]++] = std::uint64_t{std::max(a, b)} << 32 | t;
    }

  for (std::size_t v = 0; v + 1 < begin.size(); ++v) {
    std::sort(uses.begin() + begin[v], uses.begin() + begin[v + 1]);
    for (std::size_t i = begin[v] + std::size_t{1}; i < begin[v + 1]; ++i) {
      if (uses[i] >> 32 != uses[i - 1] >> 32) continue;
      const std::uint32_t a = find(static_cast<std::uint32_t>(uses[i - 1])),
                          b = find(static_cast<std::uint32_t>(uses[i]));
      if (a != b) parent[std::max(a, b)] = std::min(a, b);
    }
  }

  Pieces pieces;
  pieces.label.resize(n);
  for (std::uint32_t t = 0; t < n; ++t) {
    const std::uint32_t root = find(t);
    pieces.label[t] = root == t ? pieces.count++ : pieces.label[root];
  }
  return pieces;
}

Mesh subset(const Mesh& mesh, const std::vector<char>& keep) {
  Mesh out;
  constexpr std::uint32_t kUnused = ~0u;
  std::vector<std::uint32_t> index(mesh.vertices.size(), kUnused);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (keep[t])
      for (const std::uint32_t v : mesh.triangles[t]) index[v] = 0;

  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (index[v] != kUnused) {
      index[v] = static_cast<std::uint32_t>(out.vertices.size());
      out.vertices.push_back(mesh.vertices[v]);
      if (mesh.hasVertexColors()) out.vertex_colors.push_back(mesh.vertex_colors[v]);
    }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (keep[t]) {
      const Triangle& f = mesh.triangles[t];
      out.triangles.push_back({index[f[0]], index[f[1]], index[f[2]]});
      if (mesh.hasFaceColors()) out.face_colors.push_back(mesh.face_colors[t]);
    }
  return out;
}

}  // namespace kerf
