#include "ui/app/tool/tool_ghost.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

constexpr double kOut = 6;     // mm: greatest depth of cuts below the original surface
constexpr double kWide = 0.6;  // mm: least radius of the surface under a thin tool

Vec3d gradientOf(const BrickField& field, const Vec3d& p) {
  Vec3d out;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3d step = field.voxel() * Vec3d::Unit(axis);
    out[axis] = field.sample(p + step) - field.sample(p - step);
  }
  return out;
}

// Mean normal of the surface as loaded, at the point and on a ring of that radius around it.
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

Vec3d onOriginal(const BrickField& loaded, const Vec3d& point, const Vec3d& axis) {
  const Ray down{point + kOut * axis, -axis};
  const auto way = entry(loaded, down, 0, 2 * kOut);
  return way ? down.at(*way) : point;
}

std::optional<double> depthBelow(const BrickField& loaded, const Vec3d& point, const Vec3d& axis) {
  constexpr double kThickest = 60, kHighest = 12;  // mm
  if (loaded.sample(point) >= 0) {
    const auto way = entry(loaded, {point, -axis}, 0, kHighest);
    return way ? std::optional(-*way) : std::nullopt;
  }

  const double least = 0.25 * loaded.voxel();
  double inside = 0;
  while (inside < kThickest) {
    const double next = inside + std::max(-0.9 * loaded.sample(point + inside * axis), least);
    if (loaded.sample(point + next * axis) < 0) {
      inside = next;
      continue;
    }
    double outside = next;
    for (int n = 0; n < 24; ++n) {
      const double middle = 0.5 * (inside + outside);
      (loaded.sample(point + middle * axis) < 0 ? inside : outside) = middle;
    }
    return outside;
  }
  return {};
}

Plunge plungeOf(const Tool& tool) {
  Plunge out{tool.plunge_direction, 0, 0.5 * tool.head_diameter_mm};
  const Box3 box = tool.cut->bounds();
  for (int n = 0; n < 8; ++n) out.reach = std::max(out.reach, box.corner(n).dot(out.direction));
  if (out.reach > out.radius - 1e-6) out.radius = kWide;  // a disc cuts with its rim
  return out;
}

Eigen::Quaterniond attitudeAlong(const Plunge& plunge, const Vec3d& axis) {
  return Eigen::Quaterniond::FromTwoVectors(plunge.direction, -axis).normalized();
}

std::optional<ToolOverSurface> toolOver(const LiveScene& scene, const BrickField& loaded, const Ray& ray,
                                        const Plunge& plunge) {
  const auto hit = scene.hit(ray);
  if (!hit) return {};
  if (scene.find(hit->id)->isBeside()) return {};
  const Rigid3 pose = scene.find(hit->id)->pose();
  const Ray local = inFrame(pose, ray);
  const Vec3d point = local.at(hit->on_surface.way);

  // On the surface as loaded, so that the walls of a cut do not turn the tool.
  const auto way =
      entry(loaded, local, std::max(hit->on_surface.way - 2 * kOut, 0.0), hit->on_surface.way + loaded.voxel());
  const Vec3d normal =
      meanNormal(loaded, way ? local.at(*way) : point, std::max(plunge.radius, kWide), -local.direction);

  ToolOverSurface out;
  out.object = hit->id;
  out.T_world_object = pose;
  out.point = hit->on_surface.point;
  out.normal = pose.rotation * normal;
  out.T_world_tool = {attitudeAlong(plunge, out.normal), out.point + plunge.reach * out.normal};
  out.reach = plunge.reach;
  out.depth = std::max(normal.dot(onOriginal(loaded, point, normal) - point), 0.0);
  return out;
}

}  // namespace kerf
