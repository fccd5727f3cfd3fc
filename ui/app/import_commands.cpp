#include "ui/app/import_commands.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

namespace kerf {
namespace {

using Way = ClosingChoice::Way;
constexpr std::array<std::pair<const char*, Way>, 4> kWays = {
    {{"automatic", Way::kAutomatic}, {"base", Way::kBase}, {"holes", Way::kHolesOnly}, {"wrap", Way::kWrap}}};

tl::unexpected<Error> notAWord(const std::string& found, std::string expected) {
  return wrongWord(found.empty() ? "nothing" : "\"" + found + "\"", std::move(expected));
}

std::string wordOf(AppWords words, std::size_t n) { return n < words.size() ? words[n] : std::string(); }

// The plan checks the range.
Expected<double> lengthOf(const std::string& word) {
  double value = 0;
  const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || failed != std::errc{} || end != word.data() + word.size())
    return notAWord(word, "a length in mm");
  return value;
}

}  // namespace

bool isImporting(const AppContext& c) { return c.bench.importPlan() && !c.bench.job(); }

bool isPreviewing(const AppContext& c) {
  const ImportPlan* const plan = c.bench.importPlan();
  return plan && !c.bench.job() && plan->isPreviewComing();
}

Expected<void> importRead(AppContext& c, AppWords words) {
  if (wordOf(words, 0).empty()) return notAWord("", "the path of a scan");
  c.bench.beginImport(std::filesystem::path(words[0]));
  return {};
}

Expected<void> importUnit(AppContext& c, AppWords words) {
  if (wordOf(words, 0).empty()) return notAWord("", "mm, cm, m, um or inch");
  return c.bench.importPlan()->setUnit(words[0]);
}

Expected<void> importClose(AppContext& c, AppWords words) {
  ClosingChoice choice = c.bench.importPlan()->closing();
  for (const auto& [name, way] : kWays) {
    if (wordOf(words, 0) != name) continue;
    choice.way = way;
    return c.bench.importPlan()->setClosing(choice);
  }
  return notAWord(wordOf(words, 0), "automatic, base, holes or wrap");
}

Expected<void> importBase(AppContext& c, AppWords words) {
  ClosingChoice choice = c.bench.importPlan()->closing();
  const std::string shape = wordOf(words, 0);
  if (shape != "horseshoe" && shape != "full") return notAWord(shape, "horseshoe or full");
  choice.is_full_base = shape == "full";
  if (words.size() > 1) {
    KERF_TRY(mm, lengthOf(words[1]));
    choice.base_mm = mm;
  }
  return c.bench.importPlan()->setClosing(choice);
}

Expected<void> importSmooth(AppContext& c, AppWords words) {
  ClosingChoice choice = c.bench.importPlan()->closing();
  KERF_TRY(mm, lengthOf(wordOf(words, 0)));
  choice.smooth_mm = mm;
  return c.bench.importPlan()->setClosing(choice);
}

Expected<void> importPlane(AppContext& c, AppWords words) {
  ClosingChoice choice = c.bench.importPlan()->closing();
  const std::string word = wordOf(words, 0);
  if (word != "on" && word != "off") return notAWord(word, "on or off");
  choice.follows_occlusal_plane = word == "on";
  return c.bench.importPlan()->setClosing(choice);
}

Expected<void> importHoles(AppContext& c, AppWords words) {
  ClosingChoice choice = c.bench.importPlan()->closing();
  choice.holes_up_to_mm.reset();
  if (wordOf(words, 0) != "auto") {
    KERF_TRY(mm, lengthOf(wordOf(words, 0)));
    choice.holes_up_to_mm = mm;
  }
  return c.bench.importPlan()->setClosing(choice);
}

Expected<void> importWrap(AppContext& c, AppWords words) {
  ClosingChoice choice = c.bench.importPlan()->closing();
  KERF_TRY(mm, lengthOf(wordOf(words, 0)));
  choice.wrap_mm = mm;
  return c.bench.importPlan()->setClosing(choice);
}

Expected<void> importVoxel(AppContext& c, AppWords words) {
  if (wordOf(words, 0) == "auto") return c.bench.importPlan()->setVoxel(0);
  KERF_TRY(mm, lengthOf(wordOf(words, 0)));
  if (mm == 0) return notAWord("0", "auto, or a length in mm");
  return c.bench.importPlan()->setVoxel(mm);
}

Expected<void> importPreview(AppContext& c, AppWords) {
  c.bench.importPlan()->startPreview();
  return {};
}

Expected<void> importStart(AppContext& c, AppWords) {
  c.bench.startImport();
  return {};
}

Expected<void> importCancel(AppContext& c, AppWords) {
  c.bench.cancelImport();
  return {};
}

std::string importState(const ImportPlan& plan) {
  const Vec3d size = plan.unit().size_mm;
  const Prediction prediction = plan.prediction();
  nlohmann::json j{{"file", plan.found().file.string()},
                   {"unit", plan.unit().unit},
                   {"size_mm", {size[0], size[1], size[2]}},
                   {"is_plausible", plan.unit().is_plausible},
                   {"is_closed", plan.found().check.isClosed()},
                   {"needs_base", plan.isWithoutUnderside()},
                   {"voxel_mm", plan.voxel()},
                   {"predicted_s", prediction.seconds},
                   {"predicted_bytes", prediction.bytes},
                   {"predicted_triangles", prediction.surface_triangles}};
  if (const ClosedPreview* const preview = plan.preview()) {
    j["solid_mm3"] = preview->volume_mm3;
    j["solid_mm2"] = preview->area_mm2;
    j["is_exact"] = preview->is_exact;
    j["changes"] = preview->changes;
  }
  for (const Finding& finding : plan.findings()) j["found"].push_back(finding.about + ": " + finding.text);
  return j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace kerf
