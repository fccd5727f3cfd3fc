#include "sim/run/sweep/tip_exit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf::internal {
namespace {

// Whether material surrounds a point of air: rays along an even spiral of directions.
bool isInCavity(const BrickField& field, const Vec3d& p) {
  constexpr int kRays = 64;
  const Box3 box = field.bounds();
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int n = 0; n < kRays; ++n) {
    const double z = 1 - (2 * n + 1) / static_cast<double>(kRays), r = std::sqrt(1 - z * z);
    const Vec3d way(r * std::cos(n * turn), r * std::sin(n * turn), z);
    double s = field.voxel();
    while (box.contains(p + s * way) && field.sample(p + s * way) > 0)
      s += std::max(field.sample(p + s * way), 0.5 * field.voxel());
    if (!box.contains(p + s * way)) return false;
  }
  return true;
}

}  // namespace

void TipExit::moveTo(const Rigid3& T_object_tool) {
  if (place_) return;
  const Vec3d tip = T_object_tool.translation, from = last_.value_or(tip);
  const Vec3d to_shank = T_object_tool.rotation * Vec3d::UnitZ();
  last_ = tip;

  constexpr int kMostSteps = 100'000;
  const double steps = std::ceil((tip - from).norm() / (0.5 * loaded_.voxel()));
  const int count = static_cast<int>(std::clamp(steps, 1.0, static_cast<double>(kMostSteps)));
  for (int n = 1; n <= count && !place_; ++n) visit(from + n / static_cast<double>(count) * (tip - from), to_shank);
}

void TipExit::visit(const Vec3d& tip, const Vec3d& to_shank) {
  const double h = loaded_.voxel(), depth = -loaded_.sample(tip);
  if (depth >= h) is_deep_ = true;
  if (!is_deep_ || depth > 0) return;
  is_deep_ = false;

  Vec3d outward = Vec3d::Zero();
  for (int axis = 0; axis < 3; ++axis)
    outward[axis] = loaded_.sample(tip + h * Vec3d::Unit(axis)) - loaded_.sample(tip - h * Vec3d::Unit(axis));
  constexpr double kAhead = 0.5;  // cosine
  if (outward.dot(to_shank) < -kAhead * outward.norm() && !isInCavity(loaded_, tip)) place_ = tip;
}

}  // namespace kerf::internal
