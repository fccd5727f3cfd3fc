// The loop of erosion: moves one brick's values towards the tool, with the processor's vector instructions.
#pragma once

#include "geometry/field/brick_field.h"

namespace kerf::internal {

/// Factor of the surface speed at a node: distance from the axis, distance from the pivot, or one.
enum class LeverForm : int { kRadius, kPivot, kOne };

/// Surface speed is the drive's speed times this: see ToolDrive::speed.
struct Lever {
  LeverForm form = LeverForm::kOne;
  float least_radius = 0;  ///< kRadius: mm, lower limit of the radius
  float pivot = 0;         ///< kPivot: height, mm
};

/// The point of a drill: see DrillLips. For nodes below `height` the rate is over r^0.75, and rubbing reduces the
/// removal of a turn.
struct LipLever {
  float height = 0;  ///< mm in the tool's frame; 0: there are no lips
  float rub = 0;     ///< mm: removal lost to rubbing, along the normal
  float most = 0;    ///< mm: largest removal, along the normal
};

struct ErodeBrickInput {
  const float *x, *y, *z;        ///< 512 nodes in the tool's frame, mm
  const float *tau, *phi;        ///< mm
  const float* rates = nullptr;  ///< 512 of them, c dt over the lever; null: `rate` for all
  float rate = 0;
  const float* lip_rates = nullptr;  ///< as `rates`, for nodes at the lips
  float lip_rate = 0;                ///< as `rate`
  Lever lever;
  LipLever lips;
  float cap = 0;            ///< mm: no value is raised beyond it; higher values stay
  float least_overlap = 0;  ///< mm: smaller overlaps stay: see ToolField::leastOverlap()
  bool geometry_only = false;
};

struct ErodeBrickResult {
  float gap;    ///< least tau + phi before, of the nodes below the cap
  float least;  ///< least value after
};

/// out = min(cap, phi + max(0, -tau - phi) (1 - exp(-rate lever))); geometry only: min(cap, max(phi, -tau)). At the
/// lips: phi + min(most, max(0, -tau - phi - rub / x) (1 - exp(-x))), x = lip rate r^0.75. Overlaps up to
/// `least_overlap` stay, and so does phi at the cap and above, for any tau. The same bits with any instruction set.
ErodeBrickResult erodeBrick(const ErodeBrickInput& in, float* out) noexcept;

}  // namespace kerf::internal
