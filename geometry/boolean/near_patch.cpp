#include "geometry/boolean/near_patch.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "geometry/mesh/box_tree.h"
#include "geometry/mesh/solids.h"

namespace kerf::internal {
namespace {

constexpr std::size_t kSmallComponent = 256;  // triangles: smaller ones join the patch instead of getting a cap
constexpr int kMostGrowths = 20;              // of the patch, until its border does not touch itself

Box3 boxOf(const Mesh& mesh, std::size_t t) {
  Box3 box;
  for (int k = 0; k < 3; ++k) box.add(mesh.corner(t, k));
  return box;
}

// ---- The other mesh, with queries for nearness

class Surface {
 public:
  explicit Surface(const Mesh& mesh) : mesh_(mesh), tree_(boxesOf(mesh)), all_(bounds(mesh)) {
    for (const Box3& box : tree_.boxes())
      mean_size_ += box.size().maxCoeff() / static_cast<double>(tree_.boxes().size());
  }

  const Box3& all() const { return all_; }
  double meanSize() const { return mean_size_; }  // of a triangle's box, mm

  // Whether a triangle of the surface may have a point in common with a box.
  bool mayMeet(const Box3& box) const {
    if (!overlap(all_, box)) return false;
    return !tree_.visit([&](const Box3& node) { return overlap(node, box); },
                        [&](std::uint32_t t) {
                          return !overlap(tree_.boxes()[t], box) ||
                                 isApart(mesh_.corner(t, 0), mesh_.corner(t, 1), mesh_.corner(t, 2), box);
                        });
  }

  // Whether the box of one of its triangles may have a point in common with a triangle.
  bool mayMeet(const Vec3d& a, const Vec3d& b, const Vec3d& c) const {
    const auto may = [&](const Box3& box) { return !isApart(a, b, c, box); };
    return !tree_.visit(may, [&](std::uint32_t t) { return !may(tree_.boxes()[t]); });
  }

 private:
  static std::vector<Box3> boxesOf(const Mesh& mesh) {
    std::vector<Box3> boxes(mesh.triangles.size());
    for (std::size_t t = 0; t < boxes.size(); ++t) boxes[t] = boxOf(mesh, t);
    return boxes;
  }

  const Mesh& mesh_;
  BoxTree tree_;
  Box3 all_;
  double mean_size_ = 0;
};

// ---- Which triangles are near

std::vector<char> trianglesWithin(const Mesh& source, const Surface& other, double margin) {
  std::vector<char> near(source.triangles.size());
  tbb::parallel_for(std::size_t{0}, near.size(), [&](std::size_t t) {
    Box3 box = boxOf(source, t);
    box.grow(margin);
    near[t] = other.mayMeet(box);
  });
  return near;
}

// Labels of the triangles that are not near, by their connection through vertices; the smallest vertex of each
// component is its label.
class Components {
 public:
  Components(const Mesh& source, const std::vector<char>& near) : parent_(source.vertices.size()) {
    std::iota(parent_.begin(), parent_.end(), 0u);
    for (std::size_t t = 0; t < near.size(); ++t) {
      if (near[t]) continue;
      join(source.triangles[t][0], source.triangles[t][1]);
      join(source.triangles[t][0], source.triangles[t][2]);
    }
  }

  std::uint32_t labelOf(std::uint32_t vertex) {
    while (parent_[vertex] != vertex) vertex = parent_[vertex] = parent_[parent_[vertex]];
    return vertex;
  }

