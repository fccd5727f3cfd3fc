// Blades that swing about a pivot at z = L: teeth along the tip, an arc about the pivot; they cut towards -z.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/tool/blade_parts.h"
#include "geometry/tool/plunge.h"
#include "geometry/tool/tool_mesh.h"

namespace kerf {
namespace {

using namespace internal;

constexpr const char* kKeys[] = {"width", "length", "swing", "tooth_pitch", "edge_depth"};
constexpr DriveKeys kSwings{"cycles_per_min", 10, 1e5, 1.0 / 60, "cycles/min", "stall_torque_Nmm", "N mm"};

// A point of the blade at height z, W / 2 off its middle, comes W / 2 + (L - z) sin(angle / 2) away from it.
RevolvedProfile sweptOutline(const Tool& tool, double corner, double height) {
  const double L = tool.blade_length_mm, half = 0.5 * tool.sweptWidth();
  const double sway = std::sin(0.5 * tool.swing_deg * std::numbers::pi / 180);
  RevolvedProfile profile;
  profile.arcTo({0, L}, {half, corner});
  return profile.lineTo(0.5 * tool.blade_width_mm + (L - height) * sway, height).close();
}

void read(TomlTable& top, Tool& tool) {
  readToothedBlade(top, tool);
  tool.swing_deg = top.number("swing", 0.1, 30, "degrees, from end to end");
  readEdgeDepth(top, tool);
  if (top.failed()) return;

  const double L = tool.blade_length_mm, half = 0.5 * tool.sweptWidth();
  if (half >= 0.9 * L) {
    top.reject("width", fmt::format("{}, which sweeps {:.4g} mm at the tip", tool.blade_width_mm, 2 * half),
               fmt::format("a blade whose tip sweeps less than 1.8 times its length, {:.4g} mm", 1.8 * L));
    return;
  }
  const double corner = L - std::sqrt(L * L - half * half);  // height of the tip's ends
  if (corner + tool.edge_depth_mm > L) {
    top.reject("edge_depth", fmt::format("{}", tool.edge_depth_mm),
               fmt::format("at most {:.3g} mm, up to the pivot", L - corner));
    return;
  }

  tool.cut =
      std::make_shared<const ExtrudedShape>(sweptOutline(tool, corner, corner + tool.edge_depth_mm), tool.kerfWidth());
  tool.body = std::make_shared<const ExtrudedShape>(sweptOutline(tool, corner, L), tool.thickness_mm);
}

double plunge(const Tool& tool, double depth_mm, double window_mm) {
  return tool.kerfWidth() * pushedCircle(tool.blade_length_mm, tool.blade_length_mm - depth_mm,
                                         0.5 * std::min(window_mm, tool.sweptWidth()));
}

std::string inWords(const Tool& tool) {
  return fmt::format(
      "{:.3g} mm long, {:.3g} mm wide, swings by {:.3g} degrees: {:.3g} mm at the tip, teeth every {:.3g} mm, {:.3g} "
      "mm deep edge",
      tool.blade_length_mm, tool.blade_width_mm, tool.swing_deg, tool.sweptWidth(), tool.tooth_pitch_mm,
      tool.edge_depth_mm);
}

std::vector<std::pair<const char*, double>> numbers(const Tool& tool) {
  return {{"length_mm", tool.blade_length_mm},     {"width_mm", tool.blade_width_mm},
          {"tooth_pitch_mm", tool.tooth_pitch_mm}, {"edge_depth_mm", tool.edge_depth_mm},
          {"swing_deg", tool.swing_deg},           {"swept_width_mm", tool.sweptWidth()}};
}

// Height of the arc about the pivot, `x` off the middle.
double arcAt(const Tool& tool, double x) {
  const double L = tool.blade_length_mm;
  return L - std::sqrt(L * L - x * x);
}

int teethInDrawing(const Tool& tool) {
  return std::max(1, static_cast<int>(std::floor(tool.blade_width_mm / tool.tooth_pitch_mm + 1e-9)));
}

// At rest, in the middle of its swing; teeth end on the arc about the pivot.
Mesh mesh(const Tool& tool, double) {
  const double half = 0.5 * tool.thickness_mm, set = tool.set_per_side_mm, L = tool.blade_length_mm;
  const double side = 0.5 * tool.blade_width_mm;
  const double base = arcAt(tool, side) + gulletDepth(tool);
  Mesh mesh = prism({{-side, base}, {side, base}, {side, L}, {-side, L}}, -half, half, kSteelColor);

  const int teeth = teethInDrawing(tool);
  for (int n = 0; n < teeth; ++n) {
    const double left = side * (2.0 * n / teeth - 1), right = side * (2.0 * (n + 1) / teeth - 1);
    const double tip = 0.5 * (left + right);
    const bool leans = n % 2 == 0;
    append(mesh, prism({{left, base}, {tip, arcAt(tool, tip)}, {right, base}}, leans ? -half - set : -half,
                       leans ? half : half + set, kCuttingColor));
  }
  return mesh;
}

// The envelope of the teeth, dashed.
std::vector<Sheet::Point> envelope(const Tool& tool, double low_x, double high_x) {
  std::vector<Sheet::Point> swept;
  for (int n = 0; n <= 40; ++n) {
    const double x = low_x * (1 - n / 20.0);
    swept.emplace_back(x, arcAt(tool, x));
  }
  const double corner = arcAt(tool, high_x) + tool.edge_depth_mm;
  swept.emplace_back(high_x, corner);
  swept.emplace_back(low_x, corner);
  return swept;
}

std::string drawing(const Tool& tool) {
  const double W = tool.blade_width_mm, L = tool.blade_length_mm, side = 0.5 * W;
  const double low_x = -0.5 * tool.sweptWidth(), high_x = -low_x;
  const double shown = std::min(L, std::max(12.0, 3 * (high_x - low_x)));
  Sheet sheet(high_x - low_x, shown, 230, 0);
  sheet.moveTo(150 - sheet.scale() * low_x);

  const double base = arcAt(tool, side) + gulletDepth(tool);
  const int count = teethInDrawing(tool);
  std::vector<Sheet::Point> teeth{{-side, base}};
  for (int n = 0; n < count; ++n) {
    const double a = side * (2.0 * n / count - 1), b = side * (2.0 * (n + 1) / count - 1);
    teeth.emplace_back(0.5 * (a + b), arcAt(tool, 0.5 * (a + b)));
    teeth.emplace_back(b, base);
  }
  sheet.polygon(envelope(tool, low_x, high_x), "#f7ead0", "stroke-dasharray=\"5 4\"");
  sheet.polygon({{-side, base}, {side, base}, {side, shown}, {-side, shown}}, Sheet::kBody);
  sheet.polygon(teeth, Sheet::kCutting);
  sheet.centreLine(0, shown);

  sheet.tall(side, 0, shown, sheet.x(high_x) + 30, shown < L ? fmt::format("{} of {}", mm(shown), mm(L)) : mm(L));
  if (shown < L) sheet.breakLine(low_x, high_x, shown);
  sheet.wide(-side, side, 0.75 * shown, 24, "width " + mm(W));
  sheet.wide(low_x, high_x, 0.02 * shown, 24, "sweeps " + mm(tool.sweptWidth()));
  return finishedBladeSheet(sheet, tool, fmt::format("swing {} degrees", mm(tool.swing_deg)));
}

double way(const Tool& tool) { return tool.swing_deg * std::numbers::pi / 180; }

double teeth(const Tool& tool) {
  return tool.tooth_pitch_mm > 0 ? way(tool) * tool.blade_length_mm / tool.tooth_pitch_mm : 0;
}

DriveNumbers usualDrive(const Tool&) {
  DriveNumbers out;
  out.frequency_hz = 15000 / 60.0;  // 5 000 to 20 000 cycles a minute
  out.stall_load = 1500;
  out.time_constant_s = 0.05;
  out.drag_factor = 2;  // as for reciprocating saws
  return out;
}

}  // namespace

extern const BladeMotion kSagittalBlade;

constinit const BladeMotion kSagittalBlade{.name = "sagittal",
                                           .also_called = "oscillating",
                                           .keys = kKeys,
                                           .drive_keys = kSwings,
                                           .read = read,
                                           .form = ToolMotion::kSwing,
                                           .plunge_volume = plunge,
                                           .edge_axis = -1,
                                           .describe = inWords,
                                           .numbers = numbers,
                                           .mesh = mesh,
                                           .drawing = drawing,
                                           .way = way,
                                           .teeth = teeth,
                                           .usual_drive = usualDrive};

}  // namespace kerf
