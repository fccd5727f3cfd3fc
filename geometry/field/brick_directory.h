// Looks up a brick's number by coordinate, without a search: a box of bricks with one number each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "geometry/base/types.h"

namespace kerf {

/// A number for each brick of a box [low, low + size), z fastest. Reading is safe from many threads, and so is setting
/// the numbers of different bricks. Only the constructor allocates.
class BrickDirectory {
 public:
  static constexpr std::int32_t kNone = -1;

  BrickDirectory() = default;
  /// Every brick has kNone. Takes 4 bytes a brick of the box.
  /// @param memory  buffer to reuse, such as one reserved in large pages.
  BrickDirectory(const Vec3i& low, const Vec3i& size, std::vector<std::int32_t> memory = {})
      : low_(low), size_(size), numbers_(std::move(memory)) {
    numbers_.assign(static_cast<std::size_t>(size.cast<std::ptrdiff_t>().prod()), kNone);
  }

  const Vec3i& low() const noexcept { return low_; }
  const Vec3i& size() const noexcept { return size_; }
  /// Bricks of the box.
  std::size_t cellCount() const noexcept { return numbers_.size(); }

  bool contains(const Vec3i& brick) const noexcept {
    const Vec3i at = brick - low_;
    return (at.array() >= 0).all() && (at.array() < size_.array()).all();
  }
  /// @pre contains(brick).
  std::size_t indexOf(const Vec3i& brick) const noexcept {
    const Vec3i at = brick - low_;
    return static_cast<std::size_t>((at[0] * size_[1] + at[1]) * size_[2] + at[2]);
  }
  /// From the index of a brick to that of its neighbour; @param face  0 to 5: -x, +x, -y, +y, -z, +z. @pre the box
  /// contains both.
  std::size_t indexBeside(std::size_t index, int face) const noexcept {
    const int axis = face / 2;
    const std::ptrdiff_t step = axis == 0 ? size_[1] * size_[2] : axis == 1 ? size_[2] : 1;
    return index + static_cast<std::size_t>(face & 1 ? step : -step);
  }

  std::int32_t at(std::size_t index) const noexcept { return numbers_[index]; }
  void set(std::size_t index, std::int32_t number) noexcept { numbers_[index] = number; }
  /// The number of a brick; kNone outside the box.
  std::int32_t find(const Vec3i& brick) const noexcept { return contains(brick) ? at(indexOf(brick)) : kNone; }

  /// Calls visit(number) for the bricks from low to high that have one, in order of their coordinate.
  template <class Visit>
  void forEachIn(Vec3i low, Vec3i high, const Visit& visit) const noexcept {
    low = (low - low_).cwiseMax(0);
    high = (high - low_).cwiseMin(size_ - Vec3i::Ones());
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y) {
        const std::int32_t* const row = numbers_.data() + (x * size_[1] + y) * size_[2];
        for (int z = low[2]; z <= high[2]; ++z)
          if (row[z] >= 0) visit(row[z]);
      }
  }

  /// Calls visit(number, step) for a brick and the 26 around it, those that have a number; step is -1, 0 or 1 an axis.
  template <class Visit>
  void forEachAround(const Vec3i& brick, const Visit& visit) const {
    const Vec3i at = brick - low_;
    const Vec3i low = (-at).cwiseMax(-1), high = (size_ - Vec3i::Ones() - at).cwiseMin(1);
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y) {
        const std::int32_t* const row = numbers_.data() + ((at[0] + x) * size_[1] + at[1] + y) * size_[2] + at[2];
        for (int z = low[2]; z <= high[2]; ++z)
          if (row[z] >= 0) visit(row[z], Vec3i(x, y, z));
      }
  }

 private:
  Vec3i low_ = Vec3i::Zero(), size_ = Vec3i::Zero();
  std::vector<std::int32_t> numbers_;
};

}  // namespace kerf
