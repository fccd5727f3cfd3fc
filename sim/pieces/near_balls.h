// Distance of a brick's nodes to balls around nearby nodes, with the processor's vector instructions.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "geometry/field/brick_field.h"

namespace kerf::internal {

/// A ball around a node, counted from the brick's first node; -radius is its field value there.
struct NodeBall {
  int x, y, z;
  float phi;
};

/// Lengths of the steps from node to node, up to `reach` along each axis.
class NodeSteps {
 public:
  NodeSteps(int reach, float voxel);
  int reach() const { return reach_; }
  /// From a node at height z to the eight nodes of the row (dx, dy) away; infinite beyond reach along z.
  const float* row(int dx, int dy, int z) const {
    return lengths_.data() + ((dx + reach_) * side_ + dy + reach_) * width_ + reach_ + kBrickSide - 1 - z;
  }
  int width() const { return width_; }  ///< from a row to the row of dy + 1
  /// Largest |dy| of the rows within reach.
  int widest(int dx) const { return widest_[static_cast<std::size_t>(dx < 0 ? -dx : dx)]; }

 private:
  int reach_, side_, width_;
  std::array<int, kBrickSide + 1> widest_{};
  std::vector<float> lengths_;
};

/// distance = min(distance, |node - ball's| + phi), for the rows of nodes within reach of each ball. The same bits with
/// any instruction set. @cost about 2 ns a row: 30 ns a ball.
void nearBalls(std::span<const NodeBall> balls, const NodeSteps& steps, BrickValues& distance);

}  // namespace kerf::internal
