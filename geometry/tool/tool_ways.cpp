#include "geometry/tool/tool_ways.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace kerf {
namespace {

constexpr double kMostGuessedCut = 4;  // mm: a bur cuts that far or less; the user gives a longer head
constexpr double kPlanStep = 0.25;     // mm, between measured heights
constexpr double kWider = 1.6;         // times the width near the tip: ends the head

// The part of a mesh near its lowest end along an axis, upright: the axis is z, the end at 0.
struct LowEnd {
  std::vector<std::array<Vec3d, 3>> triangles;
  Eigen::Quaterniond to_file;  // rotation back to the file
  double lowest = 0;           // in the file
  double length = 0;           // of the whole mesh
};
LowEnd lowEnd(const Mesh& mesh, const Vec3d& axis) {
  LowEnd out;
  const Eigen::Quaterniond upright = Eigen::Quaterniond::FromTwoVectors(axis, Vec3d::UnitZ()).normalized();
  out.to_file = upright.conjugate();
  double highest = -std::numeric_limits<double>::infinity();
  out.lowest = -highest;
  for (const Vec3d& p : mesh.vertices) {
    out.lowest = std::min(out.lowest, axis.dot(p));
    highest = std::max(highest, axis.dot(p));
  }
  out.length = highest - out.lowest;

  const double top = out.lowest + kMostGuessedCut;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::array<Vec3d, 3> corners = {mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)};
    if (std::min({axis.dot(corners[0]), axis.dot(corners[1]), axis.dot(corners[2])}) > top) continue;
    auto& made = out.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) made[k] = upright * corners[k] - Vec3d(0, 0, out.lowest);
  }
  return out;
}

// Visits the points where edges cross a height.
template <class Visit>
void crossings(const LowEnd& end, double height, const Visit& visit) {
  for (const std::array<Vec3d, 3>& triangle : end.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3d &a = triangle[k], &b = triangle[(k + 1) % 3];
      const double low = a[2] - height, high = b[2] - height;
      if ((low < 0) != (high < 0)) visit(Vec3d(a + low / (low - high) * (b - a)));
    }
}

// Axis from a thin end in no direction of the file, such as the bur of a contra-angle. Takes the protruding point with
// the thinnest surroundings, and the axis to their middle. None: nothing protrudes.
std::optional<Vec3d> fromThinEnd(const Mesh& mesh) {
  constexpr std::size_t kMostPoints = 20000, kSides = 200, kFewest = 4;
  constexpr double kPoint = 0.4, kNear = 2.5;  // mm
  const std::size_t step = mesh.vertices.size() / kMostPoints + 1;
  std::vector<Vec3d> points;
  for (std::size_t v = 0; v < mesh.vertices.size(); v += step) points.push_back(mesh.vertices[v]);

  std::optional<Vec3d> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < kSides; ++n) {
    // Evenly over a sphere, along a spiral.
    const double height = 1 - (2 * static_cast<double>(n) + 1) / kSides, turn = 2.399963 * static_cast<double>(n);
    const double across = std::sqrt(1 - height * height);
    const Vec3d side(across * std::cos(turn), across * std::sin(turn), height);
    const Vec3d farthest = *std::max_element(points.begin(), points.end(),
                                             [&](const Vec3d& a, const Vec3d& b) { return side.dot(a) < side.dot(b); });
    // The middle of a blunt point.
    Vec3d tip = Vec3d::Zero();
    double at_tip = 0;
    for (const Vec3d& p : points)
      if ((p - farthest).squaredNorm() < kPoint * kPoint) {
        tip += p;
        ++at_tip;
      }
    tip /= at_tip;

    Vec3d sum = Vec3d::Zero();
    std::size_t count = 0;
    const auto isNear = [&](const Vec3d& p) { return (p - tip).squaredNorm() < kNear * kNear; };
    for (const Vec3d& p : points)
      if (isNear(p)) {
        sum += p - tip;
        ++count;
      }
    if (count < kFewest || !(sum.norm() > 1e-6)) continue;
    const Vec3d axis = sum.normalized();
    double radius = 0;
    for (const Vec3d& p : points)
      if (isNear(p)) radius = std::max(radius, (p - tip - axis.dot(p - tip) * axis).norm());
    if (radius >= least) continue;
    least = radius;
    best = axis;
  }
  return best;
}

}  // namespace

