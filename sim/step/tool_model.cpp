#include "sim/step/tool_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

constexpr double kGrindingEnergy = 22;                       // over the table's
constexpr double kRadPerSecond = 2 * std::numbers::pi / 60;  // of one turn per minute

// Motion of the drive in one turn or cycle: rad or mm.
double wayPerCycle(const Tool& tool) {
  if (motionOf(tool) == ToolMotion::kSpin) return 2 * std::numbers::pi;
  return meanSpeed(tool.motion->way(tool), 1);
}

// Puts the given numbers over those of `drive`.
ToolDrive with(const DriveNumbers& said, const Tool& tool, ToolDrive drive) {
  if (said.frequency_hz) drive.speed = wayPerCycle(tool) * *said.frequency_hz;
  drive.stall_load = said.stall_load.value_or(drive.stall_load);
  drive.time_constant = said.time_constant_s.value_or(drive.time_constant);
  drive.energy_factor = said.energy_factor.value_or(drive.energy_factor);
  drive.drag_factor = said.drag_factor.value_or(drive.drag_factor);
  return drive;
}

bool isDiamond(const Tool& tool) { return tool.iso ? tool.iso->material == "806" : tool.kind == ToolKind::kBlade; }

// Burs, drills and discs.
ToolDrive spinDrive(const Tool& tool) {
  constexpr double kDrillSpeed = 1750;  // mm / min: as for implant drills
  const Handpiece& handpiece = handpieceOf(tool);
  const double rpm = handpiece.rpm > 0 ? handpiece.rpm : kDrillSpeed / std::max(tool.head_diameter_mm, 0.5);

  ToolDrive drive;
  drive.form = handpiece.form;
  drive.speed = rpm * kRadPerSecond;
  drive.stall_load = handpiece.stall_Nmm;
  drive.time_constant = handpiece.time_constant_s;
  drive.run_down = handpiece.run_down_s;
  drive.droop = handpiece.droop;

  if (isDrill(tool)) {
    drive.energy_factor = 0.3;  // of its land: it reams the remains behind the lips
  } else if (isFrictionGrip(tool)) {
    // Cutting friction is 0.4 of diamond, 0.5 of carbide, where the table has 0.3. With these energies 1 N removes the
    // volume measured in enamel: `kerf-bench drives`.
    drive.drag_factor = isDiamond(tool) ? 4.0 / 3 : 5.0 / 3;
    drive.energy_factor = kGrindingEnergy;
  } else {
    // Chips of a grain are thinner than those of a blade and cost more work: reported energies of grinding enamel are
    // 10 to 100 J/mm^3 where the table, after hardness, has 4.2.
    drive.energy_factor = isDiamond(tool) ? 5 : 3;
  }
  return drive;
}

// The point of a drill, from its outline: the first piece is the cone.
DrillLips lipsOf(const Tool& tool) {
  if (!isDrill(tool)) return {};
  const auto corner = tool.head->pieces().front().to;  // radius, height
  const double radius = corner[0], height = corner[1];

  DrillLips lips;
  lips.height = height;
  lips.slope = radius / std::hypot(radius, height);
  lips.most_feed = DrillLips::kMostFeed * tool.head_diameter_mm;
  // Torque over thrust: u (f + 0.02) / (8 K) D^0.75 in mm, u = 250 N/mm^2, is 0.68 mm at D 2, where the mean radius of
  // the thrust is 0.56 mm: a friction of 1.2 against 0.3 of the table.
  lips.drag_factor = 4;
  return lips;
}

}  // namespace

ToolMotion motionOf(const Tool& tool) { return tool.motion ? tool.motion->form : ToolMotion::kSpin; }

bool isDrill(const Tool& tool) { return tool.shape == "drill" && tool.cuts_end && !tool.cuts_side; }

bool isFrictionGrip(const Tool& tool) {
  if (tool.shape == "drill") return false;
  if (tool.iso && tool.iso->shankKnown()) return tool.iso->shankKnown()->diameter_mm < 2;
  return tool.kind == ToolKind::kBur && tool.head_diameter_mm > 0 && tool.head_diameter_mm < 3;
}

