// The core of a tool: points of its medial axis, each the middle of a ball inside it. They may not enter an object.
//
// The shell's force grows with the overlap of surfaces, and ends with it: once a thin tip is past the surface, nothing
// pushes it back. A core cannot get past the surface: sim/step/core_contact.h.
#pragma once

#include <vector>

#include "geometry/tool/tool_field.h"

namespace kerf {

struct CorePoint {
  Vec3f place;        ///< tool frame, mm
  float radius = 0;   ///< of the largest ball about it inside the tool, mm
  bool cuts = false;  ///< the ball meets the cutting part first
  bool is_thin =
      false;  ///< of a point, an edge or a fin: holds at rest only, a point that stood on its tip would not cut
};

/// Radius of the smallest ball of a core that holds a running tool, mm. Thinner ones are CorePoint::is_thin.
inline constexpr double kThinnestCore = 0.07;

/// The core of a tool of both parts, of which `body` may be empty.
///   revolved  points of the axis, from the lowest that lies deep enough; of a disc, a ring at its rim
///   plate     points along the rim, where the plate reaches its full thickness
///   others    points of a lattice around the cutting part where the distance has no gradient, from the tip upwards
/// Last come the thin points, where tip or edge is sharper than 74 degrees.
/// @param symmetry  of both parts.   @param half_thickness  of a plate, mm.
/// @cost  for a mesh at most 2 million points of a lattice and eight for each at its surface, one after the other; for
/// any other tool thousands.
std::vector<CorePoint> makeToolCore(const ToolField& cut, const ToolField& body, ToolShape::Symmetry symmetry,
                                    double half_thickness);

}  // namespace kerf
