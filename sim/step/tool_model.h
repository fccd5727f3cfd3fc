// A tool in the step: its two distance fields, its own motion, and its drive.
#pragma once

#include "geometry/tool/blade_motion.h"
#include "geometry/tool/tool.h"
#include "geometry/tool/tool_field.h"
#include "sim/step/tool_core.h"

namespace kerf {

/// Drive of the cutting part. With free speed s0, time constant T, stall load L, the mean load M of the tick and the
/// pedal p, 0 to 1, the speed s follows
///   kLine      ds/dt = (p s0 max(0, 1 - M / L) - s) / T.
///   kTurbine   ds/dt = ((p^2 - M / L) s0 - p s) / T, and - s0 / run_down at p = 0, but never below 0. The torque of an
///              air turbine falls in proportion to its speed; T = J s0 / L of the rotor's inertia J. Torque at
///              standstill goes with the pressure, free speed with its root: p^2 is the pressure. Power is greatest at
///              half of the stall load: a heavier hand removes less. Without air the bearing, or a brake, stops it.
///   kGoverned  follows p s0 (1 - droop min(1, M / L)) within a tenth of T, as far as the torque L is enough:
///              |ds/dt| <= s0 / T (1 -+ M / L). A load above L stops it. With p < 0 it turns backwards by
///              the same law: it slows down, stops, and comes up the other way.
/// Sources: Dyson & Darvell 1999, Brockhurst & Shams 1994 for turbines; training defaults in
/// geometry/tool/handpiece.cpp.
///
/// A part that goes to and fro has the mean speed over a cycle: at the ends of a stroke a tooth stands still, in its
/// middle it is pi / 2 times as fast. Removal and power grow with the distance a tooth rubs, so the mean of |v| counts:
/// 2 stroke f for any motion in between, because the tooth passes the stroke twice a cycle.
struct ToolDrive {
  double speed = 0;          ///< kSpin: rad/s; kStroke: mean speed along the stroke, mm/s; kSwing: mean rad/s
  double stall_load = 0;     ///< kSpin, kSwing: N mm; kStroke: N; 0: cannot stall
  double time_constant = 0;  ///< s: delay of the speed; 0: none
  /// Specific cutting energy of this tool over that of the materials' table: fine grit makes fine chips, which cost
  /// more work per volume.
  double energy_factor = 1;
  /// Drag coefficient of this tool over that of the materials' table: planing teeth drag more than grinding grains.
  double drag_factor = 1;
  DriveForm form = DriveForm::kLine;
  double run_down = 0;  ///< kTurbine: s from free speed to rest without air; 0: only the load slows it
  double droop = 0;     ///< kGoverned: fraction of the speed lost at stall_load
};

/// The lips of a drill: the cutting edges of its point. A chip is as thick as the feed of a turn, so thrust grows with
/// feed, not with friction's power. At a distance r from the axis the pressure is p = a(r) q (f + f0), f the feed
/// along the axis in a turn, a(r) = 1.25 K (2 r)^0.25 / (pi r), so that a point of diameter D needs the thrust
///   F = K D^1.25 (f + f0) q,   K = 51.8 N/mm^2.25, f0 = 0.03 mm.
/// q = (u_s / 1000 N/mm^2)^0.75 is 1 for cortical bone. As u_s goes with the square of bone's density, q goes with its
/// power 1.5. The cutting force turns about the axis: two opposite lips push to no side. Below F = K D^1.25 f0 q the
/// lips only rub. Lips take at most the feed D / 12 a turn, a little more than twist drills of 2 to 2.3 mm were driven
/// at (0.14 mm a turn: Harris & Kohles 2001). Any further push leans on the core, and feeds more by up to 0.3 of it
/// (800 rpm, up to 20 N in cancellous bone, 0.1 mm voxels). Behind the point, up to the end of the cutting part, the
/// land reams by the law of friction. Sources: as measured by Saha et al. 1982 and Wiggins & Malkin 1976; the power of
/// D there is 1.3: 1.25 is two roots.
struct DrillLips {
  double height = 0;       ///< of the point, mm from the tip; 0: the tool has no lips
  double slope = 1;        ///< depth along the normal of the point's surface for 1 mm along the axis
  double most_feed = 0;    ///< of a turn, mm
  double drag_factor = 1;  ///< of the point, over that of the materials' table: cutting torque over thrust

  static constexpr double kThrust = 51.8;        ///< K, N/mm^2.25
  static constexpr double kRubbing = 0.03;       ///< f0, mm
  static constexpr double kReference = 1000;     ///< u_s at which q is 1, N/mm^2
  static constexpr double kMostFeed = 1.0 / 12;  ///< of a turn, over D
  bool areThere() const noexcept { return height > 0; }
};

struct ToolModel {
  std::string id;
  ToolField cut, body;          ///< tau_cut erodes; min(tau_cut, tau_body) collides
  std::vector<CorePoint> core;  ///< keeps thin parts from sinking: sim/step/core_contact.h
  ToolMotion motion = ToolMotion::kSpin;
  ToolDrive drive;
  DrillLips lips;
  /// Whether it cuts when turned backwards: grains do. Blades and the lips of a drill then only rub, with their backs.
  bool cuts_backwards = true;
  double equator_mm = 0;          ///< kSpin: largest cutting radius. Surface speed counts as at least 0.2 of that there
  double pivot_mm = 0;            ///< kSwing: height of the pivot
  double finest_mm = 0;           ///< motion between contact evaluations is at most half of this
  double smallest_radius_mm = 0;  ///< of the cutting part: scallops between two poses stay below 0.05 voxel
  double reach_mm = 0;            ///< farthest point from the tip
  Vec3d plunge_direction = -Vec3d::UnitZ();
  int flank_axis = -1;  ///< of a blade or disc: the axis of its frame across its flanks; -1: neither
};

/// Mean speed of a motion over `way` (mm or rad) there and back, `frequency_hz` times a second: 2 way f.
constexpr double meanSpeed(double way, double frequency_hz) { return 2 * way * frequency_hz; }

/// A drill: it cuts with its point alone. A bone cutter has the same shape and cuts with its side too; it turns, sounds
/// and feels like a bur.
bool isDrill(const Tool& tool);
/// A bur for turbines and fast motors: by its shank; for a mesh with an unknown shank, if its head is below 3 mm.
bool isFrictionGrip(const Tool& tool);
/// Handpiece of a tool: from its file, else by its shank a turbine (friction grip), a contra-angle or a straight
/// handpiece, an implant motor for drills.
const Handpiece& handpieceOf(const Tool& tool);
/// Nominal drive of a tool, without the numbers of its file: by its handpiece; for a blade by its motion.
ToolDrive defaultDrive(const Tool& tool);
/// The numbers of its file ([drive]), with defaults for missing ones.
ToolDrive driveOf(const Tool& tool);
/// The same as text: "turbine, 380000 rpm, stalls at 1 N mm, ...", and which numbers come from the tool's file.
std::string describeDrive(const Tool& tool);
ToolMotion motionOf(const Tool& tool);

/// Bakes both fields. @param margin_mm  at least the band of any object it will meet.
ToolModel makeToolModel(const Tool& tool, double margin_mm = 0.5);

}  // namespace kerf
