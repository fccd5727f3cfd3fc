// The scenes of bench/scenes for tests. A scene that cannot be made fails the test.
#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "sim/step/step.h"

namespace kerf::test {

inline std::shared_ptr<const BakedObject> bakedFrom(const std::function<double(const Vec3d&)>& distance,
                                                    const Box3& box, double voxel) {
  auto baked = kerf::bakedFrom(distance, box, voxel);
  EXPECT_TRUE(baked) << baked.error().message();
  return *baked;
}
inline std::shared_ptr<const BakedObject> block(const Vec3d& size, double voxel, const Rigid3& attitude = {}) {
  auto baked = practiceBlock(size, voxel, attitude);
  EXPECT_TRUE(baked) << baked.error().message();
  return *baked;
}

using scenes::oneTissue;
using scenes::sampleAt;

}  // namespace kerf::test