 private:
  void join(std::uint32_t a, std::uint32_t b) {
    a = labelOf(a);
    b = labelOf(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  std::vector<std::uint32_t> parent_;
};

// A component away from the surface of `other` lies inside or outside as a whole. Inner components go into the patch,
// where they vanish; small ones too.
void takeInComponents(const Mesh& source, const Mesh& other, const Surface& surface, std::vector<char>& near) {
  Components components(source, near);
  std::vector<std::uint32_t> size(source.vertices.size(), 0);
  for (std::size_t t = 0; t < near.size(); ++t)
    if (!near[t]) ++size[components.labelOf(source.triangles[t][0])];

  std::vector<char> is_taken(source.vertices.size(), 0);
  for (std::uint32_t v = 0; v < size.size(); ++v)
    if (size[v] > 0 && surface.all().contains(source.vertices[v]))
      is_taken[v] = size[v] < kSmallComponent || isInside(other, source.vertices[v]);

  for (std::size_t t = 0; t < near.size(); ++t)
    if (!near[t]) near[t] = is_taken[components.labelOf(source.triangles[t][0])];
}

// True if each edge runs as often one way as the other. An open mesh passes once in 2^64; edges with four triangles
// stay unchecked.
bool isClosed(const Mesh& mesh) {
  std::uint64_t sum = 0;
  for (const Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = t[k], b = t[(k + 1) % 3];
      std::uint64_t edge = (std::min(a, b) << 32 | std::max(a, b)) * 0x9e3779b97f4a7c15ull;
      edge = (edge ^ edge >> 32) * 0xff51afd7ed558ccdull;
      edge ^= edge >> 29;
      sum += a < b ? edge : -edge;
    }
  return sum == 0;
}

// ---- The border of the patch

struct Border {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;  // as the patch's triangles run through them; sorted
  bool is_manifold = true;                                     // no edge runs twice in the same direction
};

Border borderOf(const Mesh& source, const std::vector<char>& near) {
  using Edge = std::pair<std::uint32_t, std::uint32_t>;
  std::vector<Edge> all;
  for (std::size_t t = 0; t < near.size(); ++t)
    if (near[t])
      for (std::size_t k = 0; k < 3; ++k) all.emplace_back(source.triangles[t][k], source.triangles[t][(k + 1) % 3]);
  std::sort(all.begin(), all.end());

  Border out;
  out.is_manifold = std::adjacent_find(all.begin(), all.end()) == all.end();
  for (const Edge& edge : all)
    if (!std::binary_search(all.begin(), all.end(), Edge{edge.second, edge.first})) out.edges.push_back(edge);
  return out;
}

// The vertices at which the border touches itself.
std::vector<std::uint32_t> crossroadsOf(const Border& border) {
  std::vector<std::uint32_t> out;
  for (std::size_t n = 1; n < border.edges.size(); ++n)
    if (border.edges[n].first == border.edges[n - 1].first) out.push_back(border.edges[n].first);
  return out;
}

// Takes all triangles at those vertices in.
void takeInAround(const Mesh& source, const std::vector<std::uint32_t>& vertices, std::vector<char>& near) {
  std::vector<char> is_there(source.vertices.size(), 0);
  for (const std::uint32_t v : vertices) is_there[v] = 1;
  for (std::size_t t = 0; t < near.size(); ++t)
    for (const std::uint32_t v : source.triangles[t]) near[t] |= is_there[v];
}

using Loop = std::vector<std::uint32_t>;

// @pre no crossroads, and the source is closed. None if it is not.
std::vector<Loop> loopsOf(const Border& border) {
  std::vector<char> is_done(border.edges.size(), 0);
  std::vector<Loop> loops;
  for (std::size_t n = 0; n < border.edges.size(); ++n) {
    if (is_done[n]) continue;
    Loop loop;
    for (std::size_t at = n; !is_done[at];) {
      is_done[at] = 1;
      loop.push_back(border.edges[at].first);
      const std::pair<std::uint32_t, std::uint32_t> next{border.edges[at].second, 0};
      at = static_cast<std::size_t>(std::lower_bound(border.edges.begin(), border.edges.end(), next) -
                                    border.edges.begin());
      if (at == border.edges.size() || border.edges[at].first != next.first) return {};
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

// ---- Caps

// A cap before it has its place in a mesh: the first vertices are those of the rim.
struct Cap {
  std::vector<Vec3d> vertices;
  std::vector<Triangle> triangles;
};

// A cone from the rim to the apex, in rings: each has half the vertices of the one before and about twice its distance
// from the rim. Its triangles stay about as wide as high, so that few of their boxes reach the inside of the cone.
Cap coneOver(const std::vector<Vec3d>& rim, const Vec3d& apex) {
  int rings = 1;
  for (std::size_t left = rim.size(); left > 5; left = (left + 1) / 2) ++rings;

  Cap cap;
  cap.vertices = rim;
  std::vector<std::uint32_t> ring(rim.size()), of_rim(rim.size());
  std::iota(ring.begin(), ring.end(), 0u);
  of_rim = ring;
  for (int n = 1; n < rings; ++n) {
    const double share = (std::exp2(n) - 1) / (std::exp2(rings) - 1);
    std::vector<std::uint32_t> inner, inner_of_rim;
    for (std::size_t k = 0; k < ring.size(); k += 2) {
      inner.push_back(static_cast<std::uint32_t>(cap.vertices.size()));
      inner_of_rim.push_back(of_rim[k]);
      cap.vertices.push_back(rim[of_rim[k]] + share * (apex - rim[of_rim[k]]));
    }
    for (std::size_t k = 0; k < inner.size(); ++k) {
      const std::size_t middle = (2 * k + 1) % ring.size();
      const std::uint32_t next = inner[(k + 1) % inner.size()];
      cap.triangles.push_back({ring[2 * k], ring[middle], inner[k]});
      cap.triangles.push_back({ring[middle], next, inner[k]});
      if (middle == 0) continue;  // the last of an odd number
      cap.triangles.push_back({ring[middle], ring[(2 * k + 2) % ring.size()], next});
    }
    ring = std::move(inner);
    of_rim = std::move(inner_of_rim);
  }

  const auto top = static_cast<std::uint32_t>(cap.vertices.size());
  cap.vertices.push_back(apex);
  for (std::size_t k = 0; k < ring.size(); ++k) cap.triangles.push_back({ring[k], ring[(k + 1) % ring.size()], top});
  return cap;
}

bool isClearOf(const Surface& surface, const Cap& cap) {
  return std::none_of(cap.triangles.begin(), cap.triangles.end(), [&](const Triangle& t) {
    return surface.mayMeet(cap.vertices[t[0]], cap.vertices[t[1]], cap.vertices[t[2]]);
  });
}

// The first cap that stays clear: flat, then higher and higher over either side, then towards the sides of the frame.
std::optional<Cap> capOver(const std::vector<Vec3d>& rim, const Surface& surface) {
  Vec3d middle = Vec3d::Zero(), normal = Vec3d::Zero();
  for (const Vec3d& p : rim) middle += p / static_cast<double>(rim.size());
  double radius = 0;
  for (std::size_t k = 0; k < rim.size(); ++k) {
    normal += (rim[k] - middle).cross(rim[(k + 1) % rim.size()] - middle);
    radius = std::max(radius, (rim[k] - middle).norm());
  }
  if (normal.norm() > 0) normal.normalize();

  std::vector<Vec3d> apexes{middle};
  for (const double height : {0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0})
    for (const double side : {1.0, -1.0}) apexes.emplace_back(middle + side * height * radius * normal);
  for (const double height : {0.5, 1.0, 2.0})
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {1.0, -1.0}) apexes.emplace_back(middle + side * height * radius * Vec3d::Unit(axis));

  for (const Vec3d& apex : apexes)
    if (Cap cap = coneOver(rim, apex); isClearOf(surface, cap)) return cap;
  return {};
}

// Adds a cap to the patch; vertex `at[k]` of the patch is number k of the cap's rim.
void addCap(const Cap& cap, const std::vector<std::uint32_t>& at, NearPatch& patch) {
  const auto first = static_cast<std::uint32_t>(patch.mesh.vertices.size());
  const auto rim = static_cast<std::uint32_t>(at.size());
  for (std::size_t v = rim; v < cap.vertices.size(); ++v) {
    patch.mesh.vertices.push_back(cap.vertices[v]);
    patch.vertex.push_back(kNoSource);
  }
  for (Triangle t : cap.triangles) {
    for (std::uint32_t& v : t) v = v < rim ? at[v] : first + (v - rim);
    patch.mesh.triangles.push_back(t);
    patch.triangle.push_back(kNoSource);
  }
}

// ---- All together

// @return per vertex of the source: its number in the patch, or kNoSource.
std::vector<std::uint32_t> copyNear(const Mesh& source, const std::vector<char>& near, NearPatch& patch) {
  std::vector<std::uint32_t> number(source.vertices.size(), kNoSource);
  for (std::size_t t = 0; t < near.size(); ++t)
    if (near[t])
      for (const std::uint32_t v : source.triangles[t]) number[v] = 0;
  for (std::uint32_t v = 0; v < number.size(); ++v) {
    if (number[v] == kNoSource) continue;
    number[v] = static_cast<std::uint32_t>(patch.mesh.vertices.size());
    patch.mesh.vertices.push_back(source.vertices[v]);
    patch.vertex.push_back(v);
  }

  for (std::uint32_t t = 0; t < near.size(); ++t) {
    if (!near[t]) continue;
    const Triangle& f = source.triangles[t];
    patch.mesh.triangles.push_back({number[f[0]], number[f[1]], number[f[2]]});
    patch.triangle.push_back(t);
  }
  patch.source_triangles = patch.mesh.triangles.size();
  return number;
}

std::optional<NearPatch> patchWithin(const Mesh& source, const Mesh& other, const Surface& surface, double margin) {
  const auto isTooLarge = [](const std::vector<char>& near) {
    return 2 * static_cast<std::size_t>(std::count(near.begin(), near.end(), 1)) > near.size();
  };
  std::vector<char> near = trianglesWithin(source, surface, margin);
  if (isTooLarge(near)) return {};
  takeInComponents(source, other, surface, near);

  Border border = borderOf(source, near);
  std::vector<std::uint32_t> crossroads = crossroadsOf(border);
  for (int n = 0; n < kMostGrowths && border.is_manifold && !crossroads.empty(); ++n) {
    takeInAround(source, crossroads, near);
    border = borderOf(source, near);
    crossroads = crossroadsOf(border);
  }
  if (!border.is_manifold || !crossroads.empty() || isTooLarge(near)) return {};

  NearPatch patch;
  const std::vector<std::uint32_t> number = copyNear(source, near, patch);
  const std::vector<Loop> loops = loopsOf(border);
  const bool is_open = loops.empty() && !border.edges.empty();
  if (is_open || patch.source_triangles == 0) return {};
  for (const Loop& loop : loops) {
    // A cap runs through the border against the patch.
    std::vector<Vec3d> rim;
    std::vector<std::uint32_t> at;
    for (auto v = loop.rbegin(); v != loop.rend(); ++v) {
      rim.push_back(source.vertices[*v]);
      at.push_back(number[*v]);
    }
    const std::optional<Cap> cap = capOver(rim, surface);
    if (!cap) return {};
    addCap(*cap, at, patch);
  }
  return patch;
}

bool isSameTurned(const Triangle& a, const Triangle& b) {
  for (std::size_t k = 0; k < 3; ++k)
    if (a[0] == b[k] && a[1] == b[(k + 1) % 3] && a[2] == b[(k + 2) % 3]) return true;
  return false;
}

// True if each cap exists once, with its own corners.
bool hasAllCaps(const NearPatch& patch, const Difference& near) {
  std::vector<char> is_there(patch.triangle.size(), 0);
  for (std::size_t t = 0; t < near.from_triangle.size(); ++t) {
    const std::uint32_t of = near.from_triangle[t];
    if (of == kNoSource || patch.triangle[of] != kNoSource) continue;
    Triangle corners = near.mesh.triangles[t];
    for (std::uint32_t& v : corners) v = near.from_vertex[v];
    if (is_there[of] || !isSameTurned(corners, patch.mesh.triangles[of])) return false;
    is_there[of] = 1;
  }
  return std::all_of(is_there.begin() + static_cast<std::ptrdiff_t>(patch.source_triangles), is_there.end(),
                     [](char is) { return is != 0; });
}

}  // namespace

bool isApart(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Box3& box) {
  constexpr double kRounding = 1e-9;
  const Vec3d middle = box.center(), half = box.max - middle;
  const std::array<Vec3d, 3> corners{a - middle, b - middle, c - middle};
  const double largest =
      std::max({box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff(), corners[0].cwiseAbs().maxCoeff(),
                corners[1].cwiseAbs().maxCoeff(), corners[2].cwiseAbs().maxCoeff()});
  const auto separates = [&](const Vec3d& axis) {
    const double reach = half.dot(axis.cwiseAbs()) + kRounding * largest * axis.cwiseAbs().sum();
    const double p = corners[0].dot(axis), q = corners[1].dot(axis), r = corners[2].dot(axis);
    return std::min({p, q, r}) > reach || std::max({p, q, r}) < -reach;
  };

  for (int axis = 0; axis < 3; ++axis)
    if (separates(Vec3d::Unit(axis))) return true;
  const std::array<Vec3d, 3> sides{b - a, c - b, a - c};
  if (separates(sides[0].cross(sides[1]))) return true;
  for (const Vec3d& side : sides)
    for (int axis = 0; axis < 3; ++axis)
      if (separates(side.cross(Vec3d::Unit(axis)))) return true;
  return false;
}

std::optional<NearPatch> nearPatch(const Mesh& source, const Mesh& other) {
  if (source.triangles.empty() || other.triangles.empty() || !isClosed(source)) return {};
  const Surface surface(other);
  for (const double sizes : {2.0, 8.0})
    if (auto patch = patchWithin(source, other, surface, sizes * surface.meanSize())) return patch;
  return {};
}

std::optional<Difference> sewnToRest(const Mesh& source, const NearPatch& patch, const Difference& near) {
  if (!hasAllCaps(patch, near)) return {};

  // Vertices of the source that stay: all but those that only the patch had, and lost.
  std::vector<char> is_near(source.triangles.size(), 0), stays(source.vertices.size(), 0);
  for (std::size_t t = 0; t < patch.source_triangles; ++t) is_near[patch.triangle[t]] = 1;
  for (std::size_t t = 0; t < is_near.size(); ++t)
    if (!is_near[t])
      for (const std::uint32_t v : source.triangles[t]) stays[v] = 1;
  const auto sourceOf = [&](std::uint32_t near_vertex) {
    const std::uint32_t v = near.from_vertex[near_vertex];
    return v == kNoSource ? kNoSource : patch.vertex[v];
  };
  for (std::uint32_t v = 0; v < near.from_vertex.size(); ++v)
    if (const std::uint32_t of = sourceOf(v); of != kNoSource) stays[of] = 1;

  Difference out;
  std::vector<std::uint32_t> number(source.vertices.size(), kNoSource), near_number(near.from_vertex.size(), kNoSource);
  for (std::uint32_t v = 0; v < stays.size(); ++v) {
    if (!stays[v]) continue;
    number[v] = static_cast<std::uint32_t>(out.mesh.vertices.size());
    out.mesh.vertices.push_back(source.vertices[v]);
    out.from_vertex.push_back(v);
  }
  for (std::uint32_t v = 0; v < near_number.size(); ++v) {
    if (near.from_vertex[v] == kNoSource) {
      near_number[v] = static_cast<std::uint32_t>(out.mesh.vertices.size());
      out.mesh.vertices.push_back(near.mesh.vertices[v]);
      out.from_vertex.push_back(kNoSource);
    } else if (const std::uint32_t of = sourceOf(v); of != kNoSource)
      near_number[v] = number[of];
  }

  // Triangles of the patch come in the source's order, then the caps, then new ones.
  std::size_t next = 0;
  const auto putNear = [&](std::uint32_t of) {
    const Triangle& t = near.mesh.triangles[next++];
    out.mesh.triangles.push_back({near_number[t[0]], near_number[t[1]], near_number[t[2]]});
    out.from_triangle.push_back(of);
  };
  const auto originOfNext = [&] {
    const std::uint32_t of = next < near.from_triangle.size() ? near.from_triangle[next] : kNoSource;
    return of == kNoSource ? kNoSource : patch.triangle[of];
  };
  for (std::uint32_t t = 0; t < is_near.size(); ++t) {
    if (is_near[t]) {
      while (originOfNext() == t) putNear(t);
      continue;
    }
    const Triangle& f = source.triangles[t];
    out.mesh.triangles.push_back({number[f[0]], number[f[1]], number[f[2]]});
    out.from_triangle.push_back(t);
  }
  for (; next < near.from_triangle.size();) {
    if (near.from_triangle[next] == kNoSource)
      putNear(kNoSource);
    else
      ++next;
  }
  return out;
}

}  // namespace kerf::internal
