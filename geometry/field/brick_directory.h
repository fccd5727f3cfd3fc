// Where the entry of a brick stands in a flat array that covers a box of bricks.
#pragma once

#include <array>
#include <cstddef>

#include "geometry/base/types.h"

namespace kerf {

/// The numbering of a box of bricks, z fastest. Holds no entries: the array, one entry for each of count() bricks,
/// belongs to the caller. @rt: all of it.
struct BrickDirectory {
  Vec3i low = Vec3i::Zero();   ///< coordinate of the first brick
  Vec3i size = Vec3i::Zero();  ///< bricks along x, y and z; their product fits into an int

  std::size_t count() const noexcept {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
  }
  bool contains(const Vec3i& brick) const noexcept {
    const Vec3i at = brick - low;
    return !((at.array() < 0).any() || (at.array() >= size.array()).any());
  }
  /// @pre contains(brick).
  std::size_t indexOf(const Vec3i& brick) const noexcept {
    const Vec3i at = brick - low;
    return static_cast<std::size_t>((at[0] * size[1] + at[1]) * size[2] + at[2]);
  }
  /// How far apart the entries of neighbours along x, y and z stand.
  std::array<int, 3> strides() const noexcept { return {size[1] * size[2], size[2], 1}; }
};

}  // namespace kerf
