// Memberships: share of each slot in a Gaussian around a node, stored only in bricks where several slots meet.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/base/progress.h"
#include "geometry/base/types.h"
#include "geometry/field/brick_field.h"
#include "preprocess/volume/slot_grid.h"

namespace kerf::internal {

/// One blur kernel per axis: 2 reach + 1 weights that sum to 1.
struct Kernel {
  int reach = 1;
  std::vector<float> weight;
};
/// @param sigma  standard deviation, voxels, >= 0. Reaches three of them.
Kernel gaussian(double sigma);

/// Place number `b` of a box of bricks, the last axis varies fastest; and back.
inline Vec3i brickPlace(std::size_t b, const Vec3i& bricks) {
  const auto y = static_cast<std::size_t>(bricks[1]), z = static_cast<std::size_t>(bricks[2]);
  return {static_cast<int>(b / z / y), static_cast<int>(b / z % y), static_cast<int>(b % z)};
}
inline std::size_t brickNumber(const Vec3i& b, const Vec3i& bricks) {
  return (static_cast<std::size_t>(b[0]) * static_cast<std::size_t>(bricks[1]) + static_cast<std::size_t>(b[1])) *
             static_cast<std::size_t>(bricks[2]) +
         static_cast<std::size_t>(b[2]);
}

/// The memberships of all nodes of a slot grid. After fitVolumes() a node belongs to the slot with the largest
/// membership times weight.
struct Memberships {
  struct Brick {
    std::vector<Slot> slots;   ///< slots with membership in the brick, rising
    std::vector<float> value;  ///< kBrickNodes per slot, order of nodeOffset()
  };

  Vec3i bricks = Vec3i::Zero();
  std::vector<std::int32_t> index;  ///< per brick place: into `mixed`, or -1 - slot where one slot fills the brick
  std::vector<Brick> mixed;
  std::vector<Vec3i> place;   ///< places of the mixed bricks
  std::vector<float> weight;  ///< per slot, 1 for the rest

  std::size_t slots() const { return weight.size(); }
  /// Entry of `index` at a brick place; beyond the grid the rest.
  std::int32_t find(const Vec3i& b) const {
    if ((b.array() < 0).any() || (b.array() >= bricks.array()).any()) return -1;
    return index[brickNumber(b, bricks)];
  }
  /// Largest membership of the slots other than `own`, minus that of `own`.
  float leadOfOthers(const Vec3i& node, Slot own) const;
  /// Slot with the largest weighted membership in a mixed brick's node.
  Slot winner(const Brick& brick, std::size_t node) const;
};

/// The blurred indicators of all slots, with weights of 1. Parallel; does not depend on the number of threads.
Memberships blurSlots(const SlotGrid& grid, std::size_t slots, const std::array<Kernel, 3>& kernel);

/// Lifts memberships such that every voxel keeps its label at its centre, and one-voxel walls and canals keep most of
/// their thickness.
void keepThin(const SlotGrid& grid, Memberships& memberships);

/// Samples per cell between eight nodes, in which volumes are counted.
inline constexpr int kSubSamples = 3;  // per axis
inline constexpr std::uint64_t kCellSamples = kSubSamples * kSubSamples * kSubSamples;

/// Fits weights such that every slot keeps the volume of its voxels. Stops within `tolerance` of each, or after 12
/// rounds.
/// @param sigma    voxels, the smallest of the axes.   @param voxels  per slot.
/// @param samples  out: volume per slot at the end, in samples.
/// @return false if cancelled.
bool fitVolumes(Memberships& memberships, double sigma, const std::vector<std::uint64_t>& voxels, double tolerance,
                const Progress& progress, std::vector<std::uint64_t>& samples);

}  // namespace kerf::internal
