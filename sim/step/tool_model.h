// A tool as the step sees it: its two distance fields, how it moves on its own, and what drives it.
#pragma once

#include "geometry/tool/blade_motion.h"
#include "geometry/tool/tool.h"
#include "geometry/tool/tool_field.h"
#include "sim/step/tool_core.h"

namespace kerf {

/// What turns or moves the cutting part. Its speed without load falls in proportion to the load and reaches zero at
/// stall.
///
/// The speed of a part that goes to and fro is the mean over a cycle: at the ends of a stroke a tooth stands still, in
/// its middle it is pi / 2 times as fast. Removal and power grow with the distance a tooth rubs, so the mean of |v|
/// counts: 2 stroke f, whatever the motion in between, because the tooth passes the stroke twice a cycle.
struct ToolDrive {
  double speed = 0;          ///< kSpin: rad/s; kStroke: mean speed along the stroke, mm/s; kSwing: mean rad/s
  double stall_load = 0;     ///< kSpin, kSwing: N mm; kStroke: N
  double time_constant = 0;  ///< s: how fast speed follows
  /// Specific cutting energy of this tool over that of the materials' table: fine grit makes fine chips, and those cost
  /// more work per volume.
  double energy_factor = 1;
  /// Drag coefficient of this tool over that of the materials' table: teeth that plane drag more than grains that
  /// grind.
  double drag_factor = 1;
};

struct ToolModel {
  std::string id;
  ToolField cut, body;          ///< tau_cut erodes; min(tau_cut, tau_body) collides
  std::vector<CorePoint> core;  ///< keeps what is thin from sinking: sim/step/core_contact.h
  ToolMotion motion = ToolMotion::kSpin;
  ToolDrive drive;
  double equator_mm = 0;          ///< kSpin: largest cutting radius. Surface speed counts as at least 0.2 of that there
  double pivot_mm = 0;            ///< kSwing: height of the pivot
  double finest_mm = 0;           ///< no motion without an evaluation of contact is longer than half of this
  double smallest_radius_mm = 0;  ///< of what cuts: scallops between two poses stay below 0.05 voxel
  double reach_mm = 0;            ///< farthest point from the tip
  Vec3d plunge_direction = -Vec3d::UnitZ();
};

/// Mean speed of what goes `way` (mm or rad) there and back, `frequency_hz` times a second: 2 way f.
constexpr double meanSpeed(double way, double frequency_hz) { return 2 * way * frequency_hz; }

/// Nominal drive of a tool: burs by their shank (friction grip 200 000 rpm, right angle 40 000, else 20 000), drills
/// 800 rpm, blades by their motion. Training defaults.
ToolDrive defaultDrive(const Tool& tool);
/// The numbers of its file ([drive]), the default for each that is left out.
ToolDrive driveOf(const Tool& tool);
/// The same as text: "200000 rpm, stalls at 8 N mm, ...", and which of the numbers come from the tool's file.
std::string describeDrive(const Tool& tool);
ToolMotion motionOf(const Tool& tool);

/// Bakes both fields. @param margin_mm  at least the band of any object it will meet.
ToolModel makeToolModel(const Tool& tool, double margin_mm = 0.5);

}  // namespace kerf
