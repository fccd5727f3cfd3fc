#include "preprocess/volume/tetrahedral_mesher.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "geometry/mesh/self_intersection.h"

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
  Mesher(const Implicit& value, const Lattice& lattice, int refinements, double steepness)
      : value_(value), lattice_(lattice), refinements_(refinements), values_(lattice.nodeCount()) {
    for (std::size_t axis = 0; axis < 3; ++axis) blocks_[axis] = lattice_.cubes[axis] / kBlock + 1;
    skipped_.assign(blockOf(2 * Vec3i(lattice_.cubes[0], lattice_.cubes[1], lattice_.cubes[2])) + 1, 0);
    tbb::parallel_for(std::size_t{0}, skipped_.size(), [&](std::size_t b) { evaluateBlock(b, steepness); });
  }

  Mesh run() {
    findTriangles();
    placeVertices();
    for (Face& f : faces_) {
      mesh_.triangles.push_back({f[0], f[1], f[2]});
      if (f[3] == kNone) continue;
      // The shorter diagonal of a quad; both halves stay in the tetrahedron.
      if ((mesh_.vertices[f[0]] - mesh_.vertices[f[2]]).squaredNorm() <=
          (mesh_.vertices[f[1]] - mesh_.vertices[f[3]]).squaredNorm()) {
        mesh_.triangles.push_back({f[0], f[2], f[3]});
      } else {
        mesh_.triangles.back() = {f[1], f[2], f[3]};
        mesh_.triangles.push_back({f[1], f[3], f[0]});
      }
    }
    return std::move(mesh_);
  }

 private:
  static constexpr int kBlock = 4;  ///< cubes along the side of a block that is evaluated or skipped as a whole
  static constexpr std::uint32_t kNone = ~0u;
  using Face = std::array<std::uint32_t, 4>;  ///< a triangle (then kNone) or a quad

  /// A block holds the nodes from its low corner up to but without its high one.
  std::size_t blockOf(const Vec3i& h) const {
    const Vec3i b = h / (2 * kBlock);
    return (static_cast<std::size_t>(b.z()) * static_cast<std::size_t>(blocks_[1]) + static_cast<std::size_t>(b.y())) *
               static_cast<std::size_t>(blocks_[0]) +
           static_cast<std::size_t>(b.x());
  }
  void evaluateBlock(std::size_t b, double steepness) {
    const auto nx = static_cast<std::size_t>(blocks_[0]), ny = static_cast<std::size_t>(blocks_[1]);
    const Vec3i low =
        2 * kBlock * Vec3i(static_cast<int>(b % nx), static_cast<int>(b / nx % ny), static_cast<int>(b / (nx * ny)));
    double everywhere = 0;
    if (steepness > 0) {
      // As far as the tetrahedra reach that touch the block: a cube more.
      const double radius = std::sqrt(3.0) * (kBlock + 2) * lattice_.half;
      everywhere = value_(lattice_.position(low + Vec3i::Constant(kBlock)));
      if (std::abs(everywhere) > steepness * radius) skipped_[b] = 1;
    }

    for (int k = low.z(); k < low.z() + 2 * kBlock && k <= 2 * lattice_.cubes[2]; ++k)
      for (int j = low.y() + k % 2; j < low.y() + 2 * kBlock && j <= 2 * lattice_.cubes[1]; j += 2)
        for (int i = low.x() + k % 2; i < low.x() + 2 * kBlock && i <= 2 * lattice_.cubes[0]; i += 2) {
          const Vec3i h(i, j, k);
          values_[lattice_.index(h)] = skipped_[b] ? everywhere : value_(lattice_.position(h));
        }
  }

  void findTriangles() {
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
            if (skipped_[blockOf(low)]) continue;
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
  }

  bool inside(const Vec3i& h) const { return values_[lattice_.index(h)] < 0; }

  /// Vertex on the lattice edge from a (inside) to b (outside).
  std::uint32_t vertexOn(const Vec3i& a, const Vec3i& b) {
    const std::uint64_t key = static_cast<std::uint64_t>(lattice_.index(a)) << 32 | lattice_.index(b);
    const auto [at, is_new] = vertex_of_edge_.try_emplace(key, static_cast<std::uint32_t>(edges_.size()));
    if (is_new) edges_.push_back({a, b});
    return at->second;
  }

  void placeVertices() {
    mesh_.vertices.resize(edges_.size());
    tbb::parallel_for(std::size_t{0}, edges_.size(), [&](std::size_t v) {
      const auto& [a, b] = edges_[v];
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
      mesh_.vertices[v] = p + std::clamp(t, kKeepOff, 1 - kKeepOff) * (q - p);
    });
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
        if (from != to) {
          std::swap(n[from], n[to]);
          even = !even;
        }
        ++to;
      }
    if (!even) count == 3 ? std::swap(n[0], n[1]) : std::swap(n[2], n[3]);

    const auto on = [&](std::size_t a, std::size_t b) { return vertexOn(n[a], n[b]); };
    if (count == 1)
      faces_.push_back({on(0, 1), on(0, 2), on(0, 3), kNone});
    else if (count == 3)
      faces_.push_back({on(0, 3), on(1, 3), on(2, 3), kNone});
    else
      faces_.push_back({on(0, 2), on(0, 3), on(1, 3), on(1, 2)});
  }

  const Implicit& value_;
  const Lattice& lattice_;
  int refinements_;
  std::vector<double> values_;
  std::array<int, 3> blocks_{};
  std::vector<char> skipped_;                                        ///< per block
  std::unordered_map<std::uint64_t, std::uint32_t> vertex_of_edge_;  ///< only looked up, never iterated over
  std::vector<std::array<Vec3i, 2>> edges_;                          ///< per vertex: the nodes inside and outside
  std::vector<Face> faces_;
  Mesh mesh_;
};

}  // namespace

