// The loop of erosion: one brick's values towards the tool, in whatever vector instructions the processor has.
#pragma once

#include <cstdint>

#include "geometry/field/brick_field.h"

namespace kerf::internal {

enum class LeverForm : int { kRadius, kPivot, kOne };

struct RelaxInput {
  const float *x, *y, *z;  ///< 512 nodes in the tool's frame, mm
  const float *tau, *phi;  ///< mm
  const float* rates;      ///< 512 of them, c dt over the lever; null: `rate` for all
  float rate = 0;
  LeverForm lever = LeverForm::kOne;
  float least_radius = 0;  ///< kRadius: mm, what a radius counts as at least
  float pivot = 0;         ///< kPivot: height, mm
  float cap = 0;           ///< mm: nothing is raised beyond it; what stands there already is left alone
  bool geometry_only = false;
};

struct RelaxResult {
  float gap;    ///< least tau + phi before, of the nodes below the cap
  float least;  ///< least value after
};

/// out = min(cap, phi + max(0, -tau - phi) (1 - exp(-rate lever))); geometry only: min(cap, max(phi, -tau)). The same
/// bits with any instruction set.
RelaxResult relaxBrick(const RelaxInput& in, float* out) noexcept;

/// Nodes of a brick in the tool's frame: base + i along[0] + j along[1] + k along[2], float32. @param out  3 x 512.
void placeNodes(const float base[3], const float along[3][3], float* x, float* y, float* z) noexcept;

/// The same for the nodes of a shell's chunk, given by their offsets; count a multiple of 8.
void placeShell(const float base[3], const float along[3][3], const std::uint16_t* offsets, int count, float* x,
                float* y, float* z) noexcept;
/// values[offsets[n]], count a multiple of 8.
void valuesAt(const float* values, const std::uint16_t* offsets, int count, float* out) noexcept;

/// Largest of n numbers, n a multiple of 8.
float largestOf(const float* values, int n) noexcept;

/// Which of `count` <= 64 nodes touch a tool: bits of those with min(cut, body) + phi < 0. `least_gap` becomes the
/// least of these sums, if that is less. All are read up to the next multiple of 8.
/// @param body  null: none near.
std::uint64_t touchingNodes(const float* cut, const float* body, const float* phi, int count,
                            float& least_gap) noexcept;

}  // namespace kerf::internal
