#include "geometry/mesh/shading_normals.h"

#include <cmath>

namespace kerf {
namespace {

double angleAt(const Mesh& mesh, std::size_t t, int k) {
  const Vec3d p = mesh.corner(t, k), a = mesh.corner(t, (k + 1) % 3) - p, b = mesh.corner(t, (k + 2) % 3) - p;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

std::vector<Vec3f> cornerNormals(const Mesh& mesh, double crease) {
  const std::size_t count = mesh.triangles.size();
  std::vector<Vec3d> face(count);
  for (std::size_t t = 0; t < count; ++t) face[t] = doubleAreaVector(mesh, t).stableNormalized();

  // Corners sorted by vertex: those of vertex v are corner[first[v]] .. corner[first[v + 1] - 1]. Triangles without
  // area do not affect others, and there may be thousands of them at one vertex.
  std::vector<std::uint32_t> first(mesh.vertices.size() + 1, 0), corner(3 * count);
  for (std::size_t t = 0; t < count; ++t)
    for (const std::uint32_t v : mesh.triangles[t])
      if (!face[t].isZero()) ++first[v + 1];
  for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (std::uint32_t c = 0; c < corner.size(); ++c)
    if (!face[c / 3].isZero()) corner[next[mesh.triangles[c / 3][c % 3]]++] = c;

  const double least_cosine = std::cos(crease);
  std::vector<Vec3f> normals(3 * count);
  for (std::uint32_t c = 0; c < normals.size(); ++c) {
    const std::uint32_t v = mesh.triangles[c / 3][c % 3];
    const Vec3d& own = face[c / 3];
    const bool flat = own.isZero();

    Vec3d sum = Vec3d::Zero();
    for (std::uint32_t i = first[v]; i < first[v + 1]; ++i) {
      const std::uint32_t t = corner[i] / 3;
      if (t == c / 3 || flat || own.dot(face[t]) > least_cosine)
        sum += angleAt(mesh, t, static_cast<int>(corner[i] % 3)) * face[t];
    }
    const Vec3d n = sum.norm() > 1e-9 ? Vec3d(sum.normalized()) : flat ? Vec3d(Vec3d::UnitZ()) : own;
    normals[c] = n.cast<float>();
  }
  return normals;
}

}  // namespace kerf
