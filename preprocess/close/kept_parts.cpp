#include "preprocess/close/kept_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "geometry/mesh/crossing_pairs.h"
#include "geometry/mesh/solids.h"
#include "preprocess/close/base.h"
#include "preprocess/close/winding.h"

namespace kerf::internal {
namespace {

constexpr double kLeastShare = 1e-3;  // of the area: a smaller piece is debris

double partReach(const std::vector<Vec3d>& places, const Vec3d& side) {
  double far = -std::numeric_limits<double>::infinity();
  for (const Vec3d& p : places) far = std::max(far, p.dot(side));
  return far;
}

/// The pieces of a mesh, those that meet as one.
struct Groups {
  std::vector<std::uint32_t> label;  ///< per triangle
  std::vector<double> area;          ///< mm2
  std::vector<Vec3d> middle;         ///< mm, weighted by area
  double total_area = 0;

  std::size_t count() const { return area.size(); }
  bool isLarge(std::uint32_t group) const { return area[group] >= kLeastShare * total_area; }
};

Groups groupsOf(const Mesh& mesh) {
  constexpr std::size_t kMostPairs = 500'000;
  const Pieces pieces = edgeConnectedPieces(mesh);
  std::vector<std::uint32_t> parent(pieces.count);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto find = [&](std::uint32_t n) {
    while (parent[n] != n) n = parent[n] = parent[parent[n]];
    return n;
  };
  if (pieces.count > 1)
    for (const auto& [s, t] : crossingPairs(mesh, kMostPairs)) {
      const std::uint32_t a = find(pieces.label[s]), b = find(pieces.label[t]);
      parent[std::max(a, b)] = std::min(a, b);
    }

  std::vector<std::uint32_t> number(pieces.count, 0);
  std::uint32_t count = 0;
  for (std::uint32_t n = 0; n < pieces.count; ++n) number[n] = find(n) == n ? count++ : number[find(n)];

  Groups out{{}, std::vector<double>(count, 0), std::vector<Vec3d>(count, Vec3d::Zero()), 0};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t group = number[pieces.label[t]];
    const double area = 0.5 * doubleAreaVector(mesh, t).norm();
    out.label.push_back(group);
    out.area[group] += area;
    out.middle[group] += area / 3 * (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2));
    out.total_area += area;
  }
  for (std::uint32_t n = 0; n < count; ++n)
    if (out.area[n] > 0) out.middle[n] /= out.area[n];
  return out;
}

Mesh sourceOf(const Chain& chain) {
  Mesh out;
  out.vertices = chain.mesh.vertices;
  for (std::size_t t = 0; t < chain.source.size(); ++t)
    if (chain.source[t] != kAdded) out.triangles.push_back(chain.mesh.triangles[t]);
  return out;
}

/// Which groups have vertices in which shell of the solid: pairs of shell and group, each once, sorted.
std::vector<std::pair<std::uint32_t, std::uint32_t>> groupsInShells(const Mesh& scan, const Groups& groups,
                                                                    const Mesh& solid) {
  using Place = std::array<double, 3>;
  const auto placeOf = [](const Vec3d& v) {
    const Vec3d p = weldPlace(v);
    return Place{p.x(), p.y(), p.z()};
  };
  std::vector<std::pair<Place, std::uint32_t>> group_at;
  for (std::size_t t = 0; t < scan.triangles.size(); ++t)
    for (const std::uint32_t v : scan.triangles[t]) group_at.push_back({placeOf(scan.vertices[v]), groups.label[t]});
  std::sort(group_at.begin(), group_at.end());
  group_at.erase(std::unique(group_at.begin(), group_at.end()), group_at.end());

  const Pieces shells = edgeConnectedPieces(solid);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> out;
  for (std::size_t t = 0; t < solid.triangles.size(); ++t)
    for (const std::uint32_t v : solid.triangles[t]) {
      const Place place = placeOf(solid.vertices[v]);
      for (auto at = std::lower_bound(group_at.begin(), group_at.end(), std::pair(place, std::uint32_t{0}));
           at != group_at.end() && at->first == place; ++at)
        out.push_back({shells.label[t], at->second});
    }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

/// Tests at some triangles whether a whole group lies outside the solid.
class Outside {
 public:
  Outside(const Mesh& scan, const Groups& groups, const Mesh& solid) : scan_(scan), groups_(groups), rays_(solid) {}

  bool isOutside(std::uint32_t group) const {
    constexpr std::size_t kMostAsked = 16;
    std::size_t asked = 0;
    for (std::size_t t = 0; t < groups_.label.size() && asked < kMostAsked; ++t) {
      if (groups_.label[t] != group) continue;
      const Vec3d p = (scan_.corner(t, 0) + scan_.corner(t, 1) + scan_.corner(t, 2)) / 3;
      const auto winding = rays_.at(p, [](std::uint32_t) { return false; });
      if (!winding || *winding != 0) return false;
      ++asked;
    }
    return asked > 0;
  }

 private:
  const Mesh& scan_;
  const Groups& groups_;
  RayWinding rays_;
};

/// Enters that `members` are one solid now.
void enterJoined(const Groups& groups, const std::vector<std::uint32_t>& members, double& smallest, PieceChanges& out) {
  if (members.size() < 2) return;
  out.joined += members.size() - 1;
  for (const std::uint32_t group : members) {
    if (!(groups.area[group] < smallest)) continue;
    smallest = groups.area[group];
    out.joined_at = groups.middle[group];
  }
}

std::size_t countLarge(const Groups& groups) {
  std::size_t count = 0;
  for (std::uint32_t n = 0; n < groups.count(); ++n) count += groups.isLarge(n);
  return count;
}

}  // namespace

