#include "bench/scenes/practice_block.h"

#include <algorithm>

#include "geometry/field/sample_field.h"
#include "geometry/tool/tool_shape.h"

namespace kerf {

Expected<std::shared_ptr<const BakedObject>> bakedFrom(const std::function<double(const Vec3d&)>& distance,
                                                       const Box3& box, double voxel, Material material) {
  const double inside = std::max(4 * voxel, 0.2), outside = 3 * voxel;
  const BrickField sampled = sampleDistance(distance, box, voxel, inside / voxel);
  BrickField field(voxel, static_cast<float>(outside), static_cast<float>(-inside));
  for (std::size_t b = 0; b < sampled.brickCount(); ++b) {
    BrickValues v = sampled.brick(b);
    for (float& x : v) x = std::clamp(x, static_cast<float>(-inside), static_cast<float>(outside));
    field.add(sampled.brickCoord(b), v);
  }
  for (const Vec3i& c : sampled.interiorBricks()) field.markInterior(c);
  return BakedObject::make(std::move(field), nullptr, material);
}

Expected<std::shared_ptr<const BakedObject>> practiceBlock(const Vec3d& size, double voxel, const Rigid3& attitude,
                                                           Material material) {
  Box3 box;
  box.add(Vec3d(-size[0] / 2, -size[1] / 2, -size[2]));
  box.add(Vec3d(size[0] / 2, size[1] / 2, 0));
  const BoxShape shape(box);
  const Rigid3 inverse = attitude.inverse();
  Box3 turned;
  for (int c = 0; c < 8; ++c)
    turned.add(attitude *
               Vec3d((c & 1 ? box.max : box.min)[0], (c & 2 ? box.max : box.min)[1], (c & 4 ? box.max : box.min)[2]));
  return bakedFrom([&](const Vec3d& p) { return shape.distance(inverse * p); }, turned, voxel, material);
}

ToolModel practiceBall(double radius, double speed) {
  Tool tool;
  tool.id = "ball";
  tool.head_diameter_mm = tool.head_length_mm = 2 * radius;
  RevolvedProfile profile;
  profile.arcTo({0, radius}, {0, 2 * radius});
  tool.head = tool.cutting = std::make_shared<const RevolvedProfile>(profile);
  tool.cut = std::make_shared<const RevolvedShape>(profile);
  ToolModel model = makeToolModel(tool);
  model.motion = ToolMotion::kStroke;
  model.drive = {speed, 0, 0, 1, 1};
  return model;
}

}  // namespace kerf
