#include "ui/app/commands/import_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "preprocess/bake/trim_file.h"
#include "ui/app/commands/command_tables.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/imports.h"

namespace kerf::import_commands {
namespace {

using Way = ClosingChoice::Way;
constexpr std::array<std::pair<const char*, Way>, 4> kWays = {
    {{"automatic", Way::kAutomatic}, {"base", Way::kBase}, {"holes", Way::kHolesOnly}, {"wrap", Way::kWrap}}};

constexpr std::array<std::pair<const char*, ImportRole>, 4> kRoles = {{{"cut", ImportRole::kCut},
                                                                       {"beside", ImportRole::kBeside},
                                                                       {"out", ImportRole::kOut},
                                                                       {"tool", ImportRole::kTool}}};

tl::unexpected<Error> notAWord(const std::string& found, std::string expected) {
  return wrongWord(found.empty() ? "nothing" : "\"" + found + "\"", std::move(expected));
}

std::string importWordOf(AppWords words, std::size_t n) { return n < words.size() ? words[n] : std::string(); }

// The plan checks the range.
Expected<double> lengthOf(const std::string& word) {
  double value = 0;
  const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || failed != std::errc{} || end != word.data() + word.size())
    return notAWord(word, "a length in mm");
  return value;
}

bool isImporting(const AppContext& c) { return c.bench.imports->set() && !c.bench.jobs->running(); }
bool isImportingScan(const AppContext& c) { return isImporting(c) && c.bench.imports->set()->scan(); }
bool isImportingLabels(const AppContext& c) { return isImporting(c) && c.bench.imports->set()->labels(); }
bool isImportingSeveral(const AppContext& c) { return isImporting(c) && c.bench.imports->set()->isSeveral(); }
bool isImportingTool(const AppContext& c) { return isImporting(c) && c.bench.imports->set()->tool(); }

Expected<void> importRead(AppContext& c, AppWords words) {
  if (importWordOf(words, 0).empty()) return notAWord("", "the path of a scan");
  c.bench.imports->beginAll({words.begin(), words.end()});
  return {};
}

Expected<void> importAdd(AppContext& c, AppWords words) {
  if (importWordOf(words, 0).empty()) return notAWord("", "the path of a scan");
  c.bench.imports->addMore({words.begin(), words.end()});
  return {};
}

void stopDrawing(AppContext& c) { c.bench.imports->drawing.begin(TrimDrawing::What::kNothing); }

Expected<void> importChoose(AppContext& c, AppWords words) {
  stopDrawing(c);
  ImportSet& set = *c.bench.imports->set();
  KERF_TRY(n, numberOf(words, 0, "N", 1, static_cast<double>(set.entries().size())));
  set.choose(static_cast<std::size_t>(n) - 1);
  return {};
}

Expected<void> importRole(AppContext& c, AppWords words) {
  stopDrawing(c);
  ImportSet& set = *c.bench.imports->set();
  KERF_TRY(n, numberOf(words, 0, "N", 1, static_cast<double>(set.entries().size())));
  for (const auto& [name, role] : kRoles)
    if (importWordOf(words, 1) == name)
      return set.setRole(static_cast<std::size_t>(n) - 1, role, c.bench.document->isOpen());
  return notAWord(importWordOf(words, 1), "cut, beside, out or tool");
}

Expected<void> importToolAxis(AppContext& c, AppWords words) {
  if (importWordOf(words, 0).empty()) return notAWord("", "+x, -x, +y, -y, +z, -z, length, -length, thin-end or auto");
  return c.bench.imports->set()->tool()->setWay(words[0]);
}

Expected<void> importToolCut(AppContext& c, AppWords words) {
  KERF_TRY(mm, lengthOf(importWordOf(words, 0)));
  return c.bench.imports->set()->tool()->setCutBelow(mm);
}

Expected<void> importTissue(AppContext& c, AppWords words) {
  KERF_TRY(label, numberOf(words, 0, "LABEL", 1, 65535));
  if (importWordOf(words, 1).empty()) return notAWord("", "a tissue, or none");
  return c.bench.imports->set()->labels()->setTissue(static_cast<std::uint16_t>(label), words[1]);
}

Expected<void> importUnit(AppContext& c, AppWords words) {
  if (importWordOf(words, 0).empty()) return notAWord("", "mm, cm, m, um or inch");
  return c.bench.imports->plan()->setUnit(words[0]);
}

Expected<void> importClose(AppContext& c, AppWords words) {
  ClosingChoice choice = c.bench.imports->plan()->closing();
  for (const auto& [name, way] : kWays) {
    if (importWordOf(words, 0) != name) continue;
    choice.way = way;
    return c.bench.imports->plan()->setClosing(choice);
  }
  return notAWord(importWordOf(words, 0), "automatic, base, holes or wrap");
}

Expected<void> importBase(AppContext& c, AppWords words) {
  ClosingChoice choice = c.bench.imports->plan()->closing();
  const std::string shape = importWordOf(words, 0);
  if (shape != "horseshoe" && shape != "full") return notAWord(shape, "horseshoe or full");
  choice.is_full_base = shape == "full";
  if (words.size() > 1) {
    KERF_TRY(mm, lengthOf(words[1]));
    choice.base_mm = mm;
  }
  return c.bench.imports->plan()->setClosing(choice);
}

Expected<void> importSmooth(AppContext& c, AppWords words) {
  ClosingChoice choice = c.bench.imports->plan()->closing();
  KERF_TRY(mm, lengthOf(importWordOf(words, 0)));
  choice.smooth_mm = mm;
  return c.bench.imports->plan()->setClosing(choice);
}

Expected<void> importPlane(AppContext& c, AppWords words) {
  ClosingChoice choice = c.bench.imports->plan()->closing();
  const std::string word = importWordOf(words, 0);
  if (word != "on" && word != "off") return notAWord(word, "on or off");
  choice.follows_occlusal_plane = word == "on";
  return c.bench.imports->plan()->setClosing(choice);
}

Expected<void> importHoles(AppContext& c, AppWords words) {
  ClosingChoice choice = c.bench.imports->plan()->closing();
  choice.holes_up_to_mm.reset();
  if (importWordOf(words, 0) != "auto") {
    KERF_TRY(mm, lengthOf(importWordOf(words, 0)));
    choice.holes_up_to_mm = mm;
  }
  return c.bench.imports->plan()->setClosing(choice);
}

Expected<void> importWrap(AppContext& c, AppWords words) {
  ClosingChoice choice = c.bench.imports->plan()->closing();
  KERF_TRY(mm, lengthOf(importWordOf(words, 0)));
  choice.wrap_mm = mm;
  return c.bench.imports->plan()->setClosing(choice);
}

Expected<void> importVoxel(AppContext& c, AppWords words) {
  const ImportSet& set = *c.bench.imports->set();
  const auto setVoxel = [&](double mm) -> Expected<void> {
    if (set.scan()) return set.scan()->setVoxel(mm);
    if (set.labels()) return set.labels()->setVoxel(mm);
    return wrongWord("a " + set.entries()[set.chosen()].what(),
                     "a scan or labels; other files have a fixed voxel size");
  };
  if (importWordOf(words, 0) == "auto") return setVoxel(0);
  KERF_TRY(mm, lengthOf(importWordOf(words, 0)));
  if (mm == 0) return notAWord("0", "auto, or a length in mm");
  return setVoxel(mm);
}

// ---- Trims

bool canTrim(const AppContext& c) { return isImportingScan(c) && !isImportingTool(c); }
bool hasTrims(const AppContext& c) { return canTrim(c) && c.bench.imports->plan()->trimmed(); }
bool isDrawingTrims(const AppContext& c) { return canTrim(c) && c.bench.imports->drawing.isOn(); }

Expected<void> importTrim(AppContext& c, AppWords words) {
  using What = TrimDrawing::What;
  TrimDrawing& drawing = c.bench.imports->drawing;
  const std::string word = importWordOf(words, 0);
  if (word != "" && word != "lasso" && word != "line" && word != "off") return notAWord(word, "lasso, line or off");
  drawing.begin(word == "line" ? What::kLine : word == "off" ? What::kNothing : What::kLasso);
  return {};
}

Expected<void> importTrimStop(AppContext& c, AppWords) {
  stopDrawing(c);
  return {};
}

// Points of the focal plane under pixels: X1 Y1 X2 Y2 ...
Expected<std::vector<Vec3d>> focalPointsOf(const AppContext& c, AppWords words, std::size_t least, std::size_t most) {
  if (words.size() % 2 != 0 || words.size() < 2 * least || words.size() > 2 * most)
    return notAWord(
        std::to_string(words.size()) + " numbers",
        fmt::format("X Y of {} pixels", least == most ? std::to_string(least) : fmt::format("{} to {}", least, most)));
  std::vector<Vec3d> out;
  const Vec3d to_viewer = c.camera.backwards();
  for (std::size_t n = 0; n < words.size(); n += 2) {
    KERF_TRY(ray, rayOf(c, words, n));
    out.push_back(ray.at(to_viewer.dot(c.camera.target - ray.origin) / to_viewer.dot(ray.direction)));
  }
  return out;
}

std::optional<Vec3d> eyeOf(const Camera& camera) {
  if (!camera.isPerspective()) return {};
  return camera.target + camera.eyeDistance() * camera.backwards();
}

Expected<void> importTrimLasso(AppContext& c, AppWords words) {
  KERF_TRY(outline, focalPointsOf(c, words, 3, kMostCorners));
  return c.bench.imports->plan()->trim(OutlineTrim{std::move(outline), -c.camera.backwards(), eyeOf(c.camera)});
}

Expected<void> importTrimLine(AppContext& c, AppWords words) {
  KERF_TRY(ends, focalPointsOf(c, words, 2, 2));
  const auto eye = eyeOf(c.camera);
  const Vec3d sight = eye ? Vec3d(ends[0] - *eye) : Vec3d(-c.camera.backwards());
  const Vec3d normal = sight.cross(ends[1] - ends[0]);
  if (!(normal.norm() > 0)) return notAWord("a line without length", "two pixels apart");
  ImportPlan& plan = *c.bench.imports->plan();
  return plan.trim(plan.removingLess({ends[0], normal.normalized()}));
}

Expected<void> importTrimFlip(AppContext& c, AppWords) { return c.bench.imports->plan()->flipTrim(); }

Expected<void> importTrimUndo(AppContext& c, AppWords) {
  c.bench.imports->plan()->undoTrim();
  return {};
}

Expected<void> importTrimReset(AppContext& c, AppWords) { return c.bench.imports->plan()->setTrims({}); }

Expected<void> importTrimLoad(AppContext& c, AppWords words) {
  KERF_TRY(file, pathOf(words));
  KERF_TRY(trims, readTrims(file));
  return c.bench.imports->plan()->setTrims(std::move(trims));
}

Expected<void> importTrimRim(AppContext& c, AppWords words) {
  ClosingChoice choice = c.bench.imports->plan()->closing();
  KERF_TRY(mm, lengthOf(importWordOf(words, 0)));
  choice.trim_rim_mm = mm;
  return c.bench.imports->plan()->setClosing(choice);
}

Expected<void> importPreview(AppContext& c, AppWords) {
  if (PreviewedPlan* const plan = c.bench.imports->set()->plan()) plan->startPreview();
  return {};
}

Expected<void> importStart(AppContext& c, AppWords) {
  c.bench.imports->start();
  return {};
}

Expected<void> importCancel(AppContext& c, AppWords) {
  c.bench.imports->cancel();
  return {};
}

void addScan(nlohmann::json& j, const ImportPlan& plan) {
  const Vec3d size = plan.unit().size_mm;
  j["unit"] = plan.unit().unit;
  j["size_mm"] = {size[0], size[1], size[2]};
  j["is_plausible"] = plan.unit().is_plausible;
  j["is_closed"] = plan.check().isClosed();
  j["needs_base"] = plan.isWithoutUnderside();
  j["voxel_mm"] = plan.voxel();
  if (const TrimmedScan* const trimmed = plan.trimmed())
    j["cut_away"] = {{"cuts", plan.closing().trims.size()},
                     {"triangles", trimmed->triangles_removed},
                     {"vertices", trimmed->vertices_removed},
                     {"mm2", trimmed->removed_mm2}};
}

void addLabels(nlohmann::json& j, const LabelPlan& plan) {
  const Vec3d size = plan.found().box.size();
  j["size_mm"] = {size[0], size[1], size[2]};
  j["voxel_mm"] = plan.voxel();
  j["volume_mm3"] = plan.volumeMm3();
  for (const LabelFound& label : plan.found().labels) {
    const auto tissue = plan.tissue(label.label);
    j["labels"].push_back({{"label", label.label},
                           {"name", label.name},
                           {"volume_mm3", label.volume_mm3},
                           {"tissue", tissue ? plan.materials().find(*tissue)->id : "none"}});
  }
}

void addTool(nlohmann::json& j, const ToolPlan& plan) {
  const ToolWay& way = plan.way();
  j["tool"] = {{"id", plan.id()},
               {"way", way.name},
               {"axis", {way.axis[0], way.axis[1], way.axis[2]}},
               {"tip", {way.tip[0], way.tip[1], way.tip[2]}},
               {"tip_width_mm", way.tip_width_mm},
               {"cut_below_mm", plan.cutBelow()},
               {"is_doubtful", plan.isDoubtful()}};
}

void addPrediction(nlohmann::json& j, const Prediction& prediction) {
  j["predicted_s"] = prediction.seconds;
  j["predicted_bytes"] = prediction.bytes;
  j["predicted_triangles"] = prediction.surface_triangles;
}

const char* importNameOf(ImportRole role) {
  const auto row = std::find_if(kRoles.begin(), kRoles.end(), [&](const auto& r) { return r.second == role; });
  return row->first;
}

constexpr AppCommand kRows[] = {
    {"import.read", "", "", "", "PATH...",
     "Reads scans or label volumes and shows the findings before preparation. The first file is the object to cut, the "
     "others are neighbours. A single recipe, case or run opens at once.",
     when::isIdle, importRead},
    {"import.add", "File:2", "Add file to import...", "", "PATH",
     "Reads another file and adds it to the import as a neighbour.", isImporting, importAdd},
    {"import.choose", "", "", "", "N", "Shows the options of one of several files.", isImportingSeveral, importChoose},
    {"import.role", "", "", "", "N cut|beside|out|tool",
     "Sets the role of a file: object to cut, neighbour (beside), skipped (out), or a mesh as a tool of the rack. In "
     "an open session a single file can be a neighbour.",
     isImporting, importRole},
    {"import.tool-axis", "", "", "", "WAY",
     "Sets the direction from tip to shank of a mesh tool: +x, -x, +y, -y, +z, -z, length, -length, thin-end, or auto "
     "(the thinnest end is the tip).",
     isImportingTool, importToolAxis},
    {"import.tool-cut", "", "", "", "MM", "Sets the length of the cutting part above the tip, 0.1 to 50 mm.",
     isImportingTool, importToolCut},
    {"import.tissue", "", "", "", "LABEL TISSUE|none",
     "Sets the tissue of a CT label: an id of materials.toml, or none to skip the label.", isImportingLabels,
     importTissue},
    {"import.unit", "", "", "", "UNIT", "Sets the unit of the scan: mm, cm, m, um or inch.", isImportingScan,
     importUnit},
    {"import.close", "", "", "", "WAY", "Sets the closing method: automatic, base, holes or wrap.", isImportingScan,
     importClose},
    {"import.base", "", "", "", "SHAPE [MM]",
     "Sets the shape of the base, horseshoe or full, and its thickness below the scan (default 2 mm).", isImportingScan,
     importBase},
    {"import.smooth", "", "", "", "MM",
     "Smooths waves shorter than this length out of the walls of a horseshoe, 0 to 20 mm. 0: straight walls under the "
     "rim.",
     isImportingScan, importSmooth},
    {"import.trim-rim", "", "", "", "MM",
     "Removes tongues and flakes of the rim narrower than this before building the base, 0 to 10 mm. 0: none.",
     isImportingScan, importTrimRim},
    {"import.plane", "", "", "", "on|off", "Makes the base parallel to the occlusal plane.", isImportingScan,
     importPlane},
    {"import.holes", "", "", "", "MM|auto", "Fills holes up to this circumference. A longer boundary is a rim.",
     isImportingScan, importHoles},
    {"import.wrap", "", "", "", "MM", "Sets the largest gap that a wrap bridges.", isImportingScan, importWrap},
    {"import.voxel", "", "", "", "MM|auto", "Sets the voxel size, 0.02 to 0.5 mm.", isImporting, importVoxel},
    {"import.trim", "File:2", "Cut away part of scan", "", "[lasso|line|off]",
     "Cuts parts of the scan away before closing: the left button draws a line around a part, or across the scan.",
     canTrim, importTrim},
    {"import.trim-stop", "", "", "Esc", "", "Ends drawing such lines.", isDrawingTrims, importTrimStop},
    {"import.trim-lasso", "", "", "", "X1 Y1 X2 Y2 X3 Y3...",
     "Removes the part of the scan inside a closed line of pixels, through the whole scan along the view.", canTrim,
     importTrimLasso},
    {"import.trim-line", "", "", "", "X1 Y1 X2 Y2",
     "Removes the part of the scan on one side of a line through two pixels, along the view: the smaller part.",
     canTrim, importTrimLine},
    {"import.trim-flip", "", "", "", "", "Makes the last cut remove the other side.", hasTrims, importTrimFlip},
    {"import.trim-undo", "", "", "Ctrl+Z", "", "Takes the last cut of the scan back.", hasTrims, importTrimUndo},
    {"import.trim-reset", "", "", "", "", "Takes all cuts of the scan back.", hasTrims, importTrimReset},
    {"import.trim-load", "", "", "", "FILE",
     "Repeats the cuts of another import: a trim file, or a case with one (trim.toml).", canTrim, importTrimLoad},
    {"import.preview", "File:2", "Preview closed scan", "", "",
     "Closes the scan and shows the solid. For labels: shows the smooth surface of their tissues.", isImporting,
     importPreview},
    {"import.start", "File:2", "Prepare and cut", "Enter", "", "Prepares all files with these settings and opens them.",
     isImporting, importStart},
    {"import.cancel", "File:2", "Cancel import", "Esc", "", "Closes the import. The files stay unchanged.", isImporting,
     importCancel},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

bool isPreviewing(const AppContext& c) {
  const PreviewedPlan* const plan = isImporting(c) ? c.bench.imports->set()->plan() : nullptr;
  return plan && plan->isPreviewComing();
}

std::string importState(const ImportSet& set) {
  const ImportEntry& chosen = set.entries()[set.chosen()];
  nlohmann::json j{{"file", chosen.file.string()}, {"what", chosen.what()}, {"chosen", set.chosen() + 1}};
  if (set.scan()) addScan(j, *set.scan());
  if (set.labels()) addLabels(j, *set.labels());
  if (set.tool()) addTool(j, *set.tool());
  addPrediction(j, set.prediction());
  if (const ClosedPreview* const preview = set.preview()) {
    j["solid_mm3"] = preview->volume_mm3;
    j["solid_mm2"] = preview->area_mm2;
    j["is_exact"] = preview->is_exact;
    j["changes"] = preview->changes;
  }
  const auto add = [&](const Finding& finding) { j["found"].push_back(finding.about + ": " + finding.text); };
  if (set.scan())
    for (const Finding& finding : set.scan()->findings()) add(finding);
  if (set.labels())
    for (const Finding& finding : set.labels()->findings()) add(finding);
  if (set.tool())
    for (const Finding& finding : set.tool()->findings()) add(finding);
  for (const Finding& finding : set.findings()) add(finding);
  for (const ImportEntry& entry : set.entries())
    j["files"].push_back({{"file", entry.file.string()}, {"what", entry.what()}, {"role", importNameOf(entry.role)}});
  return j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace kerf::import_commands
