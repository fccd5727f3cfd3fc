#include "geometry/tool/tool_template.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/tool/handpiece.h"

namespace kerf {
namespace {

std::string tomlNumber(double value) {
  std::string text = fmt::format("{}", std::round(1000 * value) / 1000);
  if (text.find_first_of(".e") == text.npos) text += ".0";
  return text;
}

}  // namespace

std::string toolTemplate(const HeadShape& shape, const std::string& id) {
  constexpr double kDiameter = 1.6, kOverall = 19, kShank = 1.6;
  const auto row = [](const std::string& assignment, const std::string& meaning) {
    return fmt::format("{:<36} # {}\n", assignment, meaning);
  };

  std::string text = "# Lengths in mm; diameters, never radii. Say here where the numbers come from.\n";
  text += "format = \"kerf-tool\"\nversion = 1\n";
  text += row(fmt::format("id = \"{}\"", id), "the file's name without .toml");
  text += "name = \"My bur\"\ndescription = \"\"\nkind = \"bur\"\n";
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
      text += row("# " + assignment, fmt::format("{}; left out: {}", meaning, taken->unsaid));
    } else {
      numbers.*key.value = std::round(1000 * value) / 1000;
      text += row(assignment, meaning);
    }
  }

  if (shape.takes_profile) {
    text += "# [height above the tip, diameter]; a third number makes the way there an arc of that radius\n";
    text += "profile = [[0, 0.6], [0.5, 1.6, 0.5], [3, 1.6], [4, 1.0, -1.0]]\n";
    numbers.profile = {{0, 0.6, 0}, {0.5, 1.6, 0.5}, {3, 1.6, 0}, {4, 1.0, -1.0}};
  }

  const auto head = shape.build(numbers);  // the table's examples make heads: tested for every shape
  const double length = head ? head->highest() : 0;
  const double top = head ? head->clipped(0.95 * length, length).largestRadius() : 0;
  const double neck = std::clamp(std::floor(16 * top) / 10, 0.5, 1.2);

  text += row("# cuts = [\"end\"]", "[\"side\"] or [\"end\"] when not all of the head cuts ...");
  text += row("# end_length = 0.4", "... and up to where its end reaches");
  text += row(fmt::format("neck_diameter = {}", tomlNumber(neck)), "neck and shank collide, they do not cut");
  text += "neck_length = 2.0\n";
  text += row(fmt::format("shank_diameter = {}", tomlNumber(kShank)), "FG 1.6, RA and HP 2.35");
  text += row(fmt::format("shank_length = {}", tomlNumber(kOverall - 2 - length)), "19 mm in all");
  text += row("# iso6360 = \"806314198524016\"", "material, shank, shape, grit, head diameter in 1/10 mm");

  text += "# What turns it; left out: a training default for its kind and shank (kerf tool info shows it).\n";
  text += row("# [drive]", "at the end of the file");
  text += row("# handpiece = \"turbine\"", handpieceNames());
  text += row("# speed_rpm = 380000", "free, unloaded");
  text += row("# stall_torque_Nmm = 1", "what stops it");
  text += row("# time_constant_s = 0.32", "how fast speed follows");
  text += row("# energy_factor = 22", "cutting energy over the table's; left out: by the tool's material");
  text += row("# drag_factor = 1.33", "drag over the table's: diamond 1.33, carbide 1.67, saws 2");
  return text;
}

}  // namespace kerf
