#include "sim/step/contact_points.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/step/touching_shell.h"

namespace kerf {
namespace {

constexpr int kPlaces = 4;  // cells along a side of a part's box
constexpr int kWays = 6;    // directions: a normal's largest coordinate and its sign
constexpr int kCells = 2 * kWays * kPlaces * kPlaces * kPlaces;
constexpr float kTissues = 0.97f, kTools = 0.9f;  // cosines between both normals: see blendedNormal()
constexpr float kLeastSlope = 0.25f;              // a node that faces away holds nothing
constexpr float kSmooth = 0.8f;                   // of the gradient of tau: less at an edge inside the tool
constexpr double kLayer = 0.75;                   // voxels from the surface: values farther out are extrapolated

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

// The deepest node of each cell: see ContactPoints::gather().
struct DeepestNodes {
  struct Node {
    Vec3f normal, in_tool;
    Vec3d from_tip;
  };
  std::array<float, kCells> gaps;  // mm; 0: no node
  std::array<Node, kCells> nodes;
  // Cells by depth, deepest first; the first `count` of them.
  std::array<std::uint16_t, kCells> order;
  std::size_t count = 0;

  DeepestNodes() { gaps.fill(0); }

  static bool isOfBody(std::size_t cell) { return cell >= kCells / 2; }
  const Node& node(std::size_t n) const { return nodes[order[n]]; }
  float gap(std::size_t n) const { return gaps[order[n]]; }

  // @return how many nodes were tested.
  int find(CutObject& object, const NearBricks& near, const ContactInput& in, const Eigen::Matrix3f& to_tool) {
    const ToolModel& tool = *in.tool;
    const float layer = static_cast<float>(kLayer * object.voxel());
    // Both parts may end at the same face, for example a blade's teeth: that face cuts.
    const float coincide = static_cast<float>(0.02 * object.voxel());
    return internal::forEachTouching(object, near, tool, in.T_object_tool, [&](const internal::TouchingNode& node) {
      const bool is_body = node.tau < node.tau_cut - coincide;
      if ((in.geometry_only && !is_body) || std::abs(node.phi) > layer) return;
      const int half = is_body ? kCells / 2 : 0;
      const auto cell = static_cast<std::size_t>(
          half + cellOf(node.in_tool, to_tool * node.normal(), is_body ? tool.body.bounds() : tool.cut.bounds()));
      if (node.gap < gaps[cell]) {
        gaps[cell] = node.gap;
        nodes[cell] = {node.normal(), node.in_tool, node.from_tip};
      }
    });
  }

