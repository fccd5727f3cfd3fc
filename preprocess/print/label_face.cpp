#include "preprocess/print/label_face.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "geometry/mesh/box_tree.h"

namespace kerf::internal {
namespace {

constexpr double kBeyond = 0.5;      // mm: how far the letters' solid passes the surface
constexpr double kLeastShare = 0.6;  // of the depth, everywhere
constexpr double kRoom = 0.1;        // mm, in front of the letters' solid
constexpr double kEven = 0.1;        // of the depth: letters on a face so even have a flat floor
constexpr double kSteepest = 0.577;  // 30 degrees: letters seen along the normal would smear on a steeper face
constexpr double kInfinite = std::numeric_limits<double>::infinity();

}  // namespace

Error labelError(std::string found, std::string expected, std::string hint) {
  return {.code = Error::Code::kGeometry,
          .place = "label",
          .found = std::move(found),
          .expected = std::move(expected),
          .hint = std::move(hint)};
}

Vec3d LabelFrame::normalAt(double x) const {
  if (radius_mm == 0) return normal;
  const double angle = x / radius_mm;
  return std::sin(angle) * right + std::cos(angle) * normal;
}

Vec3d LabelFrame::at(double x, double y, double z) const {
  if (radius_mm == 0) return point + x * right + y * up + z * normal;
  return point + (radius_mm + z) * normalAt(x) - radius_mm * normal + y * up;
}

double HeightGrid::at(const Point2d& p) const {
  if (z.empty()) return 0;
  const double u = std::clamp((p.x() - low.x()) / (high.x() - low.x()), 0.0, 1.0) * (columns - 1);
  const double v = std::clamp((p.y() - low.y()) / (high.y() - low.y()), 0.0, 1.0) * (rows - 1);
  const int c = std::min(static_cast<int>(u), columns - 2), r = std::min(static_cast<int>(v), rows - 2);
  const double x = u - c, y = v - r;
  return (1 - x) * ((1 - y) * knot(c, r) + y * knot(c, r + 1)) +
         x * ((1 - y) * knot(c + 1, r) + y * knot(c + 1, r + 1));
}

HeightGrid HeightGrid::smoothed() const {
  constexpr int kAround = 3;  // knots each way
  HeightGrid out = *this;
  for (int c = 0; c < columns; ++c)
    for (int r = 0; r < rows; ++r) {
      // The same number on both sides, so that a slope stays one at the border.
      const int a = std::min({kAround, c, columns - 1 - c}), b = std::min({kAround, r, rows - 1 - r});
      double sum = 0;
      for (int x = c - a; x <= c + a; ++x)
        for (int y = r - b; y <= r + b; ++y) sum += knot(x, y);
      out.knot(c, r) = sum / ((2 * a + 1) * (2 * b + 1));
    }
  return out;
}

double HeightGrid::steepest() const {
  const double dx = (high.x() - low.x()) / (columns - 1), dy = (high.y() - low.y()) / (rows - 1);
  double out = 0;
  for (int c = 0; c + 1 < columns; ++c)
    for (int r = 0; r + 1 < rows; ++r)
      out = std::max(out, std::hypot((knot(c + 1, r) - knot(c, r)) / dx, (knot(c, r + 1) - knot(c, r)) / dy));
  return out;
}

FaceHeights faceHeights(const Mesh& solid, const LabelFrame& frame, const Point2d& low, const Point2d& high,
                        double deep_mm) {
  constexpr double kStep = 0.2;  // mm
  const int columns = std::max(2, static_cast<int>(std::ceil((high.x() - low.x()) / kStep)) + 1);
  const int rows = std::max(2, static_cast<int>(std::ceil((high.y() - low.y()) / kStep)) + 1);
  const auto column = [&](int n) { return low.x() + (high.x() - low.x()) * n / (columns - 1); };
  const auto row = [&](int n) { return low.y() + (high.y() - low.y()) * n / (rows - 1); };

  // The triangles near the label.
  Box3 near;
  for (int n = 0; n < columns; ++n)
    for (const double y : {low.y(), high.y()})
      for (const double z : {-deep_mm, FaceHeights::kReach}) near.add(frame.at(column(n), y, z));
  near.grow(1e-6);
  std::vector<std::uint32_t> triangle;
  std::vector<Box3> boxes;
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    Box3 box;
    for (int k = 0; k < 3; ++k) box.add(solid.corner(t, k));
    if (!overlap(box, near)) continue;
    triangle.push_back(static_cast<std::uint32_t>(t));
    boxes.push_back(box);
  }
  const BoxTree tree(std::move(boxes));

