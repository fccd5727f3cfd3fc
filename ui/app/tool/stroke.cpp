#include "ui/app/tool/stroke.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kAbove = 0.3;      // mm over the original surface: start of a stroke
constexpr double kLongestLift = 8;  // mm
constexpr double kFar = 400;        // mm: reach of a ray

}  // namespace

Stroke::Stroke(const BrickField& loaded, const ToolOverSurface& at, const Mesh& head)
    : loaded_(loaded),
      T_world_object_(at.T_world_object),
      to_object_(at.T_world_object.inverse()),
      anchor_(T_world_object_ * onOriginal(loaded, to_object_ * at.point, to_object_.rotation * at.normal)),
      axis_(at.normal),
      reach_(at.reach),
      front_(at.front),
      slant_(at.slant),
      is_held_(at.is_held),
      start_{at.T_world_tool.rotation, anchor_ + (kAbove + reach_) * axis_ - front_} {
  const auto isFree = [&] {
    const Rigid3 tool = to_object_ * start_;
    return std::all_of(head.vertices.begin(), head.vertices.end(),
                       [&](const Vec3d& v) { return loaded_.sample(tool * v) > 0; });
  };
  for (double lift = kAbove; lift < kLongestLift && !isFree(); lift += 0.1)
    start_.translation = anchor_ + (lift + reach_) * axis_ - front_;
}

void Stroke::begin(MouseAim& aim) const {
  ++aim.stroke;
  aim.is_pressed = true;
  aim.anchor = aim.pointer = anchor_;
  aim.into = -axis_;
  aim.T_world_surface = T_world_object_;
  aim.reach = reach_;
  aim.front = front_;
  aim.slant = slant_;
  aim.is_attitude_held = is_held_;
}

Vec3d Stroke::pointerOf(const Ray& ray) const {
  const Ray local = inFrame(T_world_object_, ray);
  if (const auto way = entry(loaded_, local, 0, kFar)) return ray.at(*way);
  const double along = ray.direction.dot(axis_);
  if (std::abs(along) < 0.05) return anchor_;
  return ray.at(axis_.dot(anchor_ - ray.origin) / along);
}

double Stroke::depthOf(const Vec3d& tip) const {
  const Vec3d first = to_object_ * (tip + front_ - reach_ * axis_), axis = to_object_.rotation * axis_;
  return axis.dot(onOriginal(loaded_, first, axis) - first);
}

}  // namespace kerf
