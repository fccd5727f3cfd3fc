// Bricks written since the last stroke ended.
#pragma once

#include <cstdint>
#include <utility>

#include "sim/object/brick_version.h"

namespace kerf {

/// Numbers the strokes of an object, and lists the brick versions of the current one. SessionHistory keeps those of
/// ended strokes. All of it is O(1). @rt
class StrokeLog {
 public:
  /// Stroke number of the versions that a piece begins with.
  static constexpr std::uint64_t kBeforeAll = 0;

  /// Whether a brick was written since the last end().
  bool isOpen() const noexcept { return !written_.isEmpty(); }
  /// Number of the current stroke: 1 for the first.
  std::uint64_t number() const noexcept { return number_; }
  /// Whether a version (null: no) belongs to the current stroke and may be written into.
  bool isCurrent(const BrickVersion* version) const noexcept { return version && version->stroke == number_; }
  /// @pre its stroke is number().
  void add(BrickVersion* version) noexcept { written_.pushFront(version); }
  /// Ends the stroke. Returns the versions written since the last call.
  LinkedList<BrickVersion> end() noexcept {
    ++number_;
    return std::exchange(written_, {});
  }

 private:
  std::uint64_t number_ = 1;
  LinkedList<BrickVersion> written_;
};

}  // namespace kerf