const Handpiece& handpieceOf(const Tool& tool) {
  if (tool.drive.handpiece) return *tool.drive.handpiece;
  const bool is_right_angle = tool.iso && tool.iso->shank.starts_with("20");
  const char* name = isDrill(tool)          ? "implant"
                     : isFrictionGrip(tool) ? "turbine"
                     : is_right_angle       ? "contra-angle"
                                            : "straight";
  return *findHandpiece(name);
}

ToolDrive driveOf(const Tool& tool) { return with(tool.drive, tool, defaultDrive(tool)); }

std::string describeDrive(const Tool& tool) {
  const ToolDrive drive = driveOf(tool);
  const double way = wayPerCycle(tool), frequency = way > 0 ? drive.speed / way : 0;

  std::string text;
  switch (motionOf(tool)) {
    case ToolMotion::kSpin:
      text = fmt::format("{}, {:.6g} rpm, stalls at {:.4g} N mm", handpieceOf(tool).name, 60 * frequency,
                         drive.stall_load);
      break;
    case ToolMotion::kStroke:
      text = tool.motion->drive_keys.unit == std::string_view("kHz") ? fmt::format("{:.4g} kHz", frequency / 1000)
                                                                     : fmt::format("{:.6g} cycles/min", 60 * frequency);
      text += fmt::format(", {:.4g} mm/s in the mean, stalls at {:.4g} N", drive.speed, drive.stall_load);
      break;
    case ToolMotion::kSwing:
      text = fmt::format("{:.6g} cycles/min, {:.4g} mm/s in the mean at the tip, stalls at {:.4g} N mm", 60 * frequency,
                         drive.speed * tool.blade_length_mm, drive.stall_load);
  }
  text += fmt::format(", follows in {:.3g} s", drive.time_constant);
  if (drive.run_down > 0) text += fmt::format(", runs down in {:.3g} s", drive.run_down);
  text += fmt::format("; cutting energy x {:.3g}, drag x {:.3g}", drive.energy_factor, drive.drag_factor);

  std::string from_file;
  const auto say = [&](const std::optional<double>& number, const char* name) {
    if (number) from_file += (from_file.empty() ? "" : ", ") + std::string(name);
  };
  if (tool.drive.handpiece) from_file = "handpiece";
  say(tool.drive.frequency_hz, "speed");
  say(tool.drive.stall_load, "stall");
  say(tool.drive.time_constant_s, "time");
  say(tool.drive.energy_factor, "energy");
  say(tool.drive.drag_factor, "drag");
  return text + (from_file.empty() ? " (training defaults)" : " (from the tool's file: " + from_file + ")");
}

ToolDrive defaultDrive(const Tool& tool) {
  if (motionOf(tool) == ToolMotion::kSpin) return spinDrive(tool);
  return with(tool.motion->usual_drive(tool), tool, {});
}

ToolModel makeToolModel(const Tool& tool, double margin_mm) {
  ToolModel out;
  out.id = tool.id;
  ToolFieldOptions options;
  options.margin_mm = margin_mm;
  out.cut = ToolField(*tool.cut, options);
  if (tool.body) {
    options.spacing_mm = 0.02;  // the body only collides: it is longer, and leaves no print to measure
    out.body = ToolField(*tool.body, options);
  }
  const bool has_symmetry = !tool.body || tool.body->symmetry() == tool.cut->symmetry();
  out.core = makeToolCore(out.cut, out.body, has_symmetry ? tool.cut->symmetry() : ToolShape::Symmetry::kNone,
                          tool.body ? tool.body->halfThickness() : tool.cut->halfThickness());
  out.drive = driveOf(tool);
  out.lips = lipsOf(tool);
  out.cuts_backwards = isDiamond(tool);
  out.motion = motionOf(tool);
  if (out.motion == ToolMotion::kSwing) out.pivot_mm = tool.blade_length_mm;
  const Box3& box = out.cut.bounds();
  out.equator_mm = std::max({-box.min[0], box.max[0], -box.min[1], box.max[1]});
  out.finest_mm = tool.finest();
  out.smallest_radius_mm = tool.kind == ToolKind::kBlade ? 0.5 * tool.kerfWidth() : 0.5 * tool.finest();
  out.reach_mm = std::max(out.cut.reach(), out.body.reach());
  out.plunge_direction = tool.plunge_direction;
  if (tool.kind == ToolKind::kBlade) out.flank_axis = out.motion == ToolMotion::kSpin ? 2 : 1;
  return out;
}

}  // namespace kerf
