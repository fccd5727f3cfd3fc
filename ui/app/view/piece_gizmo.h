// Handles to move a piece with the mouse: three arrows, three rings, and a disc that moves it in the picture.
//
// No drawing: gives lines in pixels of the picture, and the effect of a drag.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "geometry/base/types.h"
#include "ui/app/view/camera.h"

namespace kerf {

using Pixel = Eigen::Vector2d;  ///< x to the right, y downwards

enum class GizmoHandle { kMoveX, kMoveY, kMoveZ, kTurnX, kTurnY, kTurnZ, kMoveInView };

class PieceGizmo {
 public:
  static constexpr double kArrow = 90, kRing = 60, kDisc = 9;  ///< pixels
  static constexpr double kReach = 8;                          ///< pixels: grab distance of a handle

  /// @param center  of the piece at its present pose, world, mm. @param width, height  of the picture, pixels.
  PieceGizmo(const Camera& camera, int width, int height, const Vec3d& center);

  Pixel center() const;
  Pixel arrowTip(int axis) const;
  std::vector<Pixel> ring(int axis) const;  ///< closed
  /// The nearest handle within reach. None: no handle in reach. An arrow that points at the viewer cannot be grabbed.
  std::optional<GizmoHandle> handleAt(const Pixel& at) const;

  /// Pose after a drag: moved along the axis, turned about it through the centre, or moved in the picture.
  Rigid3 dragged(GizmoHandle handle, const Pixel& from, const Pixel& to, const Rigid3& pose) const;

 private:
  Pixel flat(const Vec3d& direction) const;      // pixels per mm, in a plane perpendicular to the view
  Pixel onScreen(const Vec3d& direction) const;  // pixels per mm, at the centre
  double growth(const Vec3d& direction) const;   // per mm: growth in perspective along that direction
  double alongAxis(const Vec3d& direction, const Pixel& by) const;  // mm

  Camera camera_;
  Pixel middle_;         // of the picture
  double mm_per_pixel_;  // at the centre of the piece
  Vec3d center_;
};

}  // namespace kerf
