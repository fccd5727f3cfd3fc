#include "geometry/mesh/mesh_distance.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/mesh/exact_weld.h"

namespace kerf {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;  // triangles
constexpr std::uint32_t kNoTriangle = ~0u;

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

struct SideUse {
  std::uint32_t low, high, triangle, k;
  bool isOfSameEdge(const SideUse& o) const { return low == o.low && high == o.high; }
  auto operator<=>(const SideUse&) const = default;
};

}  // namespace

MeshDistance::MeshDistance(const Mesh& mesh) : box_(kerf::bounds(mesh)) {
  findSides(mesh);
  const std::size_t count = mesh.triangles.size();
  std::vector<Vec3d> centers(count);
  for (std::size_t t = 0; t < count; ++t) {
    centers[t] = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
    if (!sides_[t].face.isZero(0)) order_.push_back(static_cast<std::uint32_t>(t));
  }
  nodes_.reserve(order_.size());
  if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()), centers, mesh);
  corners_.reserve(order_.size());
  for (const std::uint32_t t : order_) corners_.push_back({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)});
}

void MeshDistance::findSides(const Mesh& mesh) {
  internal::ExactWelder welder(mesh.vertices.size());
  std::vector<std::uint32_t> joined;
  joined.reserve(mesh.vertices.size());
  for (const Vec3d& p : mesh.vertices) joined.push_back(welder.add(p));
  corner_normals_.assign(welder.vertices.size(), Vec3d::Zero());

  sides_.resize(mesh.triangles.size());
  std::vector<SideUse> uses;
  uses.reserve(3 * sides_.size());
  for (std::uint32_t t = 0; t < sides_.size(); ++t) {
    Sides& s = sides_[t];
    const Vec3d twice = doubleAreaVector(mesh, t);
    if (twice.norm() > 0) s.face = twice.normalized();
    for (std::size_t k = 0; k < 3; ++k) s.corner[k] = joined[mesh.triangles[t][k]];
    const bool is_line = s.corner[0] == s.corner[1] || s.corner[1] == s.corner[2] || s.corner[2] == s.corner[0];
    for (std::uint32_t k = 0; k < 3; ++k) {
      const Vec3d &p = mesh.corner(t, static_cast<int>(k)), to = mesh.corner(t, static_cast<int>((k + 1) % 3)) - p,
                  from = mesh.corner(t, static_cast<int>((k + 2) % 3)) - p;
      corner_normals_[s.corner[k]] += std::atan2(to.cross(from).norm(), to.dot(from)) * s.face;
      const auto [low, high] = std::minmax(s.corner[k], s.corner[(k + 1) % 3]);
      if (!is_line) uses.push_back({low, high, t, k});
    }
  }

  std::sort(uses.begin(), uses.end());
  std::vector<char> is_boundary(corner_normals_.size());
  for (std::size_t n = 0, end = 0; n < uses.size(); n = end) {
    Vec3d sum = Vec3d::Zero();
    for (end = n; end < uses.size() && uses[end].isOfSameEdge(uses[n]); ++end) sum += sides_[uses[end].triangle].face;
    for (std::size_t i = n; i < end; ++i) sides_[uses[i].triangle].edge[uses[i].k] = sum;
    odd_edges_ += end - n > 2;
    if (end - n > 1) continue;
    ++boundary_edges_;
    sides_[uses[n].triangle].is_boundary[3 + uses[n].k] = true;
    is_boundary[uses[n].low] = is_boundary[uses[n].high] = 1;
  }
  if (boundary_edges_ == 0) return;
  for (Sides& s : sides_)
    for (std::size_t k = 0; k < 3; ++k) s.is_boundary[k] = is_boundary[s.corner[k]];
}

std::uint32_t MeshDistance::build(std::uint32_t first, std::uint32_t count, const std::vector<Vec3d>& centers,
                                  const Mesh& mesh) {
  const auto here = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Box3 box, middles;
  std::uint32_t least = kNoTriangle;
  for (std::uint32_t n = first; n < first + count; ++n) {
    for (int k = 0; k < 3; ++k) box.add(mesh.corner(order_[n], k));
    least = std::min(least, order_[n]);
    middles.add(centers[order_[n]]);
  }
  nodes_[here].box = box;
  nodes_[here].least = least;

  if (count <= kLeafTriangles) {
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
  build(first, half, centers, mesh);
  const std::uint32_t right = build(first + half, count - half, centers, mesh);
  nodes_[here].right = right;
  return here;
}

NearestOnMesh MeshDistance::nearest(const Vec3d& p, double most_mm) const noexcept {
  NearestOnMesh out;
  if (nodes_.empty()) return out;
  struct Waiting {
    std::uint32_t node;
    double squared;
  };
  std::array<Waiting, 64> stack;  // halved at every level: never deeper than 32
  std::size_t size = 0;
  stack[size++] = {0, squaredDistance(nodes_[0].box, p)};

  Nearest best{most_mm * most_mm, 6, p};
  std::uint32_t triangle = kNoTriangle;
  while (size > 0) {
    const Waiting at = stack[--size];
    const Node& node = nodes_[at.node];
    if (at.squared > best.squared || (at.squared == best.squared && node.least > triangle)) continue;
    if (node.count > 0) {
      for (std::uint32_t n = node.first; n < node.first + node.count; ++n) {
        const auto& [a, b, c] = corners_[n];
        const Nearest found = nearestOnTriangle(p, a, b, c);
        // Of equal ones the first in the file, so that the result does not depend on the way through the tree.
        if (found.squared < best.squared || (found.squared == best.squared && order_[n] < triangle)) {
          best = found;
          triangle = order_[n];
        }
      }
      continue;
    }

    const Waiting left{at.node + 1, squaredDistance(nodes_[at.node + 1].box, p)},
        right{node.right, squaredDistance(nodes_[node.right].box, p)};
    const bool left_first = left.squared < right.squared;
    stack[size++] = left_first ? right : left;
    stack[size++] = left_first ? left : right;
  }
  if (triangle == kNoTriangle) return out;

  const Sides& s = sides_[triangle];
  const Vec3d& normal = best.feature < 3   ? corner_normals_[s.corner[best.feature]]
                        : best.feature < 6 ? s.edge[best.feature - 3]
                                           : s.face;
  out.distance_mm = std::sqrt(best.squared);
  out.signed_mm = normal.dot(p - best.point) < 0 ? -out.distance_mm : out.distance_mm;
  out.triangle = triangle;
  out.point = best.point;
  out.is_on_boundary = best.feature < 6 && s.is_boundary[best.feature];
  return out;
}

}  // namespace kerf
