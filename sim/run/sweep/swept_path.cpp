#include "sim/run/sweep/swept_path.h"

#include <algorithm>
#include <utility>

#include "geometry/tool/sweep.h"

namespace kerf {
namespace {

constexpr std::size_t kLeafMotions = 4;

}  // namespace

SweptPath::SweptPath(const ToolShape& shape, const CutPath& path) : shape_(shape), path_(path) {
  for (std::size_t m = 0; m + 1 < path.poses.size(); ++m)
    if (path.cuts[m]) motions_.push_back(m);
  if (motions_.empty()) return;
  nodes_.reserve(2 * motions_.size() / kLeafMotions + 2);
  build(0, motions_.size());
}

std::size_t SweptPath::build(std::size_t begin, std::size_t end) {
  const std::size_t n = nodes_.size(), middle = begin + (end - begin) / 2;
  nodes_.push_back({.begin = begin, .end = end, .pose = motions_[middle]});
  const Rigid3& mid = path_.poses[motions_[middle]].T_object_tool;
  double travel = 0, turn = 0;

  if (end - begin <= kLeafMotions) {
    for (std::size_t m = begin; m < end; ++m) {
      const Rigid3 &from = path_.poses[motions_[m]].T_object_tool, &to = path_.poses[motions_[m] + 1].T_object_tool;
      // During a motion the turn exceeds that at an end by at most half of the motion's own turn.
      const double ends =
          std::max(from.rotation.angularDistance(mid.rotation), to.rotation.angularDistance(mid.rotation));
      turn = std::max(turn, ends + 0.5 * from.rotation.angularDistance(to.rotation));
      travel =
          std::max({travel, (from.translation - mid.translation).norm(), (to.translation - mid.translation).norm()});
    }
  } else {
    const std::size_t first = build(begin, middle), second = build(middle, end);
    nodes_[n].second = second;
    for (const std::size_t child : {first, second}) {
      const Rigid3& of_child = path_.poses[nodes_[child].pose].T_object_tool;
      travel = std::max(travel, nodes_[child].travel + (of_child.translation - mid.translation).norm());
      turn = std::max(turn, nodes_[child].turn + of_child.rotation.angularDistance(mid.rotation));
    }
  }

  nodes_[n].travel = travel;
  nodes_[n].turn = turn;
  return n;
}

// A point moves in the tool's frame by the tool's travel, and by its turn about a tip at that distance.
double SweptPath::lowerBound(const Node& node, const Vec3d& x) const {
  const Rigid3& mid = path_.poses[node.pose].T_object_tool;
  const Vec3d from_tip = x - mid.translation;
  return shape_.distance(mid.rotation.conjugate() * from_tip) - node.travel - node.turn * from_tip.norm();
}

void SweptPath::visit(std::size_t n, const Vec3d& x, double far, double tolerance, Nearest& out) const {
  const Node& node = nodes_[n];
  if (node.second == 0) {
    for (std::size_t m = node.begin; m < node.end; ++m) {
      const SweptTool sweep(shape_, path_.poses[motions_[m]].T_object_tool, path_.poses[motions_[m] + 1].T_object_tool);
      out.distance_mm = std::min(out.distance_mm, sweep.distance(x, out.distance_mm, tolerance, -far));
      ++out.motions;
    }
    return;
  }

  // The more promising half first.
  std::size_t near = n + 1, other = node.second;
  double near_bound = lowerBound(nodes_[near], x), other_bound = lowerBound(nodes_[other], x);
  if (other_bound < near_bound) {
    std::swap(near, other);
    std::swap(near_bound, other_bound);
  }
  if (near_bound < out.distance_mm) visit(near, x, far, tolerance, out);
  if (other_bound < out.distance_mm) visit(other, x, far, tolerance, out);
}

SweptPath::Nearest SweptPath::nearest(const Vec3d& x_object, double far, double tolerance) const {
  Nearest out{.distance_mm = far};
  if (!nodes_.empty()) visit(0, x_object, far, tolerance, out);
  return out;
}

}  // namespace kerf
