// kerf prepare: a solid made ready for a printer by the steps of a plan.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <filesystem>
#include <map>
#include <memory>
#include <utility>

#include "geometry/base/assets.h"
#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_writer.h"
#include "preprocess/print/prepare.h"
#include "preprocess/unit/unit.h"
#include "ui/cli/command.h"
#include "ui/cli/solid_source.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kUsualPlan = "print/model.toml";

struct PrepareArguments {
  std::string what, plan, bed, unit;
  std::vector<std::string> outputs, words;
  bool overwrites = false, json = false;
};

// "tooth=36" for the placeholder {tooth}.
Expected<std::map<std::string, std::string>> wordsOf(const PrepareArguments& a, const std::string& name) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  std::map<std::string, std::string> out{{"case", name}, {"date", fmt::format("{:%Y-%m-%d}", local)}};
  for (const std::string& word : a.words) {
    const std::size_t at = word.find('=');
    if (at == 0 || at == word.npos)
      return fail({.code = Error::Code::kBadValue,
                   .place = "--word",
                   .found = "\"" + word + "\"",
                   .expected = "NAME=TEXT for the placeholder {NAME}",
                   .hint = "--word tooth=36"});
    out[word.substr(0, at)] = word.substr(at + 1);
  }
  return out;
}

Expected<PrintPlan> planOf(const PrepareArguments& a) {
  if (!a.plan.empty()) return readPrintPlan(a.plan);
  const auto found = findAssets(kUsualPlan);
  if (!found.empty()) return readPrintPlan(found.front());
  return fail({.code = Error::Code::kNotFound,
               .file = kUsualPlan,
               .found = "no such file in Kerf's data",
               .expected = "the usual plan",
               .hint = "--plan FILE, or install Kerf again"});
}

json pointJson(const Vec3d& p) { return {p[0], p[1], p[2]}; }

const char* nameOfPocket(PocketKind kind) {
  return kind == PocketKind::kSealed ? "sealed" : kind == PocketKind::kPool ? "pool" : "cup";
}

json prepareJson(const SolidSource& source, const Prepared& result, const std::vector<std::string>& files) {
  json steps = json::array(), pockets = json::array(), laid = json::array();
  for (const LaidPiece& piece : result.laid) {
    const Rigid3& T = piece.T_bed_scan;
    laid.push_back({{"rotation_wxyz", {T.rotation.w(), T.rotation.x(), T.rotation.y(), T.rotation.z()}},
                    {"translation_mm", pointJson(T.translation)},
                    {"size_mm", pointJson(piece.size_mm)},
                    {"on_base", piece.is_on_base}});
  }
  for (const StepReport& step : result.steps)
    steps.push_back(
        {{"do", step.step}, {"summary", step.summary}, {"numbers", step.numbers}, {"warnings", step.warnings}});
  for (const Pocket& pocket : result.pockets.pockets) {
    json j{{"kind", nameOfPocket(pocket.kind)},
           {"volume_mm3", pocket.volume_mm3},
           {"area_mm2", pocket.area_mm2},
           {"depth_mm", pocket.depth_mm},
           {"deepest_mm", pointJson(pocket.deepest)},
           {"closed_by_plate", pocket.is_closed_by_plate}};
    if (pocket.spill) j["spill_mm"] = pointJson(*pocket.spill);
    pockets.push_back(std::move(j));
  }
  json j{{"files", files},
         {"up", pointJson(result.up)},
         {"on_plate", result.on_plate},
         {"frame", result.laid.empty() ? "scan" : "bed"},  // of up and pockets; the steps' places are the scan's
         {"laid", std::move(laid)},
         {"steps", std::move(steps)},
         {"pockets", std::move(pockets)},
         {"small_pockets", result.pockets.small},
         {"small_pockets_mm3", result.pockets.small_mm3},
         {"source_mm3", result.source_mm3},
         {"resin_mm3", result.resin_mm3},
         {"source_vertices", source.solid.vertices.size()},
         {"source_vertices_kept", result.source_vertices_kept}};
  if (!source.note.empty()) j["note"] = source.note;
  return j;
}

