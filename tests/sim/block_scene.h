// A block of tissue at any attitude, and a bur of plain geometry: scenes with known answers.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "geometry/sample_field.h"
#include "sim/step.h"

namespace kerf::test {

/// Samples a distance as a case would be baked: 3 voxels outside, max(4 voxels, 0.2 mm) inside.
inline std::shared_ptr<const BakedObject> bakedFrom(const std::function<double(const Vec3d&)>& distance,
                                                    const Box3& box, double voxel,
                                                    Material material = Material::kDentin) {
  const double inside = std::max(4 * voxel, 0.2), outside = 3 * voxel;
  const BrickField sampled = sampleDistance(distance, box, voxel, inside / voxel);
  BrickField field(voxel, static_cast<float>(outside), static_cast<float>(-inside));
  for (std::size_t b = 0; b < sampled.brickCount(); ++b) {
    BrickValues v = sampled.brick(b);
    for (float& x : v) x = std::clamp(x, static_cast<float>(-inside), static_cast<float>(outside));
    field.add(sampled.brickCoord(b), v);
  }
  for (const Vec3i& c : sampled.interiorBricks()) field.markInterior(c);
  auto baked = BakedObject::make(std::move(field), nullptr, material);
  EXPECT_TRUE(baked) << baked.error().message();
  return *baked;
}

/// A block with its top at z = 0 of its own frame, which `attitude` turns and moves.
inline std::shared_ptr<const BakedObject> block(const Vec3d& size, double voxel, const Rigid3& attitude = {},
                                                Material material = Material::kDentin) {
  Box3 box;
  box.add(Vec3d(-size[0] / 2, -size[1] / 2, -size[2])), box.add(Vec3d(size[0] / 2, size[1] / 2, 0));
  const BoxShape shape(box);
  const Rigid3 inverse = attitude.inverse();
  Box3 turned;
  for (int c = 0; c < 8; ++c)
    turned.add(attitude *
               Vec3d((c & 1 ? box.max : box.min)[0], (c & 2 ? box.max : box.min)[1], (c & 4 ? box.max : box.min)[2]));
  return bakedFrom([&](const Vec3d& p) { return shape.distance(inverse * p); }, turned, voxel, material);
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
