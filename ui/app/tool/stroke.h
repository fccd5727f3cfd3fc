// One stroke by mouse: converts cursor rays to aims of MouseHand.
//
// The button press anchors the stroke to a point of the surface as loaded, and to an axis: the mean normal around the
// point. The cursor then moves over the surface as loaded, never over the fresh cut, so a held button does not tunnel
// towards the eye. Beside the object it moves in the plane through the anchor.
#pragma once

#include "geometry/field/brick_field.h"
#include "geometry/mesh/mesh.h"
#include "geometry/tool/tool.h"
#include "sim/hand/mouse_hand.h"
#include "ui/app/tool/tool_ghost.h"

namespace kerf {

class Stroke {
 public:
  /// @param loaded  the surface as loaded; kept by reference.
  /// @param head  of the tool, tool frame: at the start its vertices touch nothing of the surface as loaded.
  Stroke(const BrickField& loaded, const ToolOverSurface& at, const Mesh& head);

  /// Pose of the tool before the stroke: above the anchor, in air.
  const Rigid3& start() const { return start_; }
  /// Sets the aim of the hand at the press. Keeps the values set by sliders.
  void begin(MouseAim& aim) const;
  const Vec3d& anchor() const { return anchor_; }
  const Vec3d& axis() const { return axis_; }  ///< out of the tissue, unit: the normal, also of a tilted tool
  /// Target of the contact point for a cursor ray: world, mm.
  Vec3d pointerOf(const Ray& ray) const;
  /// Depth of a tool with this tip below the surface as loaded, along the axis, mm; negative in air.
  double depthOf(const Vec3d& tip) const;

 private:
  const BrickField& loaded_;
  Rigid3 T_world_object_, to_object_;  // of the piece that is cut
  Vec3d anchor_, axis_;                // world
  double reach_;
  Vec3d front_, slant_;
  bool is_held_;
  Rigid3 start_;
};

}  // namespace kerf
