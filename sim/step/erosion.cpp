#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "sim/step/brick_to_tool.h"
#include "sim/step/contact.h"
#include "sim/step/erosion_rates.h"
#include "sim/step/node_kernels.h"

namespace kerf {
namespace {

// Erodes single bricks of one object.
class BrickErosion {
 public:
  BrickErosion(const CutObject& object, const ContactInput& in)
      : cut_(in.tool->cut),
        tip_(in.T_object_tool.translation),
        to_tool_(in.T_object_tool.rotation.toRotationMatrix().transpose()),
        h_(object.voxel()),
        rates_(in) {
    brick_.x = x_;
    brick_.y = y_;
    brick_.z = z_;
    brick_.tau = tau_;
    brick_.lever = internal::leverOf(*in.tool);
    brick_.lips = internal::lipsOf(in);
    brick_.geometry_only = in.geometry_only;
    // Air stays air: values rise to the end of the band baked around the surface, and no further.
    brick_.cap = object.baked().phi0().background();
    brick_.least_overlap = in.tool->cut.leastOverlap();
    std::fill_n(tau_, kBrickNodes, ToolField::kFar);
  }

  // @param next  512 values: the brick after erosion.
  internal::ErodeBrickResult run(const CutObject::Slot& slot, float* next) {
    const internal::BrickToTool map(to_tool_, tip_, slot.brick, h_);
    internal::placeNodes(map.base, map.along, x_, y_, z_);
    lookUpRows(internal::rowsBelow(slot.phi, brick_.cap));

    brick_.phi = slot.phi;
    brick_.rate = rates_.value[slot.materials[0]];
    brick_.rates = nullptr;
    if (!slot.has_one_material) {
      internal::valuesOf(rates_.value.data(), slot.materials, kBrickNodes, rate_);
      brick_.rates = rate_;
    }
    if (brick_.lips.height > 0) setLipRates(slot);
    return internal::erodeBrick(brick_, next);
  }

 private:
  // The tool's distances at the nodes of these rows. Skips air, where nothing is cut.
  void lookUpRows(std::uint64_t rows) {
    for (int end = 0; end < kRows && rows >> end != 0;) {
      const int begin = end + std::countr_zero(rows >> end);
      end = begin + std::countr_one(rows >> begin);
      const int at = kRow * begin;
      cut_.distances(x_ + at, y_ + at, z_ + at, tau_ + at, kRow * (end - begin));
    }
  }

  void setLipRates(const CutObject::Slot& slot) {
    brick_.lip_rate = rates_.at_lips[slot.materials[0]];
    brick_.lip_rates = nullptr;
    if (slot.has_one_material) return;
    internal::valuesOf(rates_.at_lips.data(), slot.materials, kBrickNodes, lip_rate_);
    brick_.lip_rates = lip_rate_;
  }

  static constexpr int kRow = kBrickSide, kRows = kBrickNodes / kRow;

  const ToolField& cut_;
  const Vec3d tip_;
  const Eigen::Matrix3d to_tool_;
  const double h_;
  const internal::ErosionRates rates_;
  float x_[kBrickNodes], y_[kBrickNodes], z_[kBrickNodes], tau_[kBrickNodes], rate_[kBrickNodes],
      lip_rate_[kBrickNodes];
  internal::ErodeBrickInput brick_;
};

}  // namespace

CutResult erode(CutObject& object, const NearBricks& near, const ContactInput& in) noexcept {
  CutResult result;
  const ToolField& cut = in.tool->cut;
  if (object.isFrozen() || cut.isEmpty()) return result;
  if (!in.geometry_only && (in.speed == 0 || internal::onlyRubs(in))) return result;

  BrickErosion erosion(object, in);
  float next[kBrickNodes];
  for (std::size_t b = 0; b < near.size(); ++b) {
    const int s = near.slot(b);
    CutObject::Slot& slot = object.slot(s);
    if (object.odometer < slot.sleeps_until_cut || near.leastCut(b) >= -slot.least) continue;

    const internal::ErodeBrickResult eroded = erosion.run(slot, next);
    if (eroded.gap >= -cut.leastOverlap()) {
      slot.sleeps_until_cut = object.odometer + internal::staggered(static_cast<double>(eroded.gap) - cut.slack(), s);
      continue;
    }
    slot.sleeps_until_cut = -1;
    if (std::memcmp(next, slot.phi, sizeof next) == 0) continue;

    if (!object.carve(s, next, eroded.least, result.removed_mm3)) {
      result.pool_ran_out = true;
      break;
    }
    ++result.bricks;
  }
  return result;
}

}  // namespace kerf
