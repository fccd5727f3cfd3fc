#include "bench/scenes/objects.h"

#include <algorithm>
#include <cmath>

#include "bench/scenes/practice_block.h"

namespace kerf::scenes {

TissueTable oneTissue(double stiffness, double friction, double energy) {
  TissueTable table;
  table.fill({static_cast<float>(stiffness), static_cast<float>(friction), static_cast<float>(1 / energy), true});
  return table;
}

double boxDistance(const Vec3d& p, const Vec3d& center, const Vec3d& half) {
  const Vec3d q = (p - center).cwiseAbs() - half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

Expected<std::shared_ptr<const BakedObject>> practiceSphere(const Vec3d& center, double radius, double voxel) {
  Box3 box;
  box.add(Vec3d(center.array() - radius - 0.1));
  box.add(Vec3d(center.array() + radius + 0.1));
  return bakedFrom([&](const Vec3d& p) { return (p - center).norm() - radius; }, box, voxel);
}

double topAt(const BrickField& phi, double x, double y, const Box3& box) {
  for (double z = box.max[2]; z > box.min[2]; z -= phi.voxel())
    if (phi.sample({x, y, z}) < 0) return z;
  return std::nan("");
}

BoneAcross boneAcross(const BrickField& phi, double y, double side) {
  const Box3 box = phi.bounds();
  BoneAcross bone;
  for (double x = 5; x < box.max[0]; x += 0.5) {
    const double z = topAt(phi, side * x, y, box);
    if (std::isnan(z)) continue;
    if (bone.from == 0) bone.from = x;
    bone.to = x;
    bone.top = std::max(bone.top, z);
  }
  return bone;
}

BrickField currentField(const CutObject& object) {
  BrickField field = object.baked().phi0();
  const BrickField changed = object.bricks().changedField();
  for (std::size_t b = 0; b < changed.brickCount(); ++b)
    field.brick(field.touch(changed.brickCoord(b))) = changed.brick(b);
  return field;
}

void appendEdit(std::vector<BrickEdit>& edits, const CutObject::Slot& slot) {
  BrickEdit& edit = edits.emplace_back();
  edit.brick = slot.brick;
  std::copy_n(slot.phi, kBrickNodes, edit.phi.begin());
}

void reserveForTicks(CutObject& object) {
  if (object.freeBricks() < 2048) object.reserve(4096);
}

}  // namespace kerf::scenes
