// The labels of a volume as slots, small numbers: 0 is the rest, 1 + n the n-th requested tissue label.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/field/brick_field.h"
#include "preprocess/volume/label_volume.h"

namespace kerf::internal {

using Slot = std::uint8_t;
inline constexpr std::size_t kMostTissues = 250;
inline constexpr std::size_t kMostSlots = 256;  ///< range of a Slot

/// Number of voxels of each slot in a volume, and the box of the tissue slots.
struct SlotSurvey {
  std::vector<std::uint64_t> voxels;  ///< per slot; 0 for the rest, without a count
  Vec3i low, high;                    ///< first and last voxel along each axis
};
/// @param slot_of  per label, 65536 of them.   @param slots  number of slots, the rest included.
SlotSurvey surveySlots(const LabelVolume& volume, std::span<const Slot> slot_of, std::size_t slots);

/// The slots of all voxels in a box, a whole number of bricks along each axis; the last axis varies fastest.
struct SlotGrid {
  Vec3i bricks = Vec3i::Zero();
  Vec3i corner = Vec3i::Zero();  ///< node 0 in voxels of the volume
  std::vector<Slot> slot;

  Vec3i nodes() const { return bricks * kBrickSide; }
  std::size_t offset(int i, int j, int k) const {
    const Vec3i n = nodes();
    return (static_cast<std::size_t>(i) * static_cast<std::size_t>(n[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(n[2]) +
           static_cast<std::size_t>(k);
  }
  /// The slot of a node; the rest outside the grid.
  Slot at(int i, int j, int k) const {
    const Vec3i n = nodes();
    if (i < 0 || j < 0 || k < 0 || i >= n[0] || j >= n[1] || k >= n[2]) return 0;
    return slot[offset(i, j, k)];
  }
};

/// Fills a grid whose place and size are set. Nodes outside the volume are the rest. Parallel.
void fillSlots(const LabelVolume& volume, std::span<const Slot> slot_of, SlotGrid& grid);

/// Number of pieces of each slot, joined through faces; 0 for the rest.
std::vector<std::uint32_t> countPieces(const SlotGrid& grid, std::size_t slots);

}  // namespace kerf::internal
