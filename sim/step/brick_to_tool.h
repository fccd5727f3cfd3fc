// Places of an object's bricks and nodes, in the tool's frame and relative to a point of the object.
#pragma once

#include <cmath>
#include <cstdint>

#include "geometry/base/types.h"
#include "geometry/field/brick_field.h"

namespace kerf::internal {

/// From a node's place in its brick to the tool's frame: p = base + i * along[0] + j * along[1] + k * along[2].
struct BrickToTool {
  float along[3][3];  ///< [axis of the brick][coordinate of the tool]
  float base[3];

  BrickToTool(const Eigen::Matrix3d& object_to_tool, const Vec3d& tip, const Vec3i& brick, double h) {
    const Vec3d b = object_to_tool * (h * 8 * brick.cast<double>() - tip);
    for (int c = 0; c < 3; ++c) {
      base[c] = static_cast<float>(b[c]);
      for (int axis = 0; axis < 3; ++axis) along[axis][c] = static_cast<float>(h * object_to_tool(c, axis));
    }
  }
};

/// Centre of a cube of nodes, `nodes` along its side, that begins with the first node of a brick; object frame, mm.
inline Vec3d centerOf(const Vec3i& brick, int nodes, double h) {
  return h * (8 * brick.cast<double>() + Vec3d::Constant(0.5 * (nodes - 1)));
}
/// From that centre to the farthest node, mm.
inline double radiusOf(int nodes, double h) { return 0.5 * std::sqrt(3.0) * (nodes - 1) * h; }

/// Between half and all of a clearance, different for each brick: bricks that fell asleep in one tick do not all wake
/// in one tick.
inline double staggered(double clearance, int slot) {
  const std::uint32_t scattered = static_cast<std::uint32_t>(slot) * 2654435769u;  // over the golden ratio
  return clearance * (0.5 + 0x1p-33 * scattered);
}

/// The brick around a point of the object's frame; at most one brick outside of first..last. Clamped before conversion
/// to an integer, because a tool may be anywhere.
inline Vec3i brickAround(const Vec3d& p, double h, const Vec3i& first, const Vec3i& last) {
  const Vec3d brick = (p / (8 * h)).array().floor();
  return brick.cwiseMax((first - Vec3i::Ones()).cast<double>())
      .cwiseMin((last + Vec3i::Ones()).cast<double>())
      .cast<int>();
}

}  // namespace kerf::internal
