// Pose of a saw blade in a planned plane: direction of its teeth, size of one pass, reach.
//
// In the plane: `across` runs along the teeth, `approach` is the direction of the teeth into the bone, both unit;
// across = normal x approach, right-handed.
#pragma once

#include <optional>
#include <string>

#include "geometry/base/types.h"
#include "geometry/tool/tool.h"

namespace kerf {

/// Axes are of the tool's frame, unit; lengths in mm.
struct SawBlade {
  Vec3d plunge = -Vec3d::UnitX();  ///< direction of the teeth into the bone
  Vec3d normal = Vec3d::UnitY();   ///< square to the blade
  Vec3d edge = Vec3d::UnitZ();     ///< along the teeth: normal x plunge
  Vec3d front = Vec3d::Zero();     ///< middle of the kerf and of the teeth, at the leading point
  double kerf = 0.4;               ///< width of the cut
  double span = 10;                ///< along the teeth, cut in one pass
  double flat = 10;                ///< part of the span as deep as the front, except for `sag`; narrower sections take
                                   ///< one pass
  double step = 10;                ///< from one pass to the next, in wider sections
  double sag = 0;                  ///< loss of depth half a step beside the middle, for teeth on an arc
  double most_width = 60;          ///< widest section: a handpiece at the end of the blade stays outside the bone
  double most_depth = 60;          ///< depth limit: contact of the handpiece, or of the mandrel of a disc, with the
                                   ///< bone
  bool is_held_at_end = false;     ///< the handpiece is at the +edge end, beside the bone; else behind the teeth

  /// Blades of every motion are saws, including discs. Empty if `tool` is no blade.
  static std::optional<SawBlade> of(const Tool& tool);

  /// The tool with its front at a point, its teeth towards `approach`, its blade square to `normal`.
  /// @param is_turned  turns the blade against `normal`: the +edge end lies towards -across.
  /// @pre approach and normal are unit and square to each other.
  Rigid3 poseAt(const Vec3d& front_at, const Vec3d& normal, const Vec3d& approach, bool is_turned) const;
};

}  // namespace kerf
