#include "preprocess/print/label_face.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/mesh/box_tree.h"

namespace kerf::internal {
namespace {

constexpr double kBeyond = 0.5;      // mm: how far the letters' solid passes the surface
constexpr double kLeastShare = 0.6;  // of the depth, everywhere
constexpr double kRoom = 0.1;        // mm, in front of the letters' solid

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

      ++out.samples;
      const Hit* surface = nullptr;
      for (const Hit& hit : hits)
        if (hit.is_front && std::abs(hit.z) <= FaceHeights::kReach &&
            (!surface || std::abs(hit.z) < std::abs(surface->z)))
          surface = &hit;
      if (!surface) {
        ++out.missing;
        continue;
      }
      out.low = std::min(out.low, surface->z);
      out.high = std::max(out.high, surface->z);
      constexpr double kSame = 1e-6;  // mm
      for (const Hit& hit : hits) {
        if (hit.z > surface->z + kSame) out.front = std::min(out.front, hit.z);
        if (!hit.is_front && hit.z < surface->z - kSame) out.back = std::max(out.back, hit.z);
      }
    }
  return out;
}

Expected<LabelSpan> spanOn(const FaceHeights& face, const LabelOptions& label, LabelReport& report) {
  if (face.missing > 0)
    return fail(
        labelError(fmt::format("a text of {:.1f} x {:.1f} mm that reaches beyond the face: {} of {} places are "
                               "without surface within {} mm",
                               report.width_mm, report.height_mm, face.missing, face.samples, FaceHeights::kReach),
                   "a face under the whole text", "a smaller text, more lines, another point, or a bend radius"));
  report.unevenness_mm = face.high - face.low;
  report.most_depth_mm = label.depth_mm;
  report.least_depth_mm = label.depth_mm - report.unevenness_mm;
  if (report.least_depth_mm < kLeastShare * label.depth_mm)
    return fail(labelError(fmt::format("a surface that varies by {:.2f} mm under a text of {:.1f} x {:.1f} mm",
                                       report.unevenness_mm, report.width_mm, report.height_mm),
                           fmt::format("at most {:.2f} mm, 40 % of the depth", (1 - kLeastShare) * label.depth_mm),
                           "a flatter place, a smaller or deeper text, or a bend radius"));

  LabelSpan out;
  if (label.embossed) {
    out.high = face.low + label.depth_mm;
    out.low = face.low - std::min(kBeyond, (face.low - face.back) / 2);
  } else {
    out.low = face.high - label.depth_mm;
    out.high = face.high + kBeyond;
    const double wall = out.low - face.back;
    if (wall < kLabelDeep - label.depth_mm) report.wall_mm = wall;
    if (wall < label.least_wall_mm)
      return fail(labelError(
          wall > 0 ? fmt::format("a wall of {:.2f} mm left behind letters {} mm deep", wall, label.depth_mm)
                   : fmt::format("letters {} mm deep that break through a wall of {:.2f} mm", label.depth_mm,
                                 wall + label.depth_mm),
          fmt::format("at least {} mm", label.least_wall_mm), "a shallower or embossed label, or another place"));
  }
  if (face.front < out.high + kRoom)
    return fail(labelError(fmt::format("another surface {:.2f} mm in front of the face", face.front - face.low),
                           fmt::format("{:.2f} mm of room", out.high + kRoom - face.low), "another place"));
  return out;
}

}  // namespace kerf::internal
