// Reads labels node by node and caches the last brick.
#pragma once

#include <cstdint>

#include "sim/live/tissue_colours.h"

namespace kerf {

/// One thread. Refers to the labels, which must outlive it.
class LabelReader {
 public:
  explicit LabelReader(const TissueLabels& labels) : labels_(labels) {}

  /// Material of a node, by its number on the labels' grid; 0: no label.
  std::uint8_t at(const Vec3i& node) {
    const Vec3i brick = brickOf(node);
    if (brick != brick_) {
      brick_ = brick;
      materials_ = labels_.brick(brick);
    }
    return materials_ ? materials_[nodeOffset(node[0], node[1], node[2])] : std::uint8_t{0};
  }

 private:
  const TissueLabels& labels_;
  Vec3i brick_ = Vec3i::Constant(1 << 30);
  const std::uint8_t* materials_ = nullptr;
};

}  // namespace kerf
