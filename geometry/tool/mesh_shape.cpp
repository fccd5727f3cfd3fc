#include "geometry/tool/mesh_shape.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace kerf {
namespace {

constexpr std::uint32_t kLeaf = 4;  // triangles

double squaredDistance(const Box3& box, const Vec3d& p) {
  return (box.min - p).cwiseMax(p - box.max).cwiseMax(0.0).squaredNorm();
}

struct Nearest {
  double squared;
  std::size_t feature;  // 0 to 2: a corner, 3 to 5: the edge from corner feature - 3, 6: the face
  Vec3d point;
};

// The regions about a triangle after Ericson, Real-Time Collision Detection, 2005, 5.1.5.
Nearest nearestOnTriangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const auto found = [&](std::size_t feature, const Vec3d& q) { return Nearest{(p - q).squaredNorm(), feature, q}; };
  const Vec3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return found(0, a);
  if (d3 >= 0 && d4 <= d3) return found(1, b);

  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return found(3, a + d1 / (d1 - d3) * ab);
  if (d6 >= 0 && d5 <= d6) return found(2, c);

  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return found(5, a + d2 / (d2 - d6) * ac);

  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return found(4, b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b));
  const double sum = va + vb + vc;
  return found(6, a + vb / sum * ab + vc / sum * ac);
}

}  // namespace

MeshShape::MeshShape(const Mesh& mesh) : box_(kerf::bounds(mesh)) {
  const std::size_t count = mesh.triangles.size();
  std::vector<Vec3d> faces(count), corners(mesh.vertices.size(), Vec3d::Zero()), centers(count);
  std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3d> edges;
  for (std::size_t t = 0; t < count; ++t) {
    faces[t] = doubleAreaVector(mesh, t).normalized();
    const Triangle& v = mesh.triangles[t];
    centers[t] = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3d &p = mesh.vertices[v[k]], to = mesh.vertices[v[(k + 1) % 3]] - p,
                  from = mesh.vertices[v[(k + 2) % 3]] - p;
      corners[v[k]] += std::atan2(to.cross(from).norm(), to.dot(from)) * faces[t];
      edges.try_emplace(std::minmax(v[k], v[(k + 1) % 3]), Vec3d::Zero()).first->second += faces[t];
    }
  }

  triangles_.resize(count);
  for (std::size_t t = 0; t < count; ++t) {
    const Triangle& v = mesh.triangles[t];
    triangles_[t].face = faces[t];
    for (std::size_t k = 0; k < 3; ++k) {
      triangles_[t].at[k] = mesh.vertices[v[k]];
      triangles_[t].corner[k] = corners[v[k]];
      triangles_[t].edge[k] = edges.at(std::minmax(v[k], v[(k + 1) % 3]));
    }
  }

  order_.resize(count);
  std::iota(order_.begin(), order_.end(), 0u);
  if (count > 0) build(0, static_cast<std::uint32_t>(count), centers);
}

std::uint32_t MeshShape::build(std::uint32_t first, std::uint32_t count, const std::vector<Vec3d>& centers) {
  const auto here = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Box3 box, middles;
  for (std::uint32_t n = first; n < first + count; ++n) {
    for (const Vec3d& p : triangles_[order_[n]].at) box.add(p);
    middles.add(centers[order_[n]]);
  }

  nodes_[here].box = box;

  if (count <= kLeaf) {
    nodes_[here].first = first;
    nodes_[here].count = count;
    return here;
  }

  int axis = 0;
  middles.size().maxCoeff(&axis);
  const std::uint32_t half = count / 2;
  const auto begin = order_.begin() + first;
  std::nth_element(begin, begin + half, begin + count, [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(centers[a][axis], a) < std::pair(centers[b][axis], b);
  });
  build(first, half, centers);
  nodes_[here].right = build(first + half, count - half, centers);
  return here;
}

double MeshShape::distance(const Vec3d& p) const noexcept {
  if (nodes_.empty()) return std::numeric_limits<double>::infinity();
  std::array<std::uint32_t, 64> stack;  // halved at every level: never deeper than 32
  std::size_t size = 0;
  stack[size++] = 0;

  Nearest best{std::numeric_limits<double>::infinity(), 6, p};
  std::uint32_t triangle = 0;
  while (size > 0) {
    const std::uint32_t at = stack[--size];
    const Node& node = nodes_[at];
    if (squaredDistance(node.box, p) >= best.squared) continue;
    if (node.count > 0) {
      for (std::uint32_t n = node.first; n < node.first + node.count; ++n) {
        const Corners& t = triangles_[order_[n]];
        const Nearest found = nearestOnTriangle(p, t.at[0], t.at[1], t.at[2]);
        if (found.squared < best.squared) {
          best = found;
          triangle = order_[n];
        }
      }
      continue;
    }

    const std::uint32_t left = at + 1, right = node.right;
    const bool left_first = squaredDistance(nodes_[left].box, p) < squaredDistance(nodes_[right].box, p);
    stack[size++] = left_first ? right : left;
    stack[size++] = left_first ? left : right;
  }

  const Corners& t = triangles_[triangle];
  const Vec3d& normal = best.feature < 3   ? t.corner[best.feature]
                        : best.feature < 6 ? t.edge[best.feature - 3]
                                           : t.face;
  const double length = std::sqrt(best.squared);
  return normal.dot(p - best.point) < 0 ? -length : length;
}

double HalfShape::distance(const Vec3d& p) const noexcept { return std::max(solid_->distance(p), level_ - p[2]); }

Box3 HalfShape::bounds() const {
  Box3 box = solid_->bounds();
  box.min[2] = std::max(box.min[2], level_);
  return box;
}

}  // namespace kerf