  void sort(std::size_t most) {
    for (std::size_t cell = 0; cell < kCells; ++cell)
      if (gaps[cell] < 0) order[count++] = static_cast<std::uint16_t>(cell);
    std::sort(order.begin(), order.begin() + count,
              [this](std::uint16_t a, std::uint16_t b) { return gaps[a] != gaps[b] ? gaps[a] < gaps[b] : a < b; });
    count = std::min(count, most);
  }
};

using Gradients = std::array<Vec3f, ContactPoints::kMost>;

// The gradient of tau at all of them, tool frame, by central differences of the touching part.
void findGradients(const DeepestNodes& deepest, const ToolModel& tool, double voxel, Gradients& gradients) {
  constexpr std::size_t kMost = ContactPoints::kMost;
  const float aside = static_cast<float>(0.2 * voxel);
  const int padded = (static_cast<int>(deepest.count) + 7) / 8 * 8;
  for (int axis = 0; axis < 3; ++axis) {
    std::array<float, kMost> place[3] = {}, cut[2], body[2];
    for (std::size_t side = 0; side < 2; ++side) {
      for (std::size_t n = 0; n < deepest.count; ++n) {
        Vec3f p = deepest.node(n).in_tool;
        p[axis] += side == 0 ? -aside : aside;
        for (std::size_t c = 0; c < 3; ++c) place[c][n] = p[static_cast<Eigen::Index>(c)];
      }
      tool.cut.distances(place[0].data(), place[1].data(), place[2].data(), cut[side].data(), padded);
      tool.body.distances(place[0].data(), place[1].data(), place[2].data(), body[side].data(), padded);
    }
    for (std::size_t n = 0; n < deepest.count; ++n) {
      const auto& tau = DeepestNodes::isOfBody(deepest.order[n]) ? body : cut;
      gradients[n][axis] = (tau[1][n] - tau[0][n]) / (2 * aside);
    }
  }
}

// The tissue's normal where it nearly agrees with the tool's: it does not change from node to node. Elsewhere, at an
// edge of the tissue, the tool's: motion that does not change the gap is not held.
// @param away  minus the gradient of tau.   @param slope  its part along the tissue's normal.
Vec3f blendedNormal(const Vec3f& tissue, const Vec3f& away, float slope) {
  const float trust = std::clamp((slope / away.norm() - kTools) / (kTissues - kTools), 0.0f, 1.0f);
  return (trust * tissue + (1 - trust) * away.normalized()).normalized();
}

}  // namespace

Vector6d ContactPoint::direction() const {
  Vector6d u;
  u.head<3>() = normal;
  u.tail<3>() = lever.cross(normal);
  return u;
}

int ContactPoints::gather(CutObject& object, int index, const NearBricks& near, const ContactInput& in) noexcept {
  const Eigen::Matrix3f to_tool = in.T_object_tool.rotation.toRotationMatrix().transpose().cast<float>();
  DeepestNodes deepest;
  const int tested = deepest.find(object, near, in, to_tool);
  deepest.sort(kMost);
  if (deepest.count == 0) return tested;
  Gradients gradients;
  findGradients(deepest, *in.tool, object.voxel(), gradients);

  // Makes points of the nodes that face the tool.
  const Eigen::Matrix3d to_world = object.T_world_object.rotation.toRotationMatrix();
  const Eigen::Matrix3f tool_to_object = to_tool.transpose();
  std::array<ContactPoint, kMost> added;
  std::size_t facing = 0;
  for (std::size_t n = 0; n < deepest.count; ++n) {
    const DeepestNodes::Node& node = deepest.node(n);
    const Vec3f away = -(tool_to_object * gradients[n]);
    const float slope = away.dot(node.normal);
    if (!(slope > kLeastSlope) || away.norm() < kSmooth) continue;
    const Vec3f normal = blendedNormal(node.normal, away, slope);
    added[facing++] = {to_world * normal.cast<double>(),
                       to_world * node.from_tip,
                       static_cast<double>(deepest.gap(n)),
                       std::clamp(static_cast<double>(away.dot(normal)), static_cast<double>(kLeastSlope), 1.0),
                       index,
                       !DeepestNodes::isOfBody(deepest.order[n])};
  }

  // Keeps the deepest points of all objects.
  std::array<ContactPoint, 2 * kMost> all;
  const auto end = std::merge(points_.begin(), points_.begin() + count_, added.begin(), added.begin() + facing,
                              all.begin(), [](const ContactPoint& a, const ContactPoint& b) { return a.gap < b.gap; });
  count_ = std::min(static_cast<int>(end - all.begin()), kMost);
  std::copy_n(all.begin(), count_, points_.begin());
  return tested;
}

double ContactLoads::total() const { return std::accumulate(loads.load.begin(), loads.load.begin() + count_, 0.0); }

double ContactLoads::ofObject(const ContactPoints& points, int object) const {
  double sum = 0;
  for (int n = 0; n < count_; ++n)
    if (points[n].object == object) sum += loads.load[static_cast<std::size_t>(n)];
  return sum;
}

double ContactLoads::ofCutting(const ContactPoints& points, int object) const {
  double sum = 0;
  for (int n = 0; n < count_; ++n)
    if (points[n].object == object && points[n].cuts) sum += loads.load[static_cast<std::size_t>(n)];
  return sum;
}

Vector6d ContactLoads::push(const ContactPoints& points) const {
  Vector6d sum = Vector6d::Zero();
  for (int n = 0; n < count_; ++n) sum += loads.load[static_cast<std::size_t>(n)] * points[n].direction();
  return sum;
}

void ContactLoads::solve(const Matrix6d& a, const Vector6d& b, const ContactPoints& points, const Row& least,
                         double softness) noexcept {
  count_ = points.size();
  OneSidedLoads::Directions directions;
  for (int n = 0; n < count_; ++n) directions[static_cast<std::size_t>(n)] = points[n].direction();
  Row same;
  same.fill(softness);
  loads.solve(a, b, std::span(directions).first(static_cast<std::size_t>(count_)), least, same);
}

}  // namespace kerf
