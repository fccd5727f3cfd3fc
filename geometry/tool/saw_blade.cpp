#include "geometry/tool/saw_blade.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kUnbounded = 60;      // mm: no section of a jaw is larger
constexpr double kOverlap = 0.8;       // of the span, from one pass to the next
constexpr double kShallower = 0.5;     // mm that a disc may cut less deep between two passes
constexpr double kMandrelClear = 0.5;  // mm from the mandrel of a disc to the bone

// How far an arc falls back beside its middle.
double sagOf(double radius, double aside) { return radius - std::sqrt(std::max(radius * radius - aside * aside, 0.0)); }

}  // namespace

std::optional<SawBlade> SawBlade::of(const Tool& tool) {
  if (tool.kind != ToolKind::kBlade || !tool.motion) return {};

  SawBlade out;
  const bool is_disc = tool.motion->form == ToolMotion::kSpin;
  out.plunge = tool.plunge_direction;
  out.normal = is_disc ? Vec3d(Vec3d::UnitZ()) : Vec3d(Vec3d::UnitY());
  out.edge = out.normal.cross(out.plunge);
  out.kerf = tool.kerfWidth();

  const Box3 box = tool.cut->bounds();
  const Vec3d half = 0.5 * box.size();
  out.front = box.center() + std::abs(half.dot(out.plunge)) * out.plunge;
  out.span = 2 * std::abs(half.dot(out.edge));
  out.most_width = out.most_depth = kUnbounded;

  switch (tool.motion->form) {
    case ToolMotion::kStroke:  // held at its end: one pass
      out.is_held_at_end = true;
      out.flat = out.step = out.most_width = out.span;
      break;
    case ToolMotion::kSwing:
      out.flat = out.span;
      out.step = kOverlap * out.span;
      out.sag = sagOf(tool.blade_length_mm, 0.5 * out.step);
      out.most_depth = tool.blade_length_mm;
      break;
    case ToolMotion::kSpin: {
      const double radius = 0.5 * tool.head_diameter_mm;
      const double mandrel = tool.body ? tool.body->bounds().max[0] : 0;
      const double sag = std::min(kShallower, 0.5 * radius);
      out.flat = out.step = 2 * std::sqrt(sag * (2 * radius - sag));
      out.sag = sag;
      out.most_depth = std::max(radius - mandrel - kMandrelClear, 0.1 * radius);
      break;
    }
  }
  return out;
}

Rigid3 SawBlade::poseAt(const Vec3d& front_at, const Vec3d& normal_wanted, const Vec3d& approach,
                        bool is_turned) const {
  const Vec3d up = is_turned ? Vec3d(-normal_wanted) : normal_wanted;
  Eigen::Matrix3d world, tool;
  world << approach, up, up.cross(approach);
  tool << plunge, normal, edge;

  Rigid3 out;
  out.rotation = Eigen::Quaterniond(Eigen::Matrix3d(world * tool.transpose())).normalized();
  out.translation = front_at - out.rotation * front;
  return out;
}

}  // namespace kerf
