#include "preprocess/close/manifold.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "preprocess/close/chain.h"

namespace kerf::internal {
namespace {

struct SideUse {
  std::uint32_t a, b, t;
  std::uint8_t k;  ///< the edge runs from corner k to corner k + 1 of t
  bool forth;      ///< from a to b, a < b
};

std::vector<SideUse> sideUses(const std::vector<Triangle>& triangles) {
  std::vector<SideUse> uses;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint8_t k = 0; k < 3; ++k) {
      const std::uint32_t p = triangles[t][k], q = triangles[t][(k + 1u) % 3];
      uses.push_back({std::min(p, q), std::max(p, q), t, k, p < q});
    }
  std::sort(uses.begin(), uses.end(), [](const SideUse& x, const SideUse& y) {
    if (x.a != y.a) return x.a < y.a;
    return x.b != y.b ? x.b < y.b : x.t < y.t;
  });
  return uses;
}

/// Pairs the triangles around one edge by wedge of material. Around the edge a -> b, counter-clockwise, material begins
/// behind a triangle that runs b -> a and ends behind one that runs a -> b.
std::vector<std::array<SideUse, 2>> pairWedges(const Mesh& mesh, const std::vector<Vec3d>& normals,
                                               std::span<const SideUse> uses) {
  if (uses.size() == 2) return {{uses[0], uses[1]}};
  const Vec3d axis = (mesh.vertices[uses[0].b] - mesh.vertices[uses[0].a]).normalized();

  struct Spoke {
    double angle;
    SideUse use;
  };
  std::vector<Spoke> spokes;
  Vec3d x = Vec3d::Zero(), y = Vec3d::Zero();
  for (const SideUse& u : uses) {
    const Vec3d n = (u.forth ? 1.0 : -1.0) * normals[u.t];
    const Vec3d into = n.cross(axis).normalized();

    if (spokes.empty()) {
      x = into;
      y = axis.cross(into);
    }
    double angle = spokes.empty() ? 0 : std::atan2(into.dot(y), into.dot(x));
    if (angle < 0) angle += 2 * M_PI;
    spokes.push_back({angle, u});
  }
  std::stable_sort(spokes.begin(), spokes.end(), [](const Spoke& p, const Spoke& q) { return p.angle < q.angle; });

  // Like brackets: b -> a opens, a -> b closes; start where the depth is least.
  std::size_t start = 0;
  int depth = 0, least = 0;
  for (std::size_t i = 0; i < spokes.size(); ++i) {
    depth += spokes[i].use.forth ? -1 : 1;
    if (depth < least) {
      least = depth;
      start = i + 1;
    }
  }

  std::vector<std::array<SideUse, 2>> pairs;
  std::vector<SideUse> open;
  for (std::size_t i = 0; i < spokes.size(); ++i) {
    const SideUse& u = spokes[(start + i) % spokes.size()].use;
    if (!u.forth) {
      open.push_back(u);
    } else if (!open.empty()) {
      pairs.push_back({open.back(), u});
      open.pop_back();
    }
  }
  return pairs;
}

template <class F>
void forEachSide(const std::vector<SideUse>& uses, F&& f) {
  for (std::size_t i = 0, j = 0; i < uses.size(); i = j) {
    while (j < uses.size() && uses[j].a == uses[i].a && uses[j].b == uses[i].b) ++j;
    f(std::span(uses).subspan(i, j - i));
  }
}

/// Joins the corners of triangles that bound the same wedges of material: corner 3 t + k is corner k of triangle t.
class Corners {
 public:
  Corners(const Mesh& mesh, const std::vector<Vec3d>& normals) : parent_(3 * mesh.triangles.size()) {
    std::iota(parent_.begin(), parent_.end(), 0u);
    forEachSide(sideUses(mesh.triangles), [&](std::span<const SideUse> uses) {
      for (const auto& [p, q] : pairWedges(mesh, normals, uses)) {
        // p and q run along the edge in opposite directions: p's first corner is q's second.
        unite(3 * p.t + p.k, 3 * q.t + (q.k + 1u) % 3);
        unite(3 * p.t + (p.k + 1u) % 3, 3 * q.t + q.k);
      }
    });
  }
  std::uint32_t count() const { return static_cast<std::uint32_t>(parent_.size()); }
  /// The corner that represents a fan.
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

