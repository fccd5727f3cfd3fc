// The ghost of the tool: its pose over the surface under the cursor, before a press and at the start of a stroke.
#pragma once

#include <optional>

#include "geometry/field/brick_field.h"
#include "geometry/tool/tool.h"
#include "ui/app/view/live_scene.h"

namespace kerf {

/// Pose of a tool that hovers or is about to cut, and its depth below the surface as loaded.
struct ToolOverSurface {
  std::uint32_t object = 0;       ///< CutObject::id
  Rigid3 T_world_object;          ///< of that object
  Rigid3 T_world_tool;            ///< its leading point is on the surface as it is now
  Vec3d point = Vec3d::Zero();    ///< leading point, mm
  Vec3d normal = Vec3d::UnitZ();  ///< unit, outward: the tool plunges against it
  double depth = 0;               ///< of the point below the surface as loaded, along the normal, mm
  double reach = 0;               ///< from the tip against the normal to the leading point, mm
  Vec3d front = Vec3d::Zero();    ///< from the tip to the contact, square to the normal, mm: of a guided blade and of a
                                  ///< tilted tool
  Vec3d slant = Vec3d::Zero();    ///< of a tilted tool: MouseAim::slant
  bool is_held = false;           ///< its axis is held: MouseAim::is_attitude_held
};

/// Direction and extent of a plunge, tool frame.
struct Plunge {
  Vec3d direction = -Vec3d::UnitZ();  ///< unit: Tool::plunge_direction
  double reach = 0;                   ///< from the tip along it to the leading point, mm
  double radius = 0.5;                ///< of the supporting surface, mm
};
Plunge plungeOf(const Tool& tool);

/// The tool at the surface hit by a ray. None: no hit, or a neighbour.   @param loaded  the surface as loaded, in the
/// frame of every piece of it.
std::optional<ToolOverSurface> toolOver(const LiveScene& scene, const BrickField& loaded, const Ray& ray,
                                        const Plunge& plunge);

/// Attitude of a tool that plunges against `axis` (unit, out of the tissue), with the least turn from upright.
Eigen::Quaterniond attitudeAlong(const Plunge& plunge, const Vec3d& axis);

/// Depth of a point below a surface, mm: back along `axis` (unit, out of the tissue) to the first air. Negative in air:
/// against the axis to the surface. None: no surface within 60 mm, in air within 12.   @cost  some µs.
std::optional<double> depthBelow(const BrickField& loaded, const Vec3d& point, const Vec3d& axis);

/// From outside along `axis` (unit, out of the tissue) to the original surface. Without a surface there: the point.
Vec3d onOriginal(const BrickField& loaded, const Vec3d& point, const Vec3d& axis);

}  // namespace kerf
