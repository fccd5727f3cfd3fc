// Blades that go to and fro along z: reciprocating saws and piezo saws. Teeth along the edge x = 0; they cut towards
// -x.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/tool/blade_parts.h"
#include "geometry/tool/tool_mesh.h"

namespace kerf {
namespace {

using namespace internal;

constexpr const char* kKeys[] = {"width", "length", "stroke", "tooth_pitch", "edge_depth"};
constexpr DriveKeys kStrokes{"cycles_per_min", 10, 1e5, 1.0 / 60, "cycles/min", "stall_force_N", "N"};
constexpr DriveKeys kMicroStrokes{"frequency_khz", 1, 100, 1000, "kHz", "stall_force_N", "N"};

void read(TomlTable& top, Tool& tool, double least_stroke, double most_stroke) {
  readToothedBlade(top, tool);
  tool.stroke_mm = top.number("stroke", least_stroke, most_stroke);
  readEdgeDepth(top, tool);
  if (tool.edge_depth_mm > tool.blade_width_mm)
    top.reject("edge_depth", fmt::format("{}", tool.edge_depth_mm),
               fmt::format("at most the width, {} mm", tool.blade_width_mm));
  if (top.failed()) return;

  const double low = -0.5 * tool.stroke_mm, high = tool.blade_length_mm + 0.5 * tool.stroke_mm;
  const double half = 0.5 * tool.thickness_mm, half_kerf = 0.5 * tool.kerfWidth();
  tool.cut =
      std::make_shared<const BoxShape>(Box3{Vec3d(0, -half_kerf, low), Vec3d(tool.edge_depth_mm, half_kerf, high)});
  tool.body = std::make_shared<const BoxShape>(Box3{Vec3d(0, -half, low), Vec3d(tool.blade_width_mm, half, high)});
  tool.plunge_direction = -Vec3d::UnitX();
}
void readReciprocating(TomlTable& top, Tool& tool) { read(top, tool, 0, 40); }
void readPiezo(TomlTable& top, Tool& tool) { read(top, tool, 0.02, 0.3); }

double plunge(const Tool& tool, double depth_mm, double window_mm) {
  return tool.kerfWidth() * std::min(window_mm, tool.blade_length_mm + tool.stroke_mm) * depth_mm;
}

std::string inWords(const Tool& tool) {
  return fmt::format("{:.3g} mm long, {:.3g} mm wide, stroke {:.3g} mm, teeth every {:.3g} mm, {:.3g} mm deep edge",
                     tool.blade_length_mm, tool.blade_width_mm, tool.stroke_mm, tool.tooth_pitch_mm,
                     tool.edge_depth_mm);
}

std::vector<std::pair<const char*, double>> numbers(const Tool& tool) {
  return {{"length_mm", tool.blade_length_mm},
          {"width_mm", tool.blade_width_mm},
          {"tooth_pitch_mm", tool.tooth_pitch_mm},
          {"edge_depth_mm", tool.edge_depth_mm},
          {"stroke_mm", tool.stroke_mm}};
}

Mesh mesh(const Tool& tool, double) {
  const double half = 0.5 * tool.thickness_mm, set = tool.set_per_side_mm;
  const double height = gulletDepth(tool);
  Mesh mesh = prism({{height, 0},
                     {tool.blade_width_mm, 0},
                     {tool.blade_width_mm, tool.blade_length_mm},
                     {height, tool.blade_length_mm}},
                    -half, half, kSteelColor);

  const int teeth = static_cast<int>(std::floor(tool.blade_length_mm / tool.tooth_pitch_mm + 1e-9));
  for (int n = 0; n < teeth; ++n) {
    const double z = n * tool.tooth_pitch_mm;
    const bool left = n % 2 == 0;  // teeth lean to either side in turn
    append(mesh, prism({{height, z}, {0, z + 0.3 * tool.tooth_pitch_mm}, {height, z + tool.tooth_pitch_mm}},
                       left ? -half - set : -half, left ? half : half + set, kCuttingColor));
  }
  return mesh;
}

std::string drawing(const Tool& tool) {
  const double W = tool.blade_width_mm, L = tool.blade_length_mm;
  const double shown = std::min(L, std::max(12.0, 3 * W));
  Sheet sheet(W, shown, 230, 0);
  sheet.moveTo(150);

  const double depth = gulletDepth(tool);
  std::vector<Sheet::Point> teeth{{depth, 0}};
  for (int n = 0; (n + 1) * tool.tooth_pitch_mm <= shown + 1e-9; ++n) {
    teeth.emplace_back(0, (n + 0.3) * tool.tooth_pitch_mm);
    teeth.emplace_back(depth, (n + 1) * tool.tooth_pitch_mm);
  }
  sheet.polygon({{depth, 0}, {W, 0}, {W, shown}, {depth, shown}}, Sheet::kBody);
  sheet.polygon(teeth, Sheet::kCutting);

  sheet.tall(W, 0, shown, sheet.x(W) + 30, shown < L ? fmt::format("{} of {}", mm(shown), mm(L)) : mm(L));
  if (shown < L) sheet.breakLine(0, W, shown);
  sheet.wide(0, W, 0.75 * shown, 24, "width " + mm(W));
  return finishedBladeSheet(sheet, tool, fmt::format("stroke {} mm", mm(tool.stroke_mm)));
}

double way(const Tool& tool) { return tool.stroke_mm; }

double teeth(const Tool& tool) { return tool.tooth_pitch_mm > 0 ? tool.stroke_mm / tool.tooth_pitch_mm : 0; }

// Drag factor of reciprocating blades: oscillating saws in bone have a thrust of 1.4 to 1.8 times the cutting force
// (thesis, globethesis.com 2404330590467824); with the table's 0.3 alone it would be 3.3.
DriveNumbers reciprocatingDrive(const Tool& tool) {
  DriveNumbers out;
  // Micro saws 9 800 to 12 600 cycles a minute (J Biomech Eng 2014;136:034501); a longer stroke is a hand's, two cycles
  // a second.
  out.frequency_hz = tool.stroke_mm > 10 ? 2.0 : 12000.0 / 60;
  out.stall_load = 60;
  out.time_constant_s = 0.05;
  out.drag_factor = 2;
  return out;
}
DriveNumbers piezoDrive(const Tool&) {
  DriveNumbers out;
  out.frequency_hz = 29000;  // 24 to 36 kHz
  out.stall_load = 4.5;      // tangential: the pressed material damps the tip
  out.time_constant_s = 0.05;
  out.energy_factor = 16;  // a site of 2 mm, 10 mm deep, in 99 to 155 s (BMRI 2016:6473680): 0.2 to 0.3 mm^3/s
  out.drag_factor = 2;
  return out;
}

constexpr BladeMotion strokes(decltype(BladeMotion::name) name, decltype(BladeMotion::drive_keys) drive_keys,
                              decltype(BladeMotion::read) read_keys, decltype(BladeMotion::usual_drive) usual_drive) {
  return {.name = name,
          .also_called = "",
          .keys = kKeys,
          .drive_keys = drive_keys,
          .read = read_keys,
          .form = ToolMotion::kStroke,
          .plunge_volume = plunge,
          .edge_axis = 2,
          .describe = inWords,
          .numbers = numbers,
          .mesh = mesh,
          .drawing = drawing,
          .way = way,
          .teeth = teeth,
          .usual_drive = usual_drive};
}

}  // namespace

extern const BladeMotion kReciprocatingBlade, kPiezoBlade;

constinit const BladeMotion kReciprocatingBlade =
    strokes("reciprocating", kStrokes, readReciprocating, reciprocatingDrive);
constinit const BladeMotion kPiezoBlade = strokes("piezo", kMicroStrokes, readPiezo, piezoDrive);

}  // namespace kerf
