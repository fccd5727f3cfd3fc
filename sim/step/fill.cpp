#include <algorithm>

#include "sim/step/brick_to_tool.h"
#include "sim/step/contact.h"
#include "sim/step/node_kernels.h"

namespace kerf {
namespace {

// Adds the cutting part of a tool to an object, brick by brick.
class Filling {
 public:
  Filling(CutObject& object, const ContactInput& in, Material material)
      : object_(object),
        tool_(in.tool->cut),
        T_object_tool_(in.T_object_tool),
        to_tool_(in.T_object_tool.rotation.toRotationMatrix().transpose()),
        number_(static_cast<std::uint8_t>(material)),
        h_(object.voxel()),
        half_width_(kShellHalfWidth * h_),
        brick_radius_(internal::radiusOf(kBrickSide, h_) + tool_.slack()),
        background_(object.baked().phi0().background()),
        interior_(object.baked().phi0().interior()),
        // The outermost layer of the directory stays air.
        first_(object.baked().directoryLow() + Vec3i::Ones()),
        last_(object.baked().directoryLow() + object.baked().directorySize() - Vec3i::Constant(2)) {}

  FillResult run() {
    Box3 box = tool_.bounds().transformed(T_object_tool_);
    box.grow(static_cast<double>(background_));
    const Vec3i low = internal::brickAround(box.min, h_, first_, last_);
    const Vec3i high = internal::brickAround(box.max, h_, first_, last_);
    for (int i = low[0]; i <= high[0]; ++i)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int k = low[2]; k <= high[2]; ++k) fillBrick({i, j, k});
    return result_;
  }

 private:
  void fillBrick(const Vec3i& brick) {
    const Vec3d middle = internal::centerOf(brick, kBrickSide, h_);
    const Vec3f q = (to_tool_ * (middle - T_object_tool_.translation)).cast<float>();
    const double least = static_cast<double>(tool_.distance(q)) - brick_radius_;
    if (least >= static_cast<double>(background_)) return;
    if ((brick.array() < first_.array()).any() || (brick.array() > last_.array()).any()) {
      result_.is_clipped |= least < 0;
      return;
    }

    int s = object_.find(brick);
    if (!unite(brick, s < 0 ? object_.baked().outsideBrick() : object_.slot(s).phi)) return;
    if (s < 0) s = object_.addAir(brick);
    if (s < 0) {
      result_.is_clipped = true;
      return;
    }
    store(s);
  }

  // next = min(phi, tau). False: nothing changes.
  bool unite(const Vec3i& brick, const float* phi) {
    float x[kBrickNodes], y[kBrickNodes], z[kBrickNodes], tau[kBrickNodes];
    const internal::BrickToTool map(to_tool_, T_object_tool_.translation, brick, h_);
    internal::placeNodes(map.base, map.along, x, y, z);
    tool_.distances(x, y, z, tau, kBrickNodes);
    bool changes = false;
    for (int n = 0; n < kBrickNodes; ++n) {
      next_[n] = std::min(phi[n], std::max(tau[n], interior_));
      changes |= next_[n] != phi[n];
    }
    return changes;
  }

  // Nodes that were outside and are now near the added surface get the new material. Inside the object the material
  // stays.
  void store(int s) {
    const CutObject::Slot& slot = object_.slot(s);
    bool relabels = false;
    for (int n = 0; n < kBrickNodes; ++n) {
      const bool is_near = next_[n] != slot.phi[n] && static_cast<double>(next_[n]) < half_width_;
      const bool takes_number = slot.phi[n] >= 0 && is_near;
      numbers_[n] = takes_number ? number_ : slot.materials[n];
      relabels |= numbers_[n] != slot.materials[n];
    }

    if (!object_.fill(s, next_, relabels ? numbers_ : nullptr, result_.added_mm3)) {
      result_.pool_ran_out = true;
      return;
    }
    ++result_.bricks;
  }

  CutObject& object_;
  const ToolField& tool_;
  const Rigid3& T_object_tool_;
  const Eigen::Matrix3d to_tool_;
  const std::uint8_t number_;  // of the material
  const double h_, half_width_, brick_radius_;
  const float background_, interior_;
  const Vec3i first_, last_;  // bricks that may be filled
  float next_[kBrickNodes];
  std::uint8_t numbers_[kBrickNodes];
  FillResult result_;
};

}  // namespace

FillResult fill(CutObject& object, const ContactInput& in, Material material) noexcept {
  if (object.isFrozen() || in.tool->cut.isEmpty()) return {};
  return Filling(object, in, material).run();
}

}  // namespace kerf
