// One stroke by mouse: from rays under the cursor to what MouseHand is asked for.
//
// Where the button goes down the stroke is anchored: to a point of the surface as loaded, and to an axis, the mean
// normal around the point. From then on the cursor moves over the surface as loaded, never over what was just cut: a
// held button does not tunnel towards the eye. Beside the object it moves in the plane through the anchor.
#pragma once

#include <optional>

#include "geometry/field/brick_field.h"
#include "geometry/mesh/mesh.h"
#include "geometry/tool/tool.h"
#include "sim/hand/mouse_hand.h"
#include "ui/app/live_scene.h"

namespace kerf {

/// A tool that hovers or is about to cut: where, and how deep below the surface as loaded.
struct ToolOverSurface {
  std::uint32_t object = 0;       ///< CutObject::id
  Rigid3 T_world_object;          ///< of that
  Rigid3 T_world_tool;            ///< what of it goes first is on the surface as it is now
  Vec3d point = Vec3d::Zero();    ///< there, mm
  Vec3d normal = Vec3d::UnitZ();  ///< unit, outward: the tool plunges against it
  double depth = 0;               ///< of the point below the surface as loaded, along the normal, mm
  double reach = 0;               ///< from the tip against the normal to what goes first, mm
  Vec3d front = Vec3d::Zero();  ///< from the tip to what touches, square to the normal, mm: of a blade in a guide, and
                                ///< of a tilted tool
  Vec3d slant = Vec3d::Zero();  ///< of a tilted tool: MouseAim::slant
};

/// How a tool goes into tissue, tool frame.
struct Plunge {
  Vec3d direction = -Vec3d::UnitZ();  ///< unit: Tool::plunge_direction
  double reach = 0;                   ///< from the tip along it to what goes first, mm
  double radius = 0.5;                ///< of the surface on which it stands, mm
};
Plunge plungeOf(const Tool& tool);

/// What a ray points at. None: nothing, or what stands beside.   @param loaded  the surface as loaded, in the frame of
/// every piece of it.
std::optional<ToolOverSurface> toolOver(const LiveScene& scene, const BrickField& loaded, const Ray& ray,
                                        const Plunge& plunge);

/// A tool's attitude in which it plunges against `axis` (unit, out of the tissue), turned least from upright.
Eigen::Quaterniond attitudeAlong(const Plunge& plunge, const Vec3d& axis);

/// How far a point is below a surface, mm: back along `axis` (unit, out of the tissue) to the first air. Negative in
/// air: against the axis to the surface. None: there is none within 60 mm, in air within 12.   @cost  some µs.
std::optional<double> depthBelow(const BrickField& loaded, const Vec3d& point, const Vec3d& axis);

class Stroke {
 public:
  /// @param loaded  the surface as loaded; kept by reference.   @param head  of the tool, tool frame: where it starts
  /// it
  ///   touches nothing that was loaded, as far as these vertices say.
  Stroke(const BrickField& loaded, const ToolOverSurface& at, const Mesh& head);

  /// Of the tool, before the stroke: above the anchor, in air.
  const Rigid3& start() const { return start_; }
  /// What the hand is asked for when the button has gone down there; what a slider sets is left as it is.
  void begin(MouseAim& aim) const;
  const Vec3d& anchor() const { return anchor_; }
  const Vec3d& axis() const { return axis_; }  ///< out of the tissue, unit: the normal, also of a tilted tool
  /// Where what touches is to go when the cursor points along this ray: world, mm.
  Vec3d pointerOf(const Ray& ray) const;
  /// How deep the tool with its tip there is below the surface as loaded, along the axis, mm; negative in air.
  double depthOf(const Vec3d& tip) const;

 private:
  const BrickField& loaded_;
  Rigid3 T_world_object_, to_object_;  // of the piece that is cut
  Vec3d anchor_, axis_;                // world
  double reach_;
  Vec3d front_, slant_;
  Rigid3 start_;
};

}  // namespace kerf
