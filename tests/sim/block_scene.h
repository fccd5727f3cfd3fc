// A block of tissue at any attitude, and a bur of plain geometry: scenes with known answers.
#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "sim/run/practice_block.h"
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

/// One tissue everywhere: stiffness N/mm^3, friction, specific energy N/mm^2.
inline TissueTable oneTissue(double stiffness, double friction, double energy) {
  TissueTable table;
  table.fill({static_cast<float>(stiffness), static_cast<float>(friction), static_cast<float>(1 / energy), true});
  return table;
}

inline DeviceSample sampleAt(const Rigid3& pose, double pedal = 1) {
  DeviceSample sample;
  sample.T_world_device = pose;
  sample.pedal = pedal;
  return sample;
}

}  // namespace kerf::test
