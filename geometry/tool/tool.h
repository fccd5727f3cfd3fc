// A cutting tool: what cuts, what only collides, and where it comes from.
//
// Frame: tip at the origin, axis +z towards the shank, mm.
//   bur    revolved about +z; plunges along -z, sideways along -x if its end does not cut.
//   blade  reciprocating, piezo: extends along +z from its tip, thickness along y, teeth along the edge x = 0, body
//          towards +x: it cuts towards -x. The stroke is part of the shape: the cycle-averaged envelope reaches half a
//          stroke beyond either end.
//          sagittal: teeth along the tip, an arc about the pivot at z = length; swings in the plane y = 0, cuts towards
//          -z. The envelope is the sector its teeth sweep.
//          disc: revolved about +z like a bur, 0 <= z <= kerf; cuts with its rim, plunges along -x.
//   mesh   any closed solid, placed by its tip and axis; what lies below a height cuts, along -z.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/mesh/mesh.h"
#include "geometry/tool/blade_motion.h"
#include "geometry/tool/handpiece.h"
#include "geometry/tool/iso6360.h"
#include "geometry/tool/tool_shape.h"

namespace kerf {

enum class ToolKind { kBur, kBlade, kMesh };
const char* kindName(ToolKind kind);  ///< as in files: "bur"

/// What a tool's file says of its drive. What it leaves out is a training default: of a blade its motion's, else one of
/// `sim/step/tool_model.h`.
struct DriveNumbers {
  const Handpiece* handpiece = nullptr;              ///< what turns it; null: by its shank. Never of a saw
  std::optional<double> frequency_hz;                ///< turns, or cycles there and back, a second, free
  std::optional<double> stall_load;                  ///< what stops it: N mm, of a stroke along z N
  std::optional<double> time_constant_s;             ///< how fast speed follows load and pedal
  std::optional<double> energy_factor, drag_factor;  ///< over those of the table of materials: see ToolDrive
};

struct Tool {
  std::string id;    ///< file stem: "round-014"
  std::string name;  ///< for people
  std::string description;
  std::string iso6360;         ///< fifteen digits, or empty
  std::optional<Iso6360> iso;  ///< the same in parts
  ToolKind kind = ToolKind::kBur;
  std::shared_ptr<const ToolShape> cut;      ///< tau_cut: what of the head cuts, the blade's toothed edge with its set
  std::shared_ptr<const ToolShape> body;     ///< tau_body: what only collides (inert parts, neck, shank); may be null
  Vec3d plunge_direction = -Vec3d::UnitZ();  ///< unit, tool frame: the way it goes straight in

  DriveNumbers drive;

  // Bur and disc: outlines of what revolves.
  std::shared_ptr<const RevolvedProfile> head;     ///< all of the head
  std::shared_ptr<const RevolvedProfile> cutting;  ///< what of it cuts
  std::vector<RevolvedProfile> body_outlines;      ///< what does not; together they are `body`
  std::string shape;                               ///< bur: the head's shape by name
  bool cuts_side = true, cuts_end = true;          ///< bur
  double head_diameter_mm = 0;                     ///< bur; disc: its diameter
  double head_length_mm = 0;                       ///< bur: along z

  // Blade.
  const BladeMotion* motion = nullptr;  ///< a row of bladeMotions(); null if it is no blade
  double thickness_mm = 0;              ///< without set
  double set_per_side_mm = 0;           ///< how far teeth stand out
  double blade_length_mm = 0, blade_width_mm = 0, stroke_mm = 0, tooth_pitch_mm = 0, edge_depth_mm = 0;
  double swing_deg = 0;  ///< sagittal: whole angle

  // Mesh.
  std::filesystem::path mesh_file;
  std::shared_ptr<const Mesh> mesh;  ///< all of it, tool frame, mm
  double cut_below_mm = 0;           ///< what of it lies below this height cuts

  double kerfWidth() const { return thickness_mm + 2 * set_per_side_mm; }  ///< blade, mm
  /// Sagittal: width of what the tip sweeps, mm: W + 2 L sin(angle / 2).
  double sweptWidth() const;
  /// The smallest extent that a grid has to resolve: of a bur or mesh its cutting part's width or height, of a blade
  /// the kerf; mm.
  double finest() const;
};

/// Volume a tool takes out of a half-space when it goes straight in along plunge_direction by `depth` from where its
/// cutting part touches, mm^3, from its parameters alone (not from its distance field), good to 1e-9 of itself (a
/// mesh: 1e-3): the yardstick of `kerf tool check`. Along the axis: integral of pi R(z)^2, R the widest cutting radius
/// that has passed; sideways: integral of the segments its circles cut; blade: kerf x area; mesh: columns above its
/// lowest triangles.
/// @param window  mm: counts only the middle stretch of that length of a blade's edge.
double plungeVolume(const Tool& tool, double depth_mm, double window_mm = std::numeric_limits<double>::infinity());

/// The tool as a mesh for the eye: closed pieces, outward, teeth drawn; chords within `tolerance_mm` of the true
/// outline.
Mesh toolMesh(const Tool& tool, double tolerance_mm = 0.005);

/// Shape, numbers and units, for people and as JSON.
std::string describe(const Tool& tool);
std::string toJson(const Tool& tool);

}  // namespace kerf