  struct Hit {
    double z;
    bool is_front;
  };
  FaceHeights out;
  out.surface = {low, high, columns, rows, {}};
  out.surface.z.assign(static_cast<std::size_t>(columns * rows), 0);
  out.back.assign(out.surface.z.size(), -kInfinite);
  out.front.assign(out.surface.z.size(), kInfinite);
  std::vector<Hit> hits;
  for (int c = 0; c < columns; ++c)
    for (int r = 0; r < rows; ++r) {
      // On the way in, from z = kReach to -deep.
      const Vec3d normal = frame.normalAt(column(c)), foot = frame.at(column(c), row(r), 0);
      Box3 ray;
      ray.add(foot + FaceHeights::kReach * normal);
      ray.add(foot - deep_mm * normal);
      ray.grow(1e-9);
      hits.clear();
      tree.visit([&](const Box3& box) { return overlap(box, ray); },
                 [&](std::uint32_t n) {
                   // Moeller & Trumbore 1997; a point on an edge counts for both triangles.
                   const std::size_t t = triangle[n];
                   const Vec3d a = solid.corner(t, 0), ab = solid.corner(t, 1) - a, ac = solid.corner(t, 2) - a;
                   const Vec3d across = normal.cross(ac);
                   const double area = ab.dot(across);
                   constexpr double kEdge = 1e-7;
                   if (area == 0) return true;
                   const Vec3d from = foot - a;
                   const double u = from.dot(across) / area;
                   const Vec3d q = from.cross(ab);
                   const double v = normal.dot(q) / area;
                   if (u < -kEdge || v < -kEdge || u + v > 1 + kEdge) return true;
                   const double z = ac.dot(q) / area;
                   if (z <= FaceHeights::kReach && z >= -deep_mm) hits.push_back({z, ab.cross(ac).dot(normal) > 0});
                   return true;
                 });

      const Hit* surface = nullptr;
      for (const Hit& hit : hits)
        if (hit.is_front && std::abs(hit.z) <= FaceHeights::kReach &&
            (!surface || std::abs(hit.z) < std::abs(surface->z)))
          surface = &hit;
      if (!surface) {
        ++out.missing;
        continue;
      }
      out.surface.knot(c, r) = surface->z;
      constexpr double kSame = 1e-6;  // mm
      const auto n = static_cast<std::size_t>(c * rows + r);
      for (const Hit& hit : hits) {
        if (hit.z > surface->z + kSame) out.front[n] = std::min(out.front[n], hit.z);
        if (!hit.is_front && hit.z < surface->z - kSame) out.back[n] = std::max(out.back[n], hit.z);
      }
    }
  return out;
}

Expected<LabelSpan> spanOn(const FaceHeights& face, const LabelOptions& label, LabelReport& report) {
  const std::vector<double>& surface = face.surface.z;
  if (face.missing > 0)
    return fail(
        labelError(fmt::format("a text of {:.1f} x {:.1f} mm that reaches beyond the face: {} of {} places are "
                               "without surface within {} mm",
                               report.width_mm, report.height_mm, face.missing, surface.size(), FaceHeights::kReach),
                   "a face under the whole text", "a smaller text, more lines, another point, or a bend radius"));
  const auto [lowest, highest] = std::minmax_element(surface.begin(), surface.end());
  report.unevenness_mm = *highest - *lowest;

  LabelSpan out;
  double slope = 0;
  if (report.unevenness_mm > kEven * label.depth_mm) {
    out.ground = face.surface.smoothed();
    slope = out.ground.steepest();
    if (slope > kSteepest)
      return fail(labelError(
          fmt::format("a surface that slopes by up to {:.0f} degrees under a text of {:.1f} x {:.1f} mm",
                      std::atan(slope) * 180 / std::numbers::pi, report.width_mm, report.height_mm),
          "at most 30 degrees from the label's normal", "a flatter place, a smaller text, or a bend radius"));
  }
  double low = kInfinite, high = -kInfinite, back = -kInfinite, front = kInfinite;
  for (std::size_t n = 0; n < surface.size(); ++n) {
    const double ground = out.ground.z.empty() ? 0 : out.ground.z[n];
    low = std::min(low, surface[n] - ground);
    high = std::max(high, surface[n] - ground);
    back = std::max(back, face.back[n] - ground);
    front = std::min(front, face.front[n] - ground);
  }
  // On a slope the depth counts across the surface.
  const double across = 1 / std::hypot(1, slope);
  report.most_depth_mm = label.depth_mm;
  report.least_depth_mm = (label.depth_mm - (high - low)) * across;
  if (report.least_depth_mm < kLeastShare * label.depth_mm)
    return fail(labelError(fmt::format("a surface too rough for letters {} mm {}: they would have {:.2f} mm in places",
                                       label.depth_mm, label.embossed ? "high" : "deep", report.least_depth_mm),
                           fmt::format("at least {:.2f} mm, 60 % of the depth", kLeastShare * label.depth_mm),
                           "a smoother place, or a deeper text"));

  if (label.embossed) {
    out.high = low + label.depth_mm;
    out.low = low - std::min(kBeyond, (low - back) / 2);
  } else {
    out.low = high - label.depth_mm;
    out.high = high + kBeyond;
    const double wall = (out.low - back) * across;
    if (wall < kLabelDeep / 2) report.wall_mm = wall;
    if (wall < label.least_wall_mm)
      return fail(labelError(
          wall > 0 ? fmt::format("a wall of {:.2f} mm left behind letters {} mm deep", wall, label.depth_mm)
                   : fmt::format("letters {} mm deep that break through a wall of {:.2f} mm", label.depth_mm,
                                 wall + label.depth_mm),
          fmt::format("at least {} mm", label.least_wall_mm), "a shallower or embossed label, or another place"));
  }
  if (front < out.high + kRoom)
    return fail(labelError(fmt::format("another surface {:.2f} mm in front of the face", front - low),
                           fmt::format("{:.2f} mm of room", out.high + kRoom - low), "another place"));
  return out;
}

}  // namespace kerf::internal
