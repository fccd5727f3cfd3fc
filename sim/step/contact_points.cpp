#include "sim/step/contact_points.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/step/touching_shell.h"

namespace kerf {
namespace {

constexpr int kPlaces = 4;  // cells along a side of a part's box
constexpr int kWays = 6;    // a normal's largest coordinate and its sign
constexpr int kCells = 2 * kWays * kPlaces * kPlaces * kPlaces;
constexpr float kTissues = 0.97f, kTools = 0.9f;  // cosines between both normals: see gather()
constexpr float kLeastSlope = 0.25f;              // a node whose face looks away holds nothing
constexpr float kSmooth = 0.8f;                   // of the gradient of tau: less is at an edge inside the tool
constexpr double kLayer = 0.75;                   // voxels from the surface: farther nodes know of it by extrapolation
constexpr int kSweeps = 60;
constexpr double kSettled = 1e-9;  // of the largest load: a sweep that changes less is the last

int cellOf(const Vec3f& place, const Vec3f& normal, const Box3& box) {
  Eigen::Index axis;
  normal.cwiseAbs().maxCoeff(&axis);
  int cell = 2 * static_cast<int>(axis) + (normal[axis] < 0);
  const Vec3d size = box.size().cwiseMax(1e-6);
  for (int c = 0; c < 3; ++c) {
    const double at = kPlaces * (static_cast<double>(place[c]) - box.min[c]) / size[c];
    cell = kPlaces * cell + static_cast<int>(std::clamp(at, 0.0, kPlaces - 1.0));
  }
  return cell;
}

}  // namespace

Vector6d ContactPoint::direction() const {
  Vector6d u;
  u.head<3>() = normal;
  u.tail<3>() = lever.cross(normal);
  return u;
}

int ContactPoints::gather(CutObject& object, int index, const NearBricks& near, const ContactInput& in) noexcept {
  const ToolModel& tool = *in.tool;
  const Eigen::Matrix3f to_tool = in.T_object_tool.rotation.toRotationMatrix().transpose().cast<float>();
  const float layer = static_cast<float>(kLayer * object.voxel());
  // Both parts may end at the same face, a blade's teeth for one: it cuts.
  const float coincide = static_cast<float>(0.02 * object.voxel());
  struct Deepest {
    Vec3f normal, in_tool;
    Vec3d from_tip;
  };
  std::array<float, kCells> gaps;
  gaps.fill(0);
  std::array<Deepest, kCells> deepest;
  const int tested =
      internal::forEachTouching(object, near, tool, in.T_object_tool, [&](const internal::TouchingNode& node) {
        const bool is_body = node.tau < node.tau_cut - coincide;
        if ((in.geometry_only && !is_body) || std::abs(node.phi) > layer) return;
        const int half = is_body ? kCells / 2 : 0;
        const auto cell = static_cast<std::size_t>(
            half + cellOf(node.in_tool, to_tool * node.normal, is_body ? tool.body.bounds() : tool.cut.bounds()));
        if (node.gap < gaps[cell]) {
          gaps[cell] = node.gap;
          deepest[cell] = {node.normal, node.in_tool, node.from_tip};
        }
      });
  std::array<std::uint16_t, kCells> order;
  std::size_t found = 0;
  for (std::size_t cell = 0; cell < kCells; ++cell)
    if (gaps[cell] < 0) order[found++] = static_cast<std::uint16_t>(cell);
  if (found == 0) return tested;
  const auto is_deeper = [&](std::uint16_t a, std::uint16_t b) {
    return gaps[a] != gaps[b] ? gaps[a] < gaps[b] : a < b;
  };
  std::sort(order.begin(), order.begin() + found, is_deeper);
  found = std::min(found, static_cast<std::size_t>(kMost));

  // The gradient of tau at all of them, by central differences of the part that was met.
  const float look = static_cast<float>(0.2 * object.voxel());
  const int padded = (static_cast<int>(found) + 7) / 8 * 8;
  std::array<Vec3f, kMost> gradient;
  for (int axis = 0; axis < 3; ++axis) {
    std::array<float, kMost> place[3] = {}, cut[2], body[2];
    for (int side = 0; side < 2; ++side) {
      for (std::size_t n = 0; n < found; ++n) {
        Vec3f p = deepest[order[n]].in_tool;
        p[axis] += side == 0 ? -look : look;
        for (std::size_t c = 0; c < 3; ++c) place[c][n] = p[static_cast<Eigen::Index>(c)];
      }
      const auto at = static_cast<std::size_t>(side);
      tool.cut.distances(place[0].data(), place[1].data(), place[2].data(), cut[at].data(), padded);
      tool.body.distances(place[0].data(), place[1].data(), place[2].data(), body[at].data(), padded);
    }
    for (std::size_t n = 0; n < found; ++n) {
      const auto& tau = order[n] >= kCells / 2 ? body : cut;
      gradient[n][axis] = (tau[1][n] - tau[0][n]) / (2 * look);
    }
  }
  const Eigen::Matrix3d to_world = object.T_world_object.rotation.toRotationMatrix();
  const Eigen::Matrix3f tool_to_object = to_tool.transpose();
  std::array<ContactPoint, kMost> added;
  std::size_t facing = 0;
  for (std::size_t n = 0; n < found; ++n) {
    const Deepest& node = deepest[order[n]];
    const Vec3f away = -(tool_to_object * gradient[n]);
    const float slope = away.dot(node.normal);
    if (!(slope > kLeastSlope) || away.norm() < kSmooth) continue;
    // The tissue's normal where both nearly agree: it does not change from node to node. Where they do not, at an edge
    // of the tissue, the tool's: moving along what the gap does not change with is not held.
    const float trust = std::clamp((slope / away.norm() - kTools) / (kTissues - kTools), 0.0f, 1.0f);
    const Vec3f normal = (trust * node.normal + (1 - trust) * away.normalized()).normalized();
    added[facing++] = {to_world * normal.cast<double>(),
                       to_world * node.from_tip,
                       static_cast<double>(gaps[order[n]]),
                       std::clamp(static_cast<double>(away.dot(normal)), static_cast<double>(kLeastSlope), 1.0),
                       index,
                       order[n] < kCells / 2};
  }
  std::array<ContactPoint, 2 * kMost> all;
  const auto end = std::merge(points_.begin(), points_.begin() + count_, added.begin(), added.begin() + facing,
                              all.begin(), [](const ContactPoint& a, const ContactPoint& b) { return a.gap < b.gap; });
  count_ = std::min(static_cast<int>(end - all.begin()), kMost);
  std::copy_n(all.begin(), count_, points_.begin());
  return tested;
}

double ContactLoads::total() const { return std::accumulate(load.begin(), load.begin() + count_, 0.0); }

double ContactLoads::ofObject(const ContactPoints& points, int object) const {
  double sum = 0;
  for (int n = 0; n < count_; ++n)
    if (points[n].object == object) sum += load[static_cast<std::size_t>(n)];
  return sum;
}

double ContactLoads::ofCutting(const ContactPoints& points, int object) const {
  double sum = 0;
  for (int n = 0; n < count_; ++n)
    if (points[n].object == object && points[n].cuts) sum += load[static_cast<std::size_t>(n)];
  return sum;
}

Vector6d ContactLoads::push(const ContactPoints& points) const {
  Vector6d sum = Vector6d::Zero();
  for (int n = 0; n < count_; ++n) sum += load[static_cast<std::size_t>(n)] * points[n].direction();
  return sum;
}

void ContactLoads::solve(const Matrix6d& a, const Vector6d& b, const ContactPoints& points, const Row& least,
                         double softness) noexcept {
  count_ = points.size();
  const auto count = static_cast<std::size_t>(count_);
  const Eigen::LDLT<Matrix6d> inverse(a);
  motion = inverse.solve(b);
  std::array<Vector6d, ContactPoints::kMost> direction, answer;
  Row flexibility;
  for (std::size_t n = 0; n < count; ++n) {
    direction[n] = points[static_cast<int>(n)].direction();
    answer[n] = inverse.solve(direction[n]);
    flexibility[n] = direction[n].dot(answer[n]);
    motion += load[n] * answer[n];
  }
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double change = 0, largest = 0;
    for (std::size_t n = 0; n < count; ++n) {
      const double before = load[n];
      load[n] = std::max(
          0.0, before + (least[n] - direction[n].dot(motion) - softness * before) / (flexibility[n] + softness));
      motion += (load[n] - before) * answer[n];
      change = std::max(change, std::abs(load[n] - before));
      largest = std::max(largest, load[n]);
    }
    if (change <= kSettled * largest) break;
  }
  if (!motion.allFinite()) {
    motion.setZero();
    load.fill(0);
  }
}

}  // namespace kerf