std::vector<SideChange> sideChanges(const std::vector<Vec3d>& scan, const Mesh& solid,
                                    const std::optional<Vec3d>& base_direction) {
  std::vector<Vec3d> sides;
  if (base_direction) {
    const BaseFrame frame = baseFrame(*base_direction);
    sides = {frame.u, -frame.u, frame.v, -frame.v, -frame.w};
  } else {
    for (int axis = 0; axis < 3; ++axis) {
      sides.push_back(Vec3d::Unit(axis));
      sides.push_back(-Vec3d::Unit(axis));
    }
  }

  std::vector<SideChange> out;
  for (const Vec3d& side : sides) out.push_back({side, partReach(solid.vertices, side) - partReach(scan, side)});
  return out;
}

std::string nameOfSide(const Vec3d& side) {
  int axis = 0;
  side.cwiseAbs().maxCoeff(&axis);
  if (std::abs(side[axis]) == 1) return fmt::format("{}{}", side[axis] < 0 ? '-' : '+', "xyz"[axis]);
  return fmt::format("({:.2f}, {:.2f}, {:.2f})", side.x(), side.y(), side.z());
}

PieceChanges comparePieces(const Chain& closed, const Mesh& solid) {
  PieceChanges out;
  const Mesh scan = sourceOf(closed);
  const Groups groups = groupsOf(scan);
  out.pieces = countLarge(groups);
  if (out.pieces < 2) return out;

  // Groups with a shell in the solid, and groups that share a shell.
  const auto in_shells = groupsInShells(scan, groups, solid);
  std::vector<char> is_there(groups.count(), 0);
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0, j = 0; i < in_shells.size(); i = j) {
    std::vector<std::uint32_t> members;
    for (; j < in_shells.size() && in_shells[j].first == in_shells[i].first; ++j) {
      is_there[in_shells[j].second] = 1;
      if (groups.isLarge(in_shells[j].second)) members.push_back(in_shells[j].second);
    }
    enterJoined(groups, members, smallest, out);
  }
  if (std::count(is_there.begin(), is_there.end(), 0) == 0) return out;

  // A group without a shell may lie inside the solid, like nested shells.
  const Outside outside(scan, groups, solid);
  double largest = 0;
  for (std::uint32_t n = 0; n < groups.count(); ++n) {
    if (is_there[n] || !groups.isLarge(n) || !outside.isOutside(n)) continue;
    ++out.lost;
    if (!(groups.area[n] > largest)) continue;
    largest = groups.area[n];
    out.lost_at = groups.middle[n];
  }
  return out;
}

PieceChanges compareWrappedPieces(const Chain& closed, const Mesh& wrap) {
  constexpr std::size_t kMostAsked = 50;
  PieceChanges out;
  const Mesh& mesh = closed.mesh;
  const Groups groups = groupsOf(mesh);
  out.pieces = countLarge(groups);
  if (out.pieces < 2) return out;

  std::vector<std::uint32_t> asked;
  for (std::uint32_t n = 0; n < groups.count(); ++n)
    if (groups.isLarge(n)) asked.push_back(n);
  std::stable_sort(asked.begin(), asked.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return groups.area[a] > groups.area[b]; });
  if (asked.size() > kMostAsked) asked.erase(asked.begin() + kMostAsked, asked.end());

  const Solids solids = solidsOf(wrap);
  std::map<std::uint32_t, std::vector<std::uint32_t>> members;  // of each solid
  for (const std::uint32_t group : asked) {
    const auto first = std::find(groups.label.begin(), groups.label.end(), group) - groups.label.begin();
    const auto t = static_cast<std::size_t>(first);
    const Vec3d p = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
    std::vector<char> is_own(groups.label.size());
    for (std::size_t n = 0; n < is_own.size(); ++n) is_own[n] = groups.label[n] == group;
    if (std::abs(windingNumber(mesh, p, is_own)) > 0.5) continue;  // in another
    if (const auto solid = solidAt(wrap, solids, p)) members[*solid].push_back(group);
  }
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& [solid, groups_there] : members) enterJoined(groups, groups_there, smallest, out);
  return out;
}

}  // namespace kerf::internal
