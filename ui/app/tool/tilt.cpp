#include "ui/app/tool/tilt.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

constexpr double kPerPixel = 0.5 * std::numbers::pi / 180;  // rad
constexpr double kOutline = 0.00005;                        // mm

}  // namespace

Tilt tiltInView(const Camera& camera, double angle, double azimuth) {
  const Vec3d towards = std::cos(azimuth) * camera.right() + std::sin(azimuth) * camera.up();
  return {std::clamp(angle, 0.0, Tilt::kMost), towards};
}

double azimuthInView(const Camera& camera, const Tilt& tilt) {
  const double right = tilt.towards.dot(camera.right()), up = tilt.towards.dot(camera.up());
  return std::hypot(right, up) > 1e-6 ? std::atan2(up, right) : 0;
}

Tilt tiltedBy(const Tilt& tilt, const Camera& camera, double dx, double dy) {
  const double azimuth = azimuthInView(camera, tilt);
  const double right = tilt.angle * std::cos(azimuth) + kPerPixel * dx;
  const double up = tilt.angle * std::sin(azimuth) - kPerPixel * dy;
  return tiltInView(camera, std::hypot(right, up), std::atan2(up, right));
}

Vec3d tiltedAxis(const Tilt& tilt, const Vec3d& normal) {
  const Vec3d across = tilt.towards - normal.dot(tilt.towards) * normal;
  const Vec3d aside = across.norm() > 1e-6 ? Vec3d(across.normalized()) : normal.unitOrthogonal();
  return std::cos(tilt.angle) * normal + std::sin(tilt.angle) * aside;
}

TouchPoints::TouchPoints(const Tool& tool) {
  if (tool.cutting) {
    outline_ = tool.cutting->polyline(kOutline);
    return;
  }
  const Box3 box = tool.cut->bounds();
  if (!tool.mesh) {
    for (int n = 0; n < 8; ++n) points_.push_back(box.corner(n));
    return;
  }
  for (const Vec3d& v : tool.mesh->vertices)
    if (v[2] <= box.max[2]) points_.push_back(v);
}

Vec3d TouchPoints::farthest(const Vec3d& direction, double up_to) const {
  Vec3d out = Vec3d::Zero();
  double most = -1e300;
  const auto take = [&](const Vec3d& p) {
    if (p[2] > up_to || p.dot(direction) <= most) return;
    most = p.dot(direction);
    out = p;
  };

  const Vec3d across(direction[0], direction[1], 0);
  const Vec3d radial = across.norm() > 1e-9 ? Vec3d(across.normalized()) : Vec3d(Vec3d::UnitX());
  for (const RevolvedProfile::Point& p : outline_) take(p[0] * radial + p[1] * Vec3d::UnitZ());
  for (const Vec3d& p : points_) take(p);
  return out;
}

namespace {

// Turns the tool about its contact point, from the normal to an axis.
void turnTool(ToolOverSurface& over, const Vec3d& axis, const TouchPoints& touch, double up_to) {
  const Vec3d& normal = over.normal;
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(normal, axis);
  const Eigen::Quaterniond attitude = (turn * over.T_world_tool.rotation).normalized();
  const Vec3d touches = attitude * touch.farthest(attitude.conjugate() * -normal, up_to);

  over.T_world_tool = {attitude, over.point - touches};
  over.reach = -normal.dot(touches);
  over.front = touches + over.reach * normal;
}

}  // namespace

void tiltTool(ToolOverSurface& over, const Tilt& tilt, const TouchPoints& touch) {
  if (tilt.isUpright()) return;
  const Vec3d axis = tiltedAxis(tilt, over.normal);
  turnTool(over, axis, touch, std::numeric_limits<double>::infinity());
  over.slant = over.normal - axis / over.normal.dot(axis);
}

bool holdTool(ToolOverSurface& over, const Vec3d& axis, const TouchPoints& touch) {
  constexpr double kAlong = 0.5, kMostUndercut = -0.574;  // cosines of 60 and 125 degrees
  constexpr double kEnd = 0.5;                            // mm of the tool's end that may touch a wall
  const double cosine = over.normal.dot(axis);
  if (cosine < kMostUndercut) return false;
  const bool is_wall = cosine < kAlong;
  turnTool(over, axis, touch, is_wall ? kEnd : std::numeric_limits<double>::infinity());
  if (!is_wall) over.slant = over.normal - axis / cosine;
  over.is_held = true;
  return true;
}

}  // namespace kerf
