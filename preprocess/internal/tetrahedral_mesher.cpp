#include "preprocess/internal/tetrahedral_mesher.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace kerf::internal {
namespace {

/// Corners (even numbers) and centres (odd) of the cubes as one grid of half steps: node (i, j, k) exists where i, j, k
/// are all even or all odd.
struct Lattice {
  Vec3d origin;
  double half;  ///< mm
  std::array<int, 3> cubes;

  std::uint32_t corners(int axis) const {
    return static_cast<std::uint32_t>(cubes[static_cast<std::size_t>(axis)]) + 1;
  }
  std::uint32_t cornerCount() const { return corners(0) * corners(1) * corners(2); }
  std::uint32_t nodeCount() const {
    return cornerCount() + static_cast<std::uint32_t>(cubes[0]) * static_cast<std::uint32_t>(cubes[1]) *
                               static_cast<std::uint32_t>(cubes[2]);
  }
  std::uint32_t index(const Vec3i& h) const {
    const auto x = static_cast<std::uint32_t>(h.x() / 2), y = static_cast<std::uint32_t>(h.y() / 2),
               z = static_cast<std::uint32_t>(h.z() / 2);
    if (h.x() % 2 == 0) return (z * corners(1) + y) * corners(0) + x;
    return cornerCount() + (z * (corners(1) - 1) + y) * (corners(0) - 1) + x;
  }
  Vec3d position(const Vec3i& h) const { return origin + half * h.cast<double>(); }
};

class Mesher {
 public:
  Mesher(const std::function<double(const Vec3d&)>& value, const Lattice& lattice, int refinements)
      : value_(value), lattice_(lattice), refinements_(refinements), values_(lattice.nodeCount()) {
    for (int parity = 0; parity < 2; ++parity)
      for (int k = parity; k <= 2 * lattice_.cubes[2] - parity; k += 2)
        for (int j = parity; j <= 2 * lattice_.cubes[1] - parity; j += 2)
          for (int i = parity; i <= 2 * lattice_.cubes[0] - parity; i += 2) {
            const Vec3i h(i, j, k);
            values_[lattice_.index(h)] = value_(lattice_.position(h));
          }
  }

  Mesh run() {
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      Vec3i along = Vec3i::Zero();
      along[axis] = 2;
      // The two centres on either side of each inner face, with each of the face's four edges.
      for (int k = 1; k < 2 * lattice_.cubes[2]; k += 2)
        for (int j = 1; j < 2 * lattice_.cubes[1]; j += 2)
          for (int i = 1; i < 2 * lattice_.cubes[0]; i += 2) {
            const Vec3i low(i, j, k), high = low + along;
            if (high[axis] > 2 * lattice_.cubes[static_cast<std::size_t>(axis)]) continue;
            std::array<Vec3i, 4> ring;
            for (std::size_t c = 0; c < 4; ++c) {
              ring[c] = low;
              ring[c][axis] += 1;
              ring[c][u] += c == 0 || c == 3 ? -1 : 1;
              ring[c][v] += c < 2 ? -1 : 1;
            }
            for (std::size_t c = 0; c < 4; ++c) addTetrahedron({low, high, ring[c], ring[(c + 1) % 4]});
          }
    }
    return std::move(mesh_);
  }

 private:
  bool inside(const Vec3i& h) const { return values_[lattice_.index(h)] < 0; }

