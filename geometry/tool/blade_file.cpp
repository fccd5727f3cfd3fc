#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/tool/tool_kinds.h"

namespace kerf {
namespace {

// Teeth along x = 0, moving along z.
void readStraightBlade(TomlTable& top, Tool& tool) {
  const bool is_piezo = tool.motion == BladeMotion::kPiezo;
  tool.stroke_mm = is_piezo ? top.number("stroke", 0.02, 0.3) : top.number("stroke", 0, 40);
  tool.edge_depth_mm = top.numberOr("edge_depth", 0.5, 0.05, 10);
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

// Teeth along the tip, which is an arc about the pivot at z = L. A point of the blade at height z, W / 2 off its
// middle, comes W / 2 + (L - z) sin(angle / 2) away from it.
void readSagittalBlade(TomlTable& top, Tool& tool) {
  tool.swing_deg = top.number("swing", 0.1, 30, "degrees, from end to end");
  tool.edge_depth_mm = top.numberOr("edge_depth", 0.5, 0.05, 10);
  if (top.failed()) return;
  const double L = tool.blade_length_mm, half = 0.5 * tool.sweptWidth();
  if (half >= 0.9 * L) {
    top.reject("width", fmt::format("{}, which sweeps {:.4g} mm at the tip", tool.blade_width_mm, 2 * half),
               fmt::format("a blade whose tip sweeps less than 1.8 times its length, {:.4g} mm", 1.8 * L));
    return;
  }
  const double corner = L - std::sqrt(L * L - half * half);  // height of the tip's ends
  const auto outline = [&](double height) {
    const double sway = std::sin(0.5 * tool.swing_deg * std::numbers::pi / 180);
    RevolvedProfile profile;
    profile.arcTo({0, L}, {half, corner});
    return profile.lineTo(0.5 * tool.blade_width_mm + (L - height) * sway, height).close();
  };
  if (corner + tool.edge_depth_mm > L) {
    top.reject("edge_depth", fmt::format("{}", tool.edge_depth_mm),
               fmt::format("at most {:.3g} mm, up to the pivot", L - corner));
    return;
  }
  tool.cut = std::make_shared<const ExtrudedShape>(outline(corner + tool.edge_depth_mm), tool.kerfWidth());
  tool.body = std::make_shared<const ExtrudedShape>(outline(L), tool.thickness_mm);
}

void readDisc(TomlTable& top, Tool& tool) {
  const double diameter = top.number("diameter", 1, 100);
  const double shank = top.numberOr("shank_diameter", 0, 0.05, 50);
  const double shank_length = top.numberOr("shank_length", 0, 0.05, 200);
  if (top.has("shank_diameter") != top.has("shank_length"))
    top.reject(top.has("shank_diameter") ? "shank_diameter" : "shank_length", "stands alone",
               "both shank_diameter and shank_length, or neither");
  if (top.failed()) return;
  tool.head_diameter_mm = diameter;
  tool.head_length_mm = tool.kerfWidth();
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

struct Motion {
  const char* name;
  BladeMotion motion;
  void (*read)(TomlTable&, Tool&);
};
constexpr Motion kMotions[] = {
    {"reciprocating", BladeMotion::kReciprocating, readStraightBlade},
    {"piezo", BladeMotion::kPiezo, readStraightBlade},
    {"sagittal", BladeMotion::kSagittal, readSagittalBlade},
    {"spin", BladeMotion::kSpin, readDisc},
};

}  // namespace

void allowBladeKeys(TomlTable& top) {
  for (const char* key : {"motion", "thickness", "set_per_side", "width", "length", "stroke", "tooth_pitch",
                          "edge_depth", "swing", "diameter", "shank_diameter", "shank_length"})
    top.allow(key);
}

void readBlade(TomlTable& top, Tool& tool) {
  top.explain("set", "set_per_side: how far teeth stand out to either side, half of what the set adds to the kerf");
  top.explain("kerf", "thickness and set_per_side: kerf = thickness + 2 set_per_side");
  top.explain("pitch", "tooth_pitch");
  top.explain("tpi", "tooth_pitch = 25.4 / teeth per inch");
  top.explain("angle", "swing, from end to end, in degrees");
  top.explain("amplitude", "stroke, peak to peak, in mm");
  top.explain("radius", "diameter, which is twice the radius");
  for (const char* key : {"unit", "units"}) top.explain(key, "leave it out: lengths are in mm");
  const auto name = top.get<std::string>("motion", "how it moves: reciprocating, piezo, sagittal or spin");
  tool.thickness_mm = top.number("thickness", 0.05, 5);
  tool.set_per_side_mm = top.numberOr("set_per_side", 0.02, 0, 1);
  const auto motion =
      std::find_if(std::begin(kMotions), std::end(kMotions), [&](const Motion& m) { return name == m.name; });
  if (motion == std::end(kMotions)) {
    const std::string near =
        name == "oscillating" ? "sagittal" : nearestName(name, {"reciprocating", "piezo", "sagittal", "spin"});
    top.reject("motion", "\"" + name + "\"", "\"reciprocating\", \"piezo\", \"sagittal\" or \"spin\"", near);
    allowBladeKeys(top);
    return;
  }
  tool.motion = motion->motion;
  if (tool.motion != BladeMotion::kSpin) {
    tool.blade_width_mm = top.number("width", 0.2, 50);
    tool.blade_length_mm = top.number("length", 1, 150);
    tool.tooth_pitch_mm = top.number("tooth_pitch", 0.1, 10);
  }
  motion->read(top, tool);
}

}  // namespace kerf
