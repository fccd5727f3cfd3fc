#include <algorithm>

#include "sim/step/brick_to_tool.h"
#include "sim/step/contact.h"

namespace kerf {
namespace {

constexpr int kBlock = 4;  // bricks along a side of a block

// The awake bricks of one block, and the tool's distances at their centres.
struct BlockOfBricks {
  static constexpr int kMost = kBlock * kBlock * kBlock;
  int count = 0;
  int slots[kMost];
  float x[kMost], y[kMost], z[kMost];  // centres, tool frame, mm
  float cut[kMost], body[kMost];       // distances there, mm

  void gather(const CutObject& object, const Vec3i& begin, const Vec3i& last, const Eigen::Matrix3d& to_tool,
              const Vec3d& tip) {
    count = 0;
    object.bricks().forEachIn(begin, (begin + Vec3i::Constant(kBlock - 1)).cwiseMin(last), [&](int s) {
      const CutObject::Slot& slot = object.slot(s);
      if (object.odometer < slot.sleeps_until_cut &&
          (slot.shell_count == 0 || object.odometer < slot.sleeps_until_contact))
        return;
      const Vec3f q = (to_tool * (internal::centerOf(slot.brick, kBrickSide, object.voxel()) - tip)).cast<float>();
      x[count] = q[0];
      y[count] = q[1];
      z[count] = q[2];
      slots[count++] = s;
    });
  }

  void measure(const ToolModel& tool) {
    const int padded = (count + 7) / 8 * 8;
    for (int n = count; n < padded; ++n) x[n] = y[n] = z[n] = 0;
    tool.cut.distances(x, y, z, cut, padded);
    tool.body.distances(x, y, z, body, padded);
  }
};

Box3 boundsOf(const ToolModel& tool, const Rigid3& T_object_tool) {
  Box3 box;
  for (const ToolField* field : {&tool.cut, &tool.body})
    if (!field->isEmpty()) box.add(field->bounds().transformed(T_object_tool));
  return box;
}

}  // namespace

NearBricks::NearBricks(std::size_t capacity) : slots_(capacity), cut_(capacity), body_(capacity) {}

bool NearBricks::find(const CutObject& object, const ToolModel& tool, const Rigid3& T) noexcept {
  count_ = 0;
  const double h = object.voxel();
  const double band = std::max(-static_cast<double>(object.baked().phi0().interior()), kShellHalfWidth * h);
  const double slack = std::max(tool.cut.slack(), tool.body.slack());
  const double brick_radius = internal::radiusOf(kBrickSide, h) + slack;
  const double block_radius = internal::radiusOf(kBrickSide * kBlock, h) + slack;

  Box3 box = boundsOf(tool, T);
  if (box.isEmpty()) return true;
  box.grow(band);
  const Vec3i first = object.baked().directoryLow();
  const Vec3i last = first + object.baked().directorySize() - Vec3i::Ones();
  const Vec3i low = internal::brickAround(box.min, h, first, last).cwiseMax(first);
  const Vec3i high = internal::brickAround(box.max, h, first, last).cwiseMin(last);

  const Eigen::Matrix3d to_tool = T.rotation.toRotationMatrix().transpose();
  bool fits = true;
  BlockOfBricks block;
  for (int x = low[0]; x <= high[0]; x += kBlock)
    for (int y = low[1]; y <= high[1]; y += kBlock)
      for (int z = low[2]; z <= high[2]; z += kBlock) {
        const Vec3i begin(x, y, z);
        const Vec3d middle = internal::centerOf(begin, kBrickSide * kBlock, h);
        const Vec3f p = (to_tool * (middle - T.translation)).cast<float>();
        const double nearest = static_cast<double>(std::min(tool.cut.distance(p), tool.body.distance(p)));
        if (nearest - block_radius >= band) continue;

        block.gather(object, begin, high, to_tool, T.translation);
        block.measure(tool);
        for (int n = 0; n < block.count; ++n) {
          const float least_cut = block.cut[n] - static_cast<float>(brick_radius);
          const float least_body = block.body[n] - static_cast<float>(brick_radius);
          if (std::min(least_cut, least_body) >= -object.slot(block.slots[n]).least) continue;
          if (count_ == slots_.size()) {
            fits = false;
            break;
          }
          slots_[count_] = block.slots[n];
          cut_[count_] = least_cut;
          body_[count_] = least_body;
          ++count_;
        }
      }
  return fits;
}

}  // namespace kerf
