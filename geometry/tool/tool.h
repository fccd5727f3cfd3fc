// A cutting tool: its cutting part, its inert part, and its source.
//
// Frame: tip at the origin, axis +z towards the shank, mm.
//   bur    revolved about +z; plunges along -z, sideways along -x if its end does not cut.
//   blade  reciprocating, piezo: extends along +z from its tip, thickness along y, teeth along the edge x = 0, body
//          towards +x: it cuts towards -x. The stroke is part of the shape: the cycle-averaged envelope reaches half a
//          stroke beyond either end.
//          sagittal: teeth along the tip, an arc about the pivot at z = length; swings in the plane y = 0, cuts towards
//          -z. The envelope is the sector its teeth sweep.
//          disc: revolved about +z like a bur, 0 <= z <= kerf; cuts with its rim, plunges along -x.
//   mesh   any closed solid, placed by its tip and axis; it turns about +z. The solid of revolution of the part below a
//          height cuts, along -z.
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

/// Drive of a tool as in its file. Missing values are training defaults: for a blade those of its motion, else of
/// `sim/step/tool_model.h`.
struct DriveNumbers {
  const Handpiece* handpiece = nullptr;              ///< handpiece; null: by the tool's shank. Never set for a saw
  std::optional<double> frequency_hz;                ///< free speed, turns or cycles (there and back) a second
  std::optional<double> stall_load;                  ///< stall load: N mm; N for a stroke along z
  std::optional<double> time_constant_s;             ///< response time of the speed to load and pedal
  std::optional<double> energy_factor, drag_factor;  ///< factors on the table of materials: see ToolDrive
};

struct Tool {
  std::string id;    ///< file stem: "round-014"
  std::string name;  ///< for display
  std::string description;
  std::string iso6360;         ///< fifteen digits, or empty
  std::optional<Iso6360> iso;  ///< the same in parts
  ToolKind kind = ToolKind::kBur;
  std::shared_ptr<const ToolShape> cut;      ///< tau_cut: the cutting part of the head, the blade's toothed edge with
                                             ///< its set
  std::shared_ptr<const ToolShape> body;     ///< tau_body: parts that only collide (inert parts, neck, shank); may be
                                             ///< null
  Vec3d plunge_direction = -Vec3d::UnitZ();  ///< unit, tool frame: direction of a straight plunge

  DriveNumbers drive;
  std::filesystem::path companion;  ///< file beside the TOML that it names: a mesh or an outline; may be empty

  // Bur and disc: outlines of the revolved parts. Mesh: `cutting`.
  std::shared_ptr<const RevolvedProfile> head;         ///< all of the head
  std::shared_ptr<const RevolvedProfile> cutting;      ///< its cutting part
  std::vector<RevolvedProfile> body_outlines;          ///< its inert parts; together they are `body`
  std::string shape;                                   ///< bur: the head's shape by name
  bool cuts_side = true, cuts_end = true;              ///< bur
  double head_diameter_mm = 0;                         ///< bur; disc: its diameter
  double head_length_mm = 0;                           ///< bur: along z
  double neck_diameter_mm = 0, shank_diameter_mm = 0;  ///< 0: none in the file

  // Blade.
  const BladeMotion* motion = nullptr;  ///< a row of bladeMotions(); null for other tools
  double thickness_mm = 0;              ///< without set
  double set_per_side_mm = 0;           ///< set of the teeth on each side
  double blade_length_mm = 0, blade_width_mm = 0, stroke_mm = 0, tooth_pitch_mm = 0, edge_depth_mm = 0;
  double swing_deg = 0;  ///< sagittal: whole angle

  // Mesh.
  std::shared_ptr<const Mesh> mesh;      ///< all of it, tool frame, mm
  double cut_below_mm = 0;               ///< the part below this height cuts: its solid of revolution, `cutting`, ...
  std::vector<RevolvedProfile> hollows;  ///< ... without these
  double turned_mm3 = 0, unturned_mm3 = 0;  ///< volume of that solid, and of the mesh there
  bool body_turns = true;                   ///< false: `body` is the mesh as it is, such as a handpiece
  double mm_per_unit = 1;                   ///< of its file

  double kerfWidth() const { return thickness_mm + 2 * set_per_side_mm; }  ///< blade, mm
  /// Sagittal: width of the tip's sweep, mm: W + 2 L sin(angle / 2).
  double sweptWidth() const;
  /// The smallest extent that a grid has to resolve: width or height of the cutting part of a bur or mesh, kerf of a
  /// blade; mm.
  double finest() const;
};

/// Volume that a tool removes from a half-space in a straight plunge along plunge_direction, by `depth` from the first
/// contact of its cutting part, mm^3. Computed from its parameters alone (not from its distance field), accurate to
/// 1e-9 (a mesh: 1e-3): the reference of `kerf tool check`. Along the axis: integral of pi R(z)^2, R the widest cutting
/// radius so far; sideways: integral of the segments its circles cut; blade: kerf x area; mesh: columns above its
/// lowest triangles.
/// @param window  mm: counts only the middle stretch of that length of a blade's edge.
double plungeVolume(const Tool& tool, double depth_mm, double window_mm = std::numeric_limits<double>::infinity());

/// The tool as a mesh for display: closed pieces, outward, teeth drawn; chords within `tolerance_mm` of the true
/// outline.
Mesh toolMesh(const Tool& tool, double tolerance_mm = 0.005);

/// Shape, numbers and units, as text and as JSON.
std::string describe(const Tool& tool);
std::string toJson(const Tool& tool);

}  // namespace kerf
