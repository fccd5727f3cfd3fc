// Discs: revolved about +z like a bur, 0 <= z <= kerf; they cut with their rim and plunge along -x.
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

constexpr const char* kKeys[] = {"diameter", "shank_diameter", "shank_length"};

void read(TomlTable& top, Tool& tool) {
  const double diameter = top.number("diameter", 1, 100);
  const double shank = top.numberOr("shank_diameter", 0, 0.05, 50);
  const double shank_length = top.numberOr("shank_length", 0, 0.05, 200);
  if (top.has("shank_diameter") != top.has("shank_length"))
    top.reject(top.has("shank_diameter") ? "shank_diameter" : "shank_length", "stands alone",
               "both shank_diameter and shank_length, or neither");
  if (top.failed()) return;

  tool.head_diameter_mm = diameter;
  tool.head_length_mm = tool.kerfWidth();
  tool.shank_diameter_mm = shank;
  tool.cuts_end = false;
  const double r = 0.5 * diameter;
  tool.head = tool.cutting =
      std::make_shared<const RevolvedProfile>(RevolvedProfile().lineTo(r, 0).lineTo(r, tool.kerfWidth()).close());
  tool.cut = std::make_shared<const RevolvedShape>(*tool.cutting);
  if (shank > 0) {
    RevolvedProfile mandrel(tool.kerfWidth());
    tool.body_outlines.push_back(
        mandrel.lineTo(0.5 * shank, mandrel.end()[1]).lineTo(0.5 * shank, tool.kerfWidth() + shank_length).close());
    tool.body = std::make_shared<const RevolvedShape>(tool.body_outlines.back());
  }
  tool.plunge_direction = -Vec3d::UnitX();
}

double plunge(const Tool& tool, double depth_mm, double window_mm) {
  const double radius = 0.5 * tool.head_diameter_mm;
  return tool.kerfWidth() * pushedCircle(radius, radius - depth_mm, 0.5 * std::min(window_mm, tool.head_diameter_mm));
}

std::string inWords(const Tool& tool) { return fmt::format("disc of {:.3g} mm", tool.head_diameter_mm); }

std::vector<std::pair<const char*, double>> numbers(const Tool& tool) {
  return {{"diameter_mm", tool.head_diameter_mm}};
}

std::string drawing(const Tool& tool) {
  return drawRevolved(tool, fmt::format("{}, disc, kerf {} mm, set {} mm per side", tool.id, mm(tool.kerfWidth()),
                                        mm(tool.set_per_side_mm)));
}

double way(const Tool&) { return 2 * std::numbers::pi; }

double teeth(const Tool& tool) {
  return tool.tooth_pitch_mm > 0 ? std::round(std::numbers::pi * tool.head_diameter_mm / tool.tooth_pitch_mm) : 0;
}

DriveNumbers usualDrive(const Tool&) { return {}; }

}  // namespace

extern const BladeMotion kDiscBlade;

constinit const BladeMotion kDiscBlade{.name = "spin",
                                       .also_called = "",
                                       .keys = kKeys,
                                       .drive_keys = kTurns,
                                       .read = read,
                                       .form = ToolMotion::kSpin,
                                       .plunge_volume = plunge,
                                       .edge_axis = 1,
                                       .describe = inWords,
                                       .numbers = numbers,
                                       .mesh = revolvedMesh,
                                       .drawing = drawing,
                                       .way = way,
                                       .teeth = teeth,
                                       .usual_drive = usualDrive};

}  // namespace kerf
