// A block of tissue at any attitude, and a bur of plain geometry: scenes with known answers.
#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "sim/practice_block.h"
#include "sim/step.h"

namespace kerf::test {

inline std::shared_ptr<const BakedObject> bakedFrom(const std::function<double(const Vec3d&)>& distance, const Box3& box,
                                                    double voxel) {
  auto baked = kerf::bakedFrom(distance, box, voxel);
  EXPECT_TRUE(baked) << baked.error().message();
  return *baked;
}
inline std::shared_ptr<const BakedObject> block(const Vec3d& size, double voxel, const Rigid3& attitude = {}) {
  auto baked = practiceBlock(size, voxel, attitude);
  EXPECT_TRUE(baked) << baked.error().message();
  return *baked;
}

/// A ball bur of radius r whose tip is at the origin; its surface moves at `speed` mm/s everywhere, like a stroke.
inline ToolModel uniformBall(double r, double speed) {
  Tool tool;
  tool.id = "ball";
  tool.head_diameter_mm = tool.head_length_mm = 2 * r;
  RevolvedProfile profile;
  profile.arcTo({0, r}, {0, 2 * r});
  tool.head = tool.cutting = std::make_shared<const RevolvedProfile>(profile);
  tool.cut = std::make_shared<const RevolvedShape>(profile);
  ToolModel model = makeToolModel(tool);
  model.motion = ToolMotion::kStroke;
  model.drive = {speed, 0, 0, 1};
  return model;
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
