#include "sim/pieces/near_balls.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/pieces/near_balls.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void nearBallsHere(std::span<const NodeBall> balls, const NodeSteps& steps, BrickValues& distance) {
  const hn::CappedTag<float, 8> f;
  const int lanes = static_cast<int>(hn::Lanes(f)), reach = steps.reach();
  constexpr int kLast = kBrickSide - 1;
  const std::ptrdiff_t next_row = steps.width();
  for (const NodeBall& ball : balls) {
    const auto phi = hn::Set(f, ball.phi);
    const int last_x = std::min(kLast, ball.x + reach);
    for (int x = std::max(0, ball.x - reach); x <= last_x; ++x) {
      const int widest = steps.widest(x - ball.x), first = std::max(0, ball.y - widest);
      float* to = distance.data() + nodeOffset(x, first, 0);
      const float* step = steps.row(x - ball.x, first - ball.y, ball.z);
      for (int rows = std::min(kLast, ball.y + widest) - first; rows >= 0; --rows, to += kBrickSide, step += next_row)
        for (int z = 0; z < kBrickSide; z += lanes)
          hn::StoreU(hn::Min(hn::LoadU(f, to + z), hn::Add(hn::LoadU(f, step + z), phi)), f, to + z);
    }
  }
}

}  // namespace kerf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::internal {

HWY_EXPORT(nearBallsHere);

NodeSteps::NodeSteps(int reach, float voxel)
    : reach_(reach), side_(2 * reach + 1), width_(side_ + 2 * (kBrickSide - 1)) {
  lengths_.assign(static_cast<std::size_t>(side_ * side_ * width_), std::numeric_limits<float>::infinity());
  for (int x = -reach; x <= reach; ++x) {
    int& widest = widest_[static_cast<std::size_t>(std::abs(x))];
    while (x * x + (widest + 1) * (widest + 1) <= reach * reach) ++widest;
    for (int y = -reach; y <= reach; ++y)
      for (int z = -reach; z <= reach; ++z)
        lengths_[static_cast<std::size_t>(((x + reach) * side_ + y + reach) * width_ + z + reach + kBrickSide - 1)] =
            voxel * std::sqrt(static_cast<float>(x * x + y * y + z * z));
  }
}

void nearBalls(std::span<const NodeBall> balls, const NodeSteps& steps, BrickValues& distance) {
  HWY_DYNAMIC_DISPATCH(nearBallsHere)(balls, steps, distance);
}

}  // namespace kerf::internal
#endif
