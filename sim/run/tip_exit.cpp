#include "sim/run/tip_exit.h"

#include <algorithm>
#include <cmath>

namespace kerf::internal {

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
  if (outward.dot(to_shank) < -kAhead * outward.norm()) place_ = tip;
}

}  // namespace kerf::internal