 private:
  void unite(std::uint32_t i, std::uint32_t j) {
    i = root(i);
    j = root(j);
    if (i != j) parent_[std::max(i, j)] = std::min(i, j);
  }
  std::vector<std::uint32_t> parent_;
};

/// The triangles at a vertex that belong together.
struct Fan {
  std::uint32_t v, root, size;
};

/// All fans by vertex, the largest of each first.
std::vector<Fan> fansOf(const Mesh& mesh, Corners& corners) {
  std::vector<std::uint32_t> size(corners.count(), 0);
  for (std::uint32_t c = 0; c < corners.count(); ++c) ++size[corners.root(c)];
  std::vector<Fan> fans;
  for (std::uint32_t c = 0; c < corners.count(); ++c)
    if (corners.root(c) == c) fans.push_back({mesh.triangles[c / 3][c % 3], c, size[c]});
  std::sort(fans.begin(), fans.end(), [](const Fan& x, const Fan& y) {
    if (x.v != y.v) return x.v < y.v;
    return x.size != y.size ? x.size > y.size : x.root < y.root;
  });
  return fans;
}

/// One round of vertex copies. Returns how many vertices were split.
std::size_t splitVertices(Mesh& mesh, const std::vector<Vec3d>& normals, double distance, SplitReport& report) {
  Corners corners(mesh, normals);
  const std::vector<Fan> fans = fansOf(mesh, corners);
  std::vector<std::uint32_t> vertex_of(corners.count(), kAdded);  // by root
  std::size_t split = 0;
  for (std::size_t i = 0; i < fans.size(); ++i) {
    const Fan& fan = fans[i];
    if (i == 0 || fans[i - 1].v != fan.v) {
      vertex_of[fan.root] = fan.v;
      continue;
    }
    split += i < 2 || fans[i - 2].v != fan.v;
    vertex_of[fan.root] = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(mesh.vertices[fan.v]);
    if (mesh.hasVertexColors()) mesh.vertex_colors.push_back(mesh.vertex_colors[fan.v]);
    report.copy_of.push_back(fan.v);
  }
  if (split == 0) return 0;

  // Into the material: against the mean normal of the fan, each triangle weighted by its angle at the vertex.
  const std::size_t first_new = mesh.vertices.size() - report.copy_of.size();
  std::vector<Vec3d> inward(report.copy_of.size(), Vec3d::Zero());
  for (std::uint32_t c = 0; c < corners.count(); ++c) {
    const std::uint32_t v = vertex_of[corners.root(c)];
    if (v < first_new) continue;
    const Triangle& f = mesh.triangles[c / 3];
    const Vec3d p = mesh.vertices[v];
    const std::uint32_t k = c % 3;
    const Vec3d e1 = (mesh.vertices[f[(k + 1) % 3]] - p).normalized(),
                e2 = (mesh.vertices[f[(k + 2) % 3]] - p).normalized();
    inward[v - first_new] -= std::acos(std::clamp(e1.dot(e2), -1.0, 1.0)) * normals[c / 3].normalized();
  }

  std::vector<Triangle> triangles = mesh.triangles;
  for (std::uint32_t c = 0; c < corners.count(); ++c) triangles[c / 3][c % 3] = vertex_of[corners.root(c)];
  mesh.triangles = std::move(triangles);
  for (std::size_t i = 0; i < inward.size(); ++i)
    if (inward[i].norm() > 0) mesh.vertices[first_new + i] += distance * inward[i].normalized();
  return split;
}

/// Puts a vertex in the middle of every edge that more than two triangles still share.
std::size_t splitEdges(Mesh& mesh, std::vector<Vec3d>& normals, std::vector<std::uint32_t>& tags, SplitReport& report) {
  std::size_t count = 0;
  // One edge per triangle and round: a second one would be stale. The caller repeats.
  std::vector<char> taken(mesh.triangles.size(), 0);
  const std::vector<SideUse> uses_before = sideUses(mesh.triangles);
  forEachSide(uses_before, [&](std::span<const SideUse> uses) {
    if (uses.size() <= 2) return;
    for (const SideUse& u : uses)
      if (taken[u.t]) return;

    const auto m = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(0.5 * (mesh.vertices[uses[0].a] + mesh.vertices[uses[0].b]));
    if (mesh.hasVertexColors()) mesh.vertex_colors.push_back(mesh.vertex_colors[uses[0].a]);
    report.copy_of.push_back(kAdded);
    ++count;

    for (const SideUse& u : uses) {
      taken[u.t] = 1;
      const Triangle f = mesh.triangles[u.t];
      const std::uint32_t p = f[u.k], q = f[(u.k + 1u) % 3], r = f[(u.k + 2u) % 3];
      mesh.triangles[u.t] = {p, m, r};
      mesh.triangles.push_back({m, q, r});
      normals.push_back(Vec3d(normals[u.t]));
      tags.push_back(std::uint32_t(tags[u.t]));
      if (mesh.hasFaceColors()) mesh.face_colors.push_back(Rgba8(mesh.face_colors[u.t]));
    }
  });
  return count;
}

}  // namespace

SplitReport splitNonManifold(Mesh& mesh, std::vector<Vec3d>& normals_of, std::vector<std::uint32_t>& tags,
                             double distance) {
  SplitReport total;
  for (int round = 0; round < 6; ++round) {
    SplitReport step;
    total.places += splitVertices(mesh, normals_of, distance, step);
    const std::size_t middles = splitEdges(mesh, normals_of, tags, step);
    total.copy_of.insert(total.copy_of.end(), step.copy_of.begin(), step.copy_of.end());
    if (middles == 0) break;
  }
  return total;
}

}  // namespace kerf::internal