  /// Vertex on the lattice edge from a (inside) to b (outside).
  std::uint32_t vertexOn(const Vec3i& a, const Vec3i& b) {
    const std::uint64_t key = static_cast<std::uint64_t>(lattice_.index(a)) << 32 | lattice_.index(b);
    const auto [at, is_new] = vertex_of_edge_.try_emplace(key, static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (!is_new) return at->second;
    const Vec3d p = lattice_.position(a), q = lattice_.position(b);
    double s = 0, e = 1, at_s = values_[lattice_.index(a)], at_e = values_[lattice_.index(b)], t = 0.5;
    for (int step = 0; step <= refinements_; ++step) {
      t = s + (e - s) * std::clamp(at_s / (at_s - at_e), 0.05, 0.95);
      if (step == refinements_) break;
      const double here = value_(p + t * (q - p));
      (here < 0 ? s : e) = t;
      (here < 0 ? at_s : at_e) = here;
    }
    constexpr double kKeepOff = 0.02;  // of an edge: no vertex on a node, no triangle without area
    mesh_.vertices.push_back(p + std::clamp(t, kKeepOff, 1 - kKeepOff) * (q - p));
    return at->second;
  }

  /// @param n  positively oriented: n[1], n[2], n[3] turn counter-clockwise seen from the side away from n[0].
  void addTetrahedron(std::array<Vec3i, 4> n) {
    int count = 0;
    for (const Vec3i& h : n) count += inside(h);
    if (count == 0 || count == 4) return;
    // Inside nodes first. Every swap of two turns the orientation over, and is paid for by another swap.
    bool even = true;
    for (std::size_t to = 0, from = 0; from < 4; ++from)
      if (inside(n[from])) {
        if (from != to) std::swap(n[from], n[to]), even = !even;
        ++to;
      }
    if (!even) count == 3 ? std::swap(n[0], n[1]) : std::swap(n[2], n[3]);
    const auto on = [&](std::size_t a, std::size_t b) { return vertexOn(n[a], n[b]); };
    if (count == 1) {
      mesh_.triangles.push_back({on(0, 1), on(0, 2), on(0, 3)});
    } else if (count == 3) {
      mesh_.triangles.push_back({on(0, 3), on(1, 3), on(2, 3)});
    } else {
      const std::array<std::uint32_t, 4> q = {on(0, 2), on(0, 3), on(1, 3), on(1, 2)};
      // The shorter diagonal; both halves stay in the tetrahedron.
      if ((mesh_.vertices[q[0]] - mesh_.vertices[q[2]]).squaredNorm() <=
          (mesh_.vertices[q[1]] - mesh_.vertices[q[3]]).squaredNorm()) {
        mesh_.triangles.push_back({q[0], q[1], q[2]});
        mesh_.triangles.push_back({q[0], q[2], q[3]});
      } else {
        mesh_.triangles.push_back({q[1], q[2], q[3]});
        mesh_.triangles.push_back({q[1], q[3], q[0]});
      }
    }
  }

  const std::function<double(const Vec3d&)>& value_;
  const Lattice& lattice_;
  int refinements_;
  std::vector<double> values_;
  std::unordered_map<std::uint64_t, std::uint32_t> vertex_of_edge_;  ///< looked up, never walked through
  Mesh mesh_;
};

}  // namespace

Mesh meshImplicit(const std::function<double(const Vec3d&)>& value, const Box3& box, double spacing, int refinements) {
  Lattice lattice{box.min, 0.5 * spacing, {}};
  for (int axis = 0; axis < 3; ++axis)
    lattice.cubes[static_cast<std::size_t>(axis)] =
        std::max(1, static_cast<int>(std::ceil(box.size()[axis] / spacing)));
  return Mesher(value, lattice, refinements).run();
}

namespace {

/// Two Newton steps onto {value = 0}, along the gradient by central differences.
Vec3d ontoSurface(const std::function<double(const Vec3d&)>& value, Vec3d p) {
  constexpr double kStep = 1e-4;
  for (int step = 0; step < 2; ++step) {
    Vec3d gradient;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3d d = kStep * Vec3d::Unit(axis);
      gradient[axis] = (value(p + d) - value(p - d)) / (2 * kStep);
    }
    if (const double g2 = gradient.squaredNorm(); g2 > 1e-12) p -= gradient * (value(p) / g2);
  }
  return p;
}

}  // namespace

void evenOut(Mesh& mesh, const std::function<double(const Vec3d&)>& value, int rounds) {
  std::vector<std::vector<std::uint32_t>> around(mesh.vertices.size());  // triangles
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) around[v].push_back(t);
  const auto normal = [&](std::uint32_t t) { return Vec3d(doubleAreaVector(mesh, t).stableNormalized()); };
  for (int round = 0; round < rounds; ++round)
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
      const Vec3d old = mesh.vertices[v];
      Vec3d sum = Vec3d::Zero();
      Vec3d facing = Vec3d::Zero();
      for (const std::uint32_t t : around[v]) {
        for (const std::uint32_t w : mesh.triangles[t])
          if (w != v) sum += mesh.vertices[w];
        facing += doubleAreaVector(mesh, t);
      }
      facing.stableNormalize();
      mesh.vertices[v] = ontoSurface(value, sum / (2.0 * static_cast<double>(around[v].size())));
      bool folds = false;
      for (const std::uint32_t t : around[v]) folds = folds || normal(t).dot(facing) < 0.5;
      if (folds) mesh.vertices[v] = old;
    }
}

}  // namespace kerf::internal
