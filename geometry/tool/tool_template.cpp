#include "geometry/tool/tool_template.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "geometry/tool/handpiece.h"

namespace kerf {
namespace {

std::string tomlNumber(double value) {
  std::string text = fmt::format("{}", std::round(1000 * value) / 1000);
  if (text.find_first_of(".e") == text.npos) text += ".0";
  return text;
}

std::string row(const std::string& assignment, const std::string& meaning) {
  return fmt::format("{:<36} # {}\n", assignment, meaning);
}

// Head of every tool file.
std::string head(const std::string& id, const char* name, const char* kind) {
  return "# Lengths in mm; diameters, never radii. Note the source of the numbers here.\n"
         "format = \"kerf-tool\"\n"
         "version = 1\n" +
         row(fmt::format("id = \"{}\"", id), "the file's name without .toml") +
         fmt::format("name = \"{}\"\ndescription = \"\"\nkind = \"{}\"\n", name, kind);
}

// Meaning of the blade keys, with valid numbers.
struct BladeKey {
  const char* name;
  double example;
  double small;  // for a blade with a stroke of only a tenth of a millimetre
  const char* meaning;
};
constexpr BladeKey kBladeKeys[] = {
    {"diameter", 22, 22, "of the disc"},
    {"shank_diameter", 2.35, 2.35, "of the mandrel: it collides, it does not cut"},
    {"shank_length", 40, 40, "from the disc upwards"},
    {"width", 5, 4, "teeth to back; of a sagittal blade across"},
    {"length", 25, 8, "tip to clamp; of a sagittal blade tip to pivot"},
    {"stroke", 3, 0.1, "to and fro, from end to end"},
    {"swing", 4, 4, "degrees, from end to end"},
    {"tooth_pitch", 1, 1, "from tooth to tooth: drawn and heard"},
    {"edge_depth", 0.5, 0.4, "depth of the part that cuts"},
};

}  // namespace

std::string tomlVector(const Vec3d& v) {
  std::string out;
  for (int axis = 0; axis < 3; ++axis) {
    const double value = std::round(1e6 * v[axis]) / 1e6;
    std::string text = fmt::format("{}", value == 0 ? 0.0 : value);
    if (text.find_first_of(".e") == text.npos) text += ".0";
    out += (axis ? ", " : "") + text;
  }
  return "[" + out + "]";
}

std::string bladeTemplate(const BladeMotion& motion, const std::string& id) {
  std::string text = head(id, motion.form == ToolMotion::kSpin ? "My disc" : "My saw", "blade");
  text += row(fmt::format("motion = \"{}\"", motion.name), "how it moves");
  text += row("thickness = 0.4", "of the flanks, without set");
  text += row("set_per_side = 0.02", "set of the teeth to either side");
  const bool trembles = motion.form == ToolMotion::kStroke && std::string(motion.drive_keys.unit) == "kHz";
  for (const char* key : motion.keys)
    for (const BladeKey& known : kBladeKeys)
      if (std::string(key) == known.name)
        text += row(fmt::format("{} = {}", key, tomlNumber(trembles ? known.small : known.example)), known.meaning);

  text += "# Drive; default: training values for its motion (kerf tool info shows them).\n";
  text += row("# [drive]", "at the end of the file");
  text += row(fmt::format("# {} = ...", motion.drive_keys.speed), motion.drive_keys.unit);
  text += row(fmt::format("# {} = ...", motion.drive_keys.stall),
              fmt::format("stall load, {}", motion.drive_keys.stall_unit));
  return text;
}

std::string toolIdOf(std::string_view name) {
  std::string out;
  for (const char c : name) {
    const auto letter = static_cast<unsigned char>(c);
    if (letter < 128 && std::isalnum(letter))
      out += static_cast<char>(std::tolower(letter));
    else if (!out.empty() && out.back() != '-')
      out += '-';
  }
  while (!out.empty() && out.back() == '-') out.pop_back();
  return out;
}

std::string meshToolTemplate(const std::string& mesh, const std::string& id, const MeshToolNumbers& numbers) {
  std::string text = head(id, numbers.name.c_str(), "mesh");
  if (!numbers.origin.empty()) text += "# Made of " + numbers.origin + "\n";
  text += row(fmt::format("mesh = \"{}\"", mesh), "a closed mesh, in the folder of this file");
  text += row("mm_per_unit = " + tomlNumber(numbers.mm_per_unit), "25.4 of a file in inches, 1000 in metres");
  text += row("tip = " + tomlVector(numbers.tip), "the lowest point along the axis, in the mesh's own coordinates");
  text += row("axis = " + tomlVector(numbers.axis), "from the tip to the shank; the tool turns about this axis");
  text += row("cut_below = " + tomlNumber(numbers.cut_below_mm),
              "mm above the tip: up to there it cuts, above it collides");
  return text;
}

std::string toolTemplate(const HeadShape& shape, const std::string& id) {
  constexpr double kDiameter = 1.6, kOverall = 19, kShank = 1.6;
  std::string text = head(id, "My bur", "bur");
  text += row(fmt::format("shape = \"{}\"", shape.name), shape.outline);

  HeadNumbers numbers;
  for (const HeadKey& key : headKeys()) {
    const auto taken = std::find_if(shape.keys.begin(), shape.keys.end(),
                                    [&](const HeadShape::Key& k) { return std::string(k.name) == key.name; });
    const bool is_diameter = key.value == &HeadNumbers::head_diameter;
    if (!is_diameter && taken == shape.keys.end()) continue;

    const bool is_angle = std::string(key.unit) != "mm";
    const double value = is_diameter ? kDiameter : taken->example * (is_angle ? 1 : kDiameter);
    const std::string assignment = fmt::format("{} = {}", key.name, tomlNumber(value));
    const std::string meaning = is_angle ? fmt::format("{}, in {}", key.meaning, key.unit) : key.meaning;

    if (!is_diameter && taken->unsaid) {
      text += row("# " + assignment, fmt::format("{}; default: {}", meaning, taken->unsaid));
    } else {
      numbers.*key.value = std::round(1000 * value) / 1000;
      text += row(assignment, meaning);
    }
  }

  if (shape.takes_profile) {
    text += "# [height above the tip, diameter]; a third number makes the way there an arc of that radius\n";
    text += row("# profile_file = \"head.dxf\"", "in place of profile: a drawing, x the radius, y the height; or .svg");
    text += "profile = [[0, 0.6], [0.5, 1.6, 0.5], [3, 1.6], [4, 1.0, -1.0]]\n";
    numbers.profile = {{0, 0.6, 0}, {0.5, 1.6, 0.5}, {3, 1.6, 0}, {4, 1.0, -1.0}};
  }

  const auto built = shape.build(numbers);  // the table's examples make heads: tested for every shape
  const double length = built ? built->highest() : 0;
  const double top = built ? built->clipped(0.95 * length, length).largestRadius() : 0;
  const double neck = std::clamp(std::floor(16 * top) / 10, 0.5, 1.2);

  text += row("# cuts = [\"end\"]", "[\"side\"] or [\"end\"] when not all of the head cuts ...");
  text += row("# end_length = 0.4", "... and up to where its end reaches");
  text += row(fmt::format("neck_diameter = {}", tomlNumber(neck)), "neck and shank collide, they do not cut");
  text += "neck_length = 2.0\n";
  text += row(fmt::format("shank_diameter = {}", tomlNumber(kShank)), "FG 1.6, RA and HP 2.35");
  text += row(fmt::format("shank_length = {}", tomlNumber(kOverall - 2 - length)), "19 mm in all");
  text += row("# iso6360 = \"806314198524016\"", "material, shank, shape, grit, head diameter in 1/10 mm");

  text += "# Drive; default: training values for its kind and shank (kerf tool info shows them).\n";
  text += row("# [drive]", "at the end of the file");
  text += row("# handpiece = \"turbine\"", handpieceNames());
  text += row("# speed_rpm = 380000", "free, unloaded");
  text += row("# stall_torque_Nmm = 1", "stall torque");
  text += row("# time_constant_s = 0.32", "how fast speed follows");
  text += row("# energy_factor = 22", "cutting energy over the table's; default: by the tool's material");
  text += row("# drag_factor = 1.33", "drag over the table's: diamond 1.33, carbide 1.67, saws 2");
  return text;
}

}  // namespace kerf
