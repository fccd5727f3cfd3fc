// A cutting tool: what cuts, what only collides, and where it comes from.
//
// Frame: tip at the origin, axis +z towards the shank, mm.
//   bur    revolved about +z; plunges along -z.
//   blade  extends along +z from its tip, thickness along y, teeth along the edge x = 0, body towards +x: it cuts
//   towards -x.
//          The stroke is part of the shape: the cycle-averaged envelope reaches half a stroke beyond either end.
#pragma once

#include <memory>
#include <string>

#include "geometry/mesh.h"
#include "geometry/tool_shape.h"

namespace kerf {

enum class ToolKind { kBur, kBlade };

struct Tool {
  std::string id;    ///< file stem: "round-014"
  std::string name;  ///< for people
  std::string description;
  std::string iso6360;  ///< fifteen digits, or empty
  ToolKind kind = ToolKind::kBur;
  std::shared_ptr<const ToolShape> cut;      ///< tau_cut: the bur's head, the blade's toothed edge with its set
  std::shared_ptr<const ToolShape> body;     ///< tau_body: neck, shank, flanks; may be null
  Vec3d plunge_direction = -Vec3d::UnitZ();  ///< unit, tool frame: the way it goes straight in

  // Bur: the head's outline (what revolves). Blade: the numbers of its edge.
  std::shared_ptr<const RevolvedProfile> head;
  double head_diameter_mm = 0;  ///< bur
  double head_length_mm = 0;    ///< bur: along z
  double thickness_mm = 0;      ///< blade, without set
  double set_per_side_mm = 0;   ///< blade
  double blade_length_mm = 0, blade_width_mm = 0, stroke_mm = 0, tooth_pitch_mm = 0, edge_depth_mm = 0;

  double kerfWidth() const { return thickness_mm + 2 * set_per_side_mm; }  ///< blade, mm
};

/// Volume a tool takes out of a half-space when it goes straight in along plunge_direction by `depth`, mm^3, from its
/// parameters alone (not from its distance field), good to 1e-9: the yardstick of `kerf tool check`.
/// Bur: integral of pi R(z)^2, R the widest cutting radius that has passed; blade: kerf x envelope length x depth.
double plungeVolume(const Tool& tool, double depth_mm);

/// The tool as a mesh for the eye: closed pieces, outward, teeth drawn; chords within `tolerance_mm` of the true
/// outline.
Mesh toolMesh(const Tool& tool, double tolerance_mm = 0.005);

/// Shape, numbers and units, for people and as JSON.
std::string describe(const Tool& tool);
std::string toJson(const Tool& tool);

}  // namespace kerf
