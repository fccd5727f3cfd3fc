#include "ui/app/stroke.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

constexpr double kAbove = 0.3;      // mm over the surface as loaded, where a stroke starts
constexpr double kLongestLift = 8;  // mm
constexpr double kFar = 400;        // mm: a ray looks no farther
constexpr double kOut = 6;          // mm: cuts are no deeper than that below the surface as loaded
constexpr double kWide = 0.6;       // mm: a thin tool stands on no less of the surface

// From outside along the axis to the surface as loaded; without one there, the point itself.
Vec3d onLoaded(const BrickField& loaded, const Vec3d& point, const Vec3d& axis) {
  const Ray down{point + kOut * axis, -axis};
  const auto way = entry(loaded, down, 0, 2 * kOut);
  return way ? down.at(*way) : point;
}

Vec3d gradientOf(const BrickField& field, const Vec3d& p) {
  Vec3d out;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3d step = field.voxel() * Vec3d::Unit(axis);
    out[axis] = field.sample(p + step) - field.sample(p - step);
  }
  return out;
}

// Mean normal of the surface as loaded about a point of it: at the point, and on a ring of that radius about it.
Vec3d meanNormal(const BrickField& loaded, const Vec3d& point, double radius, const Vec3d& towards) {
  constexpr int kOnRing = 8;
  const Vec3d first = gradientOf(loaded, point);
  Vec3d sum = first.norm() > 1e-9 ? Vec3d(first.normalized()) : towards;
  const Vec3d axis = sum, across = axis.unitOrthogonal(), along = axis.cross(across);
  for (int n = 0; n < kOnRing; ++n) {
    const double angle = 2 * std::numbers::pi * n / kOnRing;
    const Vec3d beside = point + radius * (std::cos(angle) * across + std::sin(angle) * along);
    const auto way = entry(loaded, {beside + 2 * radius * axis, -axis}, 0, 4 * radius);
    if (!way) continue;
    const Vec3d normal = gradientOf(loaded, beside + (2 * radius - *way) * axis);
    if (normal.norm() > 1e-9) sum += normal.normalized();
  }
  return sum.norm() > 1e-3 ? Vec3d(sum.normalized()) : axis;
}

}  // namespace

Plunge plungeOf(const Tool& tool) {
  Plunge out{tool.plunge_direction, 0, 0.5 * tool.head_diameter_mm};
  const Box3 box = tool.cut->bounds();
  for (int n = 0; n < 8; ++n) out.reach = std::max(out.reach, box.corner(n).dot(out.direction));
  if (out.reach > out.radius - 1e-6) out.radius = kWide;  // it cuts with its rim, a disc
  return out;
}

Eigen::Quaterniond attitudeAlong(const Plunge& plunge, const Vec3d& axis) {
  return Eigen::Quaterniond::FromTwoVectors(plunge.direction, -axis).normalized();
}

std::optional<ToolOverSurface> toolOver(const LiveSurface& surface, const BrickField& loaded, const Ray& ray,
                                        const Plunge& plunge) {
  const auto hit = surface.hit(ray);
  if (!hit) return {};
  ToolOverSurface out;
  out.point = hit->point;
  // On the surface as loaded: the walls of a cut do not turn the tool.
  const auto way = entry(loaded, ray, std::max(hit->way - 2 * kOut, 0.0), hit->way + loaded.voxel());
  out.normal = meanNormal(loaded, way ? ray.at(*way) : hit->point, std::max(plunge.radius, kWide), -ray.direction);
  out.T_world_tool = {attitudeAlong(plunge, out.normal), out.point + plunge.reach * out.normal};
  out.depth = std::max(out.normal.dot(onLoaded(loaded, hit->point, out.normal) - hit->point), 0.0);
  return out;
}

Stroke::Stroke(const BrickField& loaded, const ToolOverSurface& at, const Plunge& plunge, const Mesh& head)
    : loaded_(loaded),
      anchor_(onLoaded(loaded, at.point, at.normal)),
      axis_(at.normal),
      reach_(plunge.reach),
      start_{at.T_world_tool.rotation, anchor_ + (kAbove + reach_) * axis_} {
  const auto isFree = [&] {
    return std::all_of(head.vertices.begin(), head.vertices.end(),
                       [&](const Vec3d& v) { return loaded_.sample(start_ * v) > 0; });
  };
  for (double lift = kAbove; lift < kLongestLift && !isFree(); lift += 0.1)
    start_.translation = anchor_ + (lift + reach_) * axis_;
}

Vec3d Stroke::pointerOf(const Ray& ray) const {
  if (const auto way = entry(loaded_, ray, 0, kFar)) return ray.at(*way);
  const double along = ray.direction.dot(axis_);
  if (std::abs(along) < 0.05) return anchor_;
  return ray.at(axis_.dot(anchor_ - ray.origin) / along);
}

double Stroke::depthOf(const Vec3d& tip) const {
  const Vec3d first = tip - reach_ * axis_;
  return axis_.dot(onLoaded(loaded_, first, axis_) - first);
}

}  // namespace kerf
