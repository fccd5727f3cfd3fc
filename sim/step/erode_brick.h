// The loop of erosion: moves one brick's values towards the tool, in whatever vector instructions the processor has.
#pragma once

#include "geometry/field/brick_field.h"

namespace kerf::internal {

/// What the surface speed at a node is proportional to: its distance from the axis, from the pivot, or nothing.
enum class LeverForm : int { kRadius, kPivot, kOne };

/// Surface speed is the drive's speed times this: see ToolDrive::speed.
struct Lever {
  LeverForm form = LeverForm::kOne;
  float least_radius = 0;  ///< kRadius: mm, what a radius counts as at least
  float pivot = 0;         ///< kPivot: height, mm
};

struct ErodeBrickInput {
  const float *x, *y, *z;  ///< 512 nodes in the tool's frame, mm
  const float *tau, *phi;  ///< mm
  const float* rates;      ///< 512 of them, c dt over the lever; null: `rate` for all
  float rate = 0;
  Lever lever;
  float cap = 0;  ///< mm: nothing is raised beyond it; what stands there already is left alone
  bool geometry_only = false;
};

struct ErodeBrickResult {
  float gap;    ///< least tau + phi before, of the nodes below the cap
  float least;  ///< least value after
};

/// out = min(cap, phi + max(0, -tau - phi) (1 - exp(-rate lever))); geometry only: min(cap, max(phi, -tau)). The same
/// bits with any instruction set.
ErodeBrickResult erodeBrick(const ErodeBrickInput& in, float* out) noexcept;

}  // namespace kerf::internal
