#include "preprocess/print/print_plan.h"

#include <fmt/format.h>

#include <algorithm>

#include "geometry/base/toml_reader.h"
#include "preprocess/voxelize/voxelize.h"

namespace kerf {
namespace {

constexpr std::size_t kMostSteps = 50;
constexpr double kLeastLabelHeight = 0.5, kMostLabelHeight = 100, kLeastLabelDepth = 0.05,
                 kMostLabelDepth = 10;  // mm, of a label

// A word of a fixed list, as an index.
std::size_t wordOf(TomlTable& t, const char* key, std::initializer_list<const char*> words) {
  std::string expected;
  for (const char* word : words) expected += fmt::format("{}\"{}\"", expected.empty() ? "" : ", ", word);
  const auto found = t.getOr<std::string>(key, *words.begin(), expected.c_str());
  std::size_t n = 0;
  for (const char* word : words) {
    if (found == word) return n;
    ++n;
  }
  if (!t.failed()) t.reject(key, "\"" + found + "\"", expected);
  return 0;
}

HollowOptions readHollow(TomlTable& t) {
  HollowOptions out;
  out.wall_mm = t.numberOr("wall", out.wall_mm, kLeastWall, kMostWall);
  out.rounding_mm = t.numberOr("rounding", out.rounding_mm, 0, kMostWall);
  if (t.has("voxel")) out.voxel_mm = t.number("voxel", kSmallestVoxel, 0.25 * out.wall_mm);
  t.allow("voxel");
  out.least_cavity_mm3 = t.numberOr("least_cavity", out.least_cavity_mm3, 0, 1e6, "mm3");
  return out;
}

DrainOptions readDrain(TomlTable& t) {
  DrainOptions out;
  out.diameter_mm = t.numberOr("diameter", out.diameter_mm, RoundHole::kLeastDiameter, RoundHole::kMostDiameter);
  const auto count = t.getOr<std::int64_t>("count", static_cast<std::int64_t>(out.count), "a whole number");
  if (!t.failed() && (count < 1 || count > static_cast<std::int64_t>(kMostDrains)))
    t.reject("count", fmt::format("{}", count), fmt::format("1 to {}", kMostDrains));
  out.count = static_cast<std::size_t>(std::max<std::int64_t>(count, 1));
  out.side = wordOf(t, "side", {"underside", "nearest"}) == 0 ? DrainSide::kUnderside : DrainSide::kNearestWall;
  if (t.has("at")) out.at = t.points("at");
  t.allow("at");
  return out;
}

LabelStep readLabel(TomlTable& t) {
  LabelStep out;
  out.label.text = t.get<std::string>("text", "a text, such as \"{case}\"");
  out.face = wordOf(t, "on", {"underside", "side"}) == 0 ? LabelFace::kUnderside : LabelFace::kSide;
  out.label.height_mm = t.numberOr("height", out.label.height_mm, kLeastLabelHeight, kMostLabelHeight);
  out.label.depth_mm = t.numberOr("depth", out.label.depth_mm, kLeastLabelDepth, kMostLabelDepth);
  out.label.embossed = t.getOr<bool>("embossed", out.label.embossed, "true or false");
  return out;
}

Expected<PrintStep> readStep(const toml::table& table, const std::filesystem::path& file, std::size_t number) {
  TomlTable t(table, file, fmt::format("step {}", number));
  PrintStep out;
  const auto what = t.get<std::string>("do", "\"hollow\", \"drain\" or \"label\"");
  if (what == "hollow")
    out = readHollow(t);
  else if (what == "drain")
    out = readDrain(t);
  else if (what == "label")
    out = readLabel(t);
  else if (!t.failed())
    t.reject("do", "\"" + what + "\"", "\"hollow\", \"drain\" or \"label\"");
  KERF_CHECK(t.finish());
  return out;
}

}  // namespace

Expected<PrintPlan> readPrintPlan(const std::filesystem::path& file) {
  KERF_TRY(root, parseToml(file));
  TomlTable top(root, file, "");
  const auto format = top.get<std::string>("format", "\"kerf-print\"");
  if (!top.failed() && format != "kerf-print") top.reject("format", "\"" + format + "\"", "\"kerf-print\"");
  const auto version = top.get<std::int64_t>("version", "1");
  if (!top.failed() && version != 1) top.reject("version", fmt::format("{}", version), "1");
  PrintPlan out;
  if (top.has("up")) {
    const auto n = top.numbers("up", 3);
    const Vec3d up = top.failed() ? Vec3d::UnitZ() : Vec3d(n[0], n[1], n[2]);
    if (!top.failed() && !(up.norm() > 1e-9 && up.norm() < 1e9))
      top.reject("up", "no direction", "a direction that is not zero, as [0, 0, 1]");
    out.up = up.stableNormalized();
  }
  top.allow("up");
  out.to_bed = top.getOr<std::string>("to_bed", "", "the name of a printer");
  const toml::array* const steps = top.tables("step");
  if (!top.failed() && steps->size() > kMostSteps)
    top.reject("step", fmt::format("{} of them", steps->size()), fmt::format("at most {}", kMostSteps));
  KERF_CHECK(top.finish());
  for (const toml::node& node : *steps) {
    KERF_TRY(step, readStep(*node.as_table(), file, out.steps.size() + 1));
    out.steps.push_back(std::move(step));
  }
  return out;
}

}  // namespace kerf