Mesh meshImplicit(const Implicit& value, const Box3& box, double spacing, int refinements, double steepness) {
  Lattice lattice{box.min, 0.5 * spacing, {}};
  for (int axis = 0; axis < 3; ++axis)
    lattice.cubes[static_cast<std::size_t>(axis)] =
        std::max(1, static_cast<int>(std::ceil(box.size()[axis] / spacing)));
  return Mesher(value, lattice, refinements, steepness).run();
}

namespace {

/// Two Newton steps onto {value = 0}, along the gradient by central differences.
Vec3d ontoSurface(const Implicit& value, Vec3d p) {
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

/// Vertices in groups that follow each other: moving the vertices of a group in any order, group after group, is the
/// same as moving all of them in the order of their numbers, because of two neighbours the lower number comes first.
std::vector<std::vector<std::uint32_t>> groupsInOrder(const Mesh& mesh,
                                                      const std::vector<std::vector<std::uint32_t>>& around) {
  std::vector<std::uint32_t> group(mesh.vertices.size(), 0);
  std::vector<std::vector<std::uint32_t>> groups;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    for (const std::uint32_t t : around[v])
      for (const std::uint32_t w : mesh.triangles[t])
        if (w < v) group[v] = std::max(group[v], group[w] + 1);
    if (group[v] >= groups.size()) groups.resize(group[v] + 1);
    groups[group[v]].push_back(v);
  }
  return groups;
}

}  // namespace

void undoCrossings(Mesh& mesh, const std::vector<Vec3d>& old) {
  for (;;) {
    std::vector<Vec3d> rounded;
    rounded.reserve(mesh.vertices.size());
    for (const Vec3d& p : mesh.vertices) rounded.push_back(roundedToFloat(p));
    std::vector<std::uint32_t> bad = degenerateTriangles(rounded, mesh.triangles);
    for (const auto& [a, b] : selfIntersections(rounded, mesh.triangles)) {
      bad.push_back(a);
      bad.push_back(b);
    }

    // The triangles themselves first; where they are back already, those around them.
    std::vector<char> touched(mesh.vertices.size(), 0);
    for (const std::uint32_t t : bad)
      for (const std::uint32_t v : mesh.triangles[t]) touched[v] = 1;

    bool moved = false;
    const auto restore = [&](std::uint32_t v) {
      moved = moved || mesh.vertices[v] != old[v];
      mesh.vertices[v] = old[v];
    };
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
      if (touched[v]) restore(v);
    for (const Triangle& t : mesh.triangles)
      if (touched[t[0]] || touched[t[1]] || touched[t[2]])
        for (const std::uint32_t v : t) restore(v);
    if (!moved) return;
  }
}

void evenOut(Mesh& mesh, const Implicit& value, int rounds) {
  const std::vector<Vec3d> before = mesh.vertices;
  std::vector<std::vector<std::uint32_t>> around(mesh.vertices.size());  // triangles
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) around[v].push_back(t);

  const auto normal = [&](std::uint32_t t) { return Vec3d(doubleAreaVector(mesh, t).stableNormalized()); };
  const auto move = [&](std::uint32_t v) {
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
  };

  const auto groups = groupsInOrder(mesh, around);
  for (int round = 0; round < rounds; ++round)
    for (const auto& group : groups)
      tbb::parallel_for(std::size_t{0}, group.size(), [&](std::size_t i) { move(group[i]); });
  undoCrossings(mesh, before);
}

}  // namespace kerf::internal
