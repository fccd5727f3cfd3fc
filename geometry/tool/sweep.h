// The solid a tool sweeps in one motion, by its distance: the minimum over the motion, not over samples of it.
#pragma once

#include "geometry/base/types.h"
#include "geometry/tool/tool_shape.h"

namespace kerf {

/// One motion of a tool: the tip moves on a straight line while the tool turns at constant speed about a fixed axis, by
/// the shorter way (at most half a turn). A view: the shape must outlive it. Reading is safe from any thread,
/// allocation-free.
class SweptTool {
 public:
  SweptTool(const ToolShape& shape, const Rigid3& T_object_tool_from, const Rigid3& T_object_tool_to);

  /// min over the motion of shape.distance, mm, at a point of the object's frame.
  /// Convex shapes: along the motion the distance is convex but for the turn's curvature, so parts of the motion are
  /// bracketed and every bracket gives a certified lower bound from the slopes beside it. Other shapes: Lipschitz
  /// branch and bound (Piyavskii 1972; Shubert 1972), as the shape is 1-Lipschitz; slow where it slides along itself.
  /// @param cutoff     anything at or above it may come back as any value at or above it.
  /// @param tolerance  > 0, mm: the result is at most this much above the true minimum.
  /// @param floor      once a value at or below it is found, it is returned.
  /// @cost one evaluation of the shape when the motion is short or far away; 3 to 20 near a convex one.
  double distance(const Vec3d& x_object, double cutoff, double tolerance,
                  double floor = -std::numeric_limits<double>::infinity()) const noexcept;

  /// False only if the swept distance is >= cutoff everywhere in the ball.
  bool mayReach(const Vec3d& center, double radius, double cutoff) const noexcept;

  /// Box around the swept solid, object frame.
  Box3 bounds() const;

 private:
  double at(const Vec3d& x, double s) const noexcept;
  double refineConvex(const Vec3d& x, double best, double curvature, double cutoff, double tolerance,
                      double floor) const noexcept;
  double refineLipschitz(const Vec3d& x, double best, double speed, double cutoff, double tolerance,
                         double floor) const noexcept;

  const ToolShape& shape_;
  bool is_convex_;
  Eigen::Matrix3d from_inverse_;  // object to tool at the start
  Vec3d start_, travel_, axis_;   // axis of the turn, object frame
  double angle_ = 0;              // rad, of the whole turn
  Rigid3 from_, to_;
};

}  // namespace kerf
