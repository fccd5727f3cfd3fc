#include <algorithm>
#include <vector>

#include "geometry/tool/blade_motion.h"
#include "geometry/tool/tool_kinds.h"

namespace kerf {
namespace {

// "reciprocating, piezo, sagittal or spin", each between `quote`s.
std::string namesOfMotions(const std::string& quote) {
  const auto motions = bladeMotions();
  std::string names;
  for (std::size_t n = 0; n < motions.size(); ++n)
    names += (n == 0 ? "" : n + 1 == motions.size() ? " or " : ", ") + quote + motions[n]->name + quote;
  return names;
}

// Most likely motion for an unknown word.
std::string motionMeant(const std::string& word) {
  std::vector<std::string> names;
  for (const BladeMotion* motion : bladeMotions()) {
    if (word == motion->also_called && !word.empty()) return motion->name;
    names.emplace_back(motion->name);
  }
  return nearestName(word, names);
}

// Common synonyms of the keys.
void explainWords(TomlTable& top) {
  top.explain("set", "set_per_side: set of the teeth to either side, half of its share of the kerf");
  top.explain("kerf", "thickness and set_per_side: kerf = thickness + 2 set_per_side");
  top.explain("pitch", "tooth_pitch");
  top.explain("tpi", "tooth_pitch = 25.4 / teeth per inch");
  top.explain("angle", "swing, from end to end, in degrees");
  top.explain("amplitude", "stroke, peak to peak, in mm");
  top.explain("radius", "diameter, which is twice the radius");
  for (const char* key : {"unit", "units"}) top.explain(key, "leave it out: lengths are in mm");
}

}  // namespace

void allowBladeKeys(TomlTable& top) {
  for (const char* key : {"motion", "thickness", "set_per_side"}) top.allow(key);
  for (const BladeMotion* motion : bladeMotions())
    for (const char* key : motion->keys) top.allow(key);
}

void readBlade(TomlTable& top, Tool& tool) {
  explainWords(top);
  const auto name = top.get<std::string>("motion", ("how it moves: " + namesOfMotions("")).c_str());
  tool.thickness_mm = top.number("thickness", 0.05, 5);
  tool.set_per_side_mm = top.numberOr("set_per_side", 0.02, 0, 1);

  tool.motion = findBladeMotion(name);
  if (tool.motion) return tool.motion->read(top, tool);
  top.reject("motion", "\"" + name + "\"", namesOfMotions("\""), motionMeant(name));
  allowBladeKeys(top);
}

}  // namespace kerf