Mesh withoutStrayVertices(const Mesh& mesh) { return subset(mesh, std::vector<char>(mesh.triangles.size(), 1)); }

SurfaceSpread spreadOf(const Mesh& mesh) {
  SurfaceSpread out;
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double weight = doubleAreaVector(mesh, t).norm();
    out.middle += weight / 3 * (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2));
    area += weight;
  }
  if (!(area > 0)) return {};
  out.middle /= area;

  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    // Covers all points of a triangle, not only its middle: a rod may be a box of twelve.
    const double weight = doubleAreaVector(mesh, t).norm() / area / 12;
    Vec3d sum = Vec3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const Vec3d d = mesh.corner(t, k) - out.middle;
      spread += weight * d * d.transpose();
      sum += d;
    }
    spread += weight * sum * sum.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  if (axes.info() != Eigen::Success) return {};
  out.extents = axes.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  out.longest = axes.eigenvectors().col(2).normalized();
  return out;
}

ToolWay toolWayAlong(const Mesh& mesh, const std::string& name, const Vec3d& axis) {
  ToolWay way{.name = name, .axis = axis};
  const LowEnd end = lowEnd(mesh, way.axis);

  // The tip is in the middle of the end as seen along the axis: of its corners and of its section at `top`.
  const double top = std::min(ToolWay::kTipLength, 0.5 * end.length);
  std::vector<Vec3d> points;
  for (const std::array<Vec3d, 3>& triangle : end.triangles)
    for (const Vec3d& p : triangle)
      if (p[2] <= top) points.push_back(p);
  crossings(end, top, [&](const Vec3d& p) { points.push_back(p); });
  Box3 box;
  for (const Vec3d& p : points) box.add(p);
  const Eigen::Vector2d middle = box.center().head<2>();
  double radius = 0;
  for (const Vec3d& p : points) radius = std::max(radius, (p.head<2>() - middle).norm());
  way.tip = end.to_file * Vec3d(middle[0], middle[1], end.lowest);
  way.tip_width_mm = 2 * radius;

  // The cutting part ends where it becomes clearly wider.
  way.cut_below_mm = std::min(kMostGuessedCut, end.length);
  for (double above = top; above < way.cut_below_mm; above += kPlanStep) {
    double reach = 0;
    crossings(end, above, [&](const Vec3d& p) { reach = std::max(reach, (p.head<2>() - middle).norm()); });
    if (reach > kWider * radius) way.cut_below_mm = above;
  }
  return way;
}

std::vector<ToolWay> toolWays(const Mesh& mesh_mm) {
  const Mesh mesh = withoutStrayVertices(mesh_mm);
  const Vec3d length = spreadOf(mesh).longest;
  const std::array<std::pair<const char*, Vec3d>, 8> kWays = {{{"+x", Vec3d::UnitX()},
                                                               {"-x", -Vec3d::UnitX()},
                                                               {"+y", Vec3d::UnitY()},
                                                               {"-y", -Vec3d::UnitY()},
                                                               {"+z", Vec3d::UnitZ()},
                                                               {"-z", -Vec3d::UnitZ()},
                                                               {"length", length},
                                                               {"-length", -length}}};
  std::vector<ToolWay> out;
  for (const auto& [name, axis] : kWays) out.push_back(toolWayAlong(mesh, name, axis));
  if (const auto axis = fromThinEnd(mesh)) out.push_back(toolWayAlong(mesh, "thin-end", *axis));
  // Sorts an axis of the file before an equal length axis, despite rounding.
  constexpr double kSame = 0.02;  // mm
  const auto steps = [](const ToolWay& way) { return std::lround(way.tip_width_mm / kSame); };
  std::stable_sort(out.begin(), out.end(), [&](const ToolWay& a, const ToolWay& b) { return steps(a) < steps(b); });
  return out;
}

}  // namespace kerf