void printPrepared(const SolidSource& source, const Prepared& result, const std::vector<std::string>& files) {
  for (std::size_t n = 0; n < result.steps.size(); ++n) {
    const StepReport& step = result.steps[n];
    printText("{}. {}: {}\n", n + 1, step.step, step.summary);
    for (const std::string& warning : step.warnings) printText("   WARNING: {}\n", warning);
  }
  printText("resin: {:.2f} ml, {:.0f} % of {:.2f} ml; {} of {} vertices of the solid kept bit for bit{}\n",
            1e-3 * result.resin_mm3, 100 * result.resin_mm3 / result.source_mm3, 1e-3 * result.source_mm3,
            result.source_vertices_kept, source.solid.vertices.size(),
            result.laid.empty() ? "" : ", until it was laid on the bed");
  printText("printed along {:.3f},{:.3f},{:.3f}, {}\n", result.up[0], result.up[1], result.up[2],
            result.on_plate ? "flat on the plate" : "on supports");
  for (const LaidPiece& piece : result.laid)
    printText("on the bed: {:.1f} x {:.1f} mm, {:.1f} mm high, {}\n", piece.size_mm[0], piece.size_mm[1],
              piece.size_mm[2], piece.is_on_base ? "on its base" : "upright, without a base");
  if (result.pockets.pockets.empty()) printText("no trapped resin and no suction cup\n");
  for (const Pocket& pocket : result.pockets.pockets) printText("WARNING: {}\n", describe(pocket));
  constexpr double kFew = 5;  // mm^3
  if (result.pockets.small_mm3 > kFew)
    printText("small pockets, such as letters: {}, {:.1f} mm3 together\n", result.pockets.small,
              result.pockets.small_mm3);
  for (const std::string& file : files) printText("written: {}\n", file);
}

Expected<void> prepare(const PrepareArguments& a) {
  for (const std::string& path : a.outputs) KERF_CHECK(canWriteMesh(path));
  KERF_TRY(plan, planOf(a));
  if (!a.bed.empty()) plan.to_bed = a.bed;
  KERF_TRY(source, readSolid(a.what, a.unit));
  KERF_TRY(words, wordsOf(a, source.name));
  for (const std::string& path : a.outputs) {
    KERF_CHECK(requireNotInput(a.what, path));
    KERF_CHECK(requireFree(path, a.overwrites));
  }
  auto result = [&] {
    TerminalProgress progress;
    return prepareForPrint(source.solid, plan, words, progress.callback());
  }();
  if (!result) {
    if (result.error().file.empty()) result.error().file = a.what;
    return fail(std::move(result).error());
  }

  const TerminalProgress guard;  // Ctrl-C waits for complete files
  for (const std::string& path : a.outputs) {
    const NamedMesh named = source.names.grouped(result->mesh, path);
    KERF_CHECK(writeMesh(path, named.mesh, {.objects = named.objects}));
  }
  if (!source.note.empty()) printText(stderr, "kerf: {}\n", source.note);
  if (a.json)
    printJson(prepareJson(source, *result, a.outputs));
  else
    printPrepared(source, *result, a.outputs);
  return {};
}

int runPrepare(const PrepareArguments& a) {
  const auto prepared = prepare(a);
  if (prepared) return kOk;
  const Error& error = prepared.error();
  return error.code == Error::Code::kBadValue && error.place.starts_with("--") ? complainOfUsage(error)
                                                                               : complain(error);
}

constexpr const char* kPrepareFooter =
    "Without --plan: a wall of 2 mm, two drains of 3.5 mm in each cavity, the name of the case on the underside; that "
    "plan\n"
    "is print/model.toml of Kerf's data, to copy and change. Outer surfaces stay bit for bit, except at drains and "
    "labels.\n"
    "Without --to-bed the frame of the scan stays.\n"
    "Kerf measures the wall, and warns of trapped resin and of suction cups for the printing direction.\n"
    "Examples:\n"
    "  kerf prepare arch.case -o arch-print.stl\n"
    "  kerf prepare arch.case --plan lab.toml --word tooth=36 -o arch-print.3mf";

}  // namespace

void addPrepare(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<PrepareArguments>();
  command.footer(kPrepareFooter);
  command
      .add_option("CASE|RUN|MESH", a->what,
                  "solid to print; a mesh must be a closed solid: kerf bake closes other meshes")
      ->required();
  const auto takeAll = [](CLI::Option* option) {
    return option->expected(1)->allow_extra_args(false)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  };
  takeAll(command.add_option("-o,--output", a->outputs,
                             writableFormats() + "; colours in " + colorFormats() + ". Repeat for several"))
      ->required();
  command.add_option("--plan", a->plan, "steps: hollow, drain, label (TOML)")->type_name("FILE");
  command
      .add_option("--to-bed", a->bed,
                  "lay each piece flat on the bed of a printer: \"Form 3\" (print/beds.toml of Kerf's data), or "
                  "145x145x185")
      ->type_name("PRINTER");
  takeAll(command.add_option("--word", a->words, "text of a placeholder of labels. Repeat for several"))
      ->type_name("NAME=TEXT");
  command
      .add_option("--unit", a->unit, "unit of a mesh: mm, cm, m, um or inch (default: the declared unit, or by size)")
      ->type_name("UNIT")
      ->check(CLI::IsMember(unitNames()));
  addOverwrite(command, a->overwrites, "replace existing files");
  addCasePlaces(command);
  command.add_flag("--json", a->json, "print the summary as JSON on standard output");
  command.callback([a, &exit_code] { exit_code = runPrepare(*a); });
}

}  // namespace kerf::cli
