#include "preprocess/bake/pair.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "geometry/formats/mesh_formats.h"
#include "preprocess/bake/case_recipe.h"
#include "preprocess/bake/closing_numbers.h"
#include "preprocess/bake/trim_file.h"
#include "preprocess/unit/unit.h"
#include "sim/hand/path.h"
#include "ui/app/saw/plane_words.h"
#include "ui/cli/closing_json.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

constexpr double kHighestBase = 1000;  // mm; limit of closing

struct BakeArguments {
  std::vector<std::string> inputs;
  std::string output, close = "auto", base, base_direction, occlusal_plane, trim;
  std::optional<double> base_height;
  double fill_up_to = 0;                   // 0: by the size
  std::string fine_along;                  // a path file
  double fine_radius = 3, fine_voxel = 0;  // 0: half the object's
  BakeOptions options;
  bool pair = false, json = false;
};

Expected<Vec3d> axis(const std::string& name) {
  static const std::map<std::string, Vec3d> kAxes{{"+x", Vec3d::UnitX()}, {"-x", -Vec3d::UnitX()},
                                                  {"+y", Vec3d::UnitY()}, {"-y", -Vec3d::UnitY()},
                                                  {"+z", Vec3d::UnitZ()}, {"-z", -Vec3d::UnitZ()}};
  const auto it = kAxes.find(name);
  if (it == kAxes.end())
    return fail({.code = Error::Code::kBadValue,
                 .place = "--base-direction",
                 .found = "\"" + name + "\"",
                 .expected = "+x, -x, +y, -y, +z or -z"});
  return it->second;
}

Expected<void> requireLength(const char* option, double mm, const char* hint) {
  if (mm > 0 && mm < kHighestBase) return {};
  return fail({.code = Error::Code::kBadValue,
               .place = option,
               .found = fmt::format("{} mm", mm),
               .expected = fmt::format("more than 0, less than {} mm", kHighestBase),
               .hint = hint});
}

/// Reads the base options, if given.
Expected<void> readBase(const BakeArguments& a, CloseOptions& options) {
  if (!a.base.empty() && a.base != "horseshoe" && a.base != "full")
    return fail({.code = Error::Code::kBadValue,
                 .place = "--base",
                 .found = "\"" + a.base + "\"",
                 .expected = "horseshoe or full"});
  options.base_style = a.base == "full" ? BaseStyle::kFull : BaseStyle::kHorseshoe;

  KERF_CHECK(requireLength("--base-margin", options.base_margin_mm, "2, so that it does not break"));
  if (a.base_height)
    KERF_CHECK(
        requireLength("--base-height", *a.base_height, "20: the distance from the base up to the occlusal plane"));
  options.base_height_mm = a.base_height;
  if (!a.base_direction.empty()) {
    KERF_TRY(direction, axis(a.base_direction));
    options.base_direction = direction;
  }
  options.base_is_asked = !a.base.empty() || a.base_height || !a.occlusal_plane.empty() || !a.base_direction.empty();
  return {};
}

/// A mode, or comma-separated steps.
Expected<void> readClose(const std::string& text, CloseOptions& options) {
  static const std::map<std::string, CloseMode> kModes{{"auto", CloseMode::kAuto},
                                                       {"base", CloseMode::kBase},
                                                       {"repair", CloseMode::kRepair},
                                                       {"wrap", CloseMode::kWrap}};
  if (const auto mode = kModes.find(text); mode != kModes.end()) {
    options.mode = mode->second;
    return {};
  }

  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::string name = text.substr(at, end - at);
    const auto known = std::find(kCloseStepNames.begin(), kCloseStepNames.end(), name);
    if (known == kCloseStepNames.end())
      return fail(
          {.code = Error::Code::kBadValue,
           .place = "--close",
           .found = "\"" + name + "\"",
           .expected =
               "auto, base, repair, wrap, or steps of weld,drop,stitch,orient,fill,base,union,wrap separated by commas",
           .hint = "--close weld,orient,fill"});
    options.only.insert(static_cast<CloseStep>(known - kCloseStepNames.begin()));
    at = end + 1;
  }
  return {};
}

/// NX,NY,NZ or NX,NY,NZ@PX,PY,PZ.
Expected<GivenPlane> plane(const std::string& text) {
  const auto given = normalAndPointOfWord(text);
  if (!given)
    return fail(
        {.code = Error::Code::kBadValue,
         .place = "--occlusal-plane",
         .found = "\"" + text + "\"",
         .expected = "auto, or NX,NY,NZ, a normal that is not zero; a point on the plane may follow: @PX,PY,PZ, mm",
         .hint = "auto, 0,0,1 or 0.1,0,0.99@0,0,12.5"});
  return GivenPlane{given->normal, given->point};
}

nlohmann::json bakeJson(const CaseManifest& m) {
  nlohmann::json j{{"id", m.id},
                   {"exact", m.exact},
                   {"changes", m.changes},
                   {"solid",
                    {{"vertices", m.solid_vertices},
                     {"triangles", m.solid_triangles},
                     {"volume_mm3", m.solid_volume_mm3},
                     {"area_mm2", m.solid_area_mm2}}},
                   {"field",
                    {{"voxel_mm", m.voxel_mm},
                     {"voxels", m.field_voxels},
                     {"shell_points", m.shell_points},
                     {"shell_area_mm2", m.shell_area_mm2}}}};
  if (m.region)
    j["region"] = {{"voxel_mm", m.region->where.voxel_mm},   {"radius_mm", m.region->where.radius_mm},
                   {"points", m.region->where.line.size()},  {"voxels", m.region->field_voxels},
                   {"shell_points", m.region->shell_points}, {"shell_area_mm2", m.region->shell_area_mm2}};
  for (const CaseMaterial& c : m.materials)
    j["materials"].push_back({{"id", c.id}, {"number", c.number}, {"volume_mm3", c.volume_mm3}});
  for (const CasePart& p : m.parts)
    j["parts"].push_back(
        {{"material", p.material}, {"origin", p.origin}, {"own_mm3", p.own_mm3}, {"volume_mm3", p.volume_mm3}});
  if (m.gaps) j["gaps"] = {{"unclaimed_mm3", m.gaps->unclaimed_mm3}, {"forgotten_mm3", m.gaps->forgotten_mm3}};
  return j;
}

nlohmann::json bakeJson(const PairCheck& c) {
  nlohmann::json j{
      {"boxes_apart_mm", c.boxes_apart_mm}, {"overlap_mm", c.overlap_mm}, {"notes", c.notes}, {"warnings", c.warnings}};
  if (c.planes_disagree_deg) j["planes_disagree_deg"] = *c.planes_disagree_deg;
  return j;
}

// Losses of closing.
nlohmann::json bakeJson(const CloseReport& c) {
  nlohmann::json holes = nlohmann::json::array();
  for (const Vec3d& p : c.handles_at) holes.push_back({p.x(), p.y(), p.z()});
  nlohmann::json lost = nlohmann::json::array();
  for (const LostPlace& place : c.lost_at) {
    const Vec3d& p = place.middle;
    lost.push_back({{"vertices", place.vertices}, {"at_mm", {p.x(), p.y(), p.z()}}});
  }
  nlohmann::json bridges = nlohmann::json::array();
  for (const BridgedPlace& place : c.bridged_at) {
    const Vec3d& p = place.middle;
    bridges.push_back({{"area_mm2", place.area_mm2}, {"span_mm", place.span_mm}, {"at_mm", {p.x(), p.y(), p.z()}}});
  }
  nlohmann::json spans = nlohmann::json::array();
  for (const WideSpan& span : c.wide_spans) {
    const Vec3d& p = span.middle;
    spans.push_back({{"span_mm", span.mm}, {"at_mm", {p.x(), p.y(), p.z()}}});
  }
  nlohmann::json j = closingJson(closingNumbers(c));
  j["vertices_lost_at"] = lost;
  j["bridged_at"] = bridges;
  j["wide_spans"] = spans;
  j["handles_at_mm"] = holes;
  j["base_fallback"] = c.base_fallback;
  j["warnings"] = c.warnings;
  if (c.exact) j["wrapped_mm3"] = nullptr;
  return j;
}

// Closing data of an up-to-date case: the numbers, no places.
nlohmann::json keptClosing(const CaseManifest& m) {
  if (m.closing.empty()) return nullptr;
  nlohmann::json j = closingJson(m.closing);
  for (const char* key :
       {"vertices_lost_at", "bridged_at", "wide_spans", "handles_at_mm", "base_fallback", "warnings", "wrapped_mm3"})
    if (!j.contains(key)) j[key] = nullptr;
  if (m.warnings) j["warnings"] = closingWarningsOf(m);
  return j;
}

// The n-th source, as read.
nlohmann::json sourceJson(const CaseSource& s) {
  return {{"stored_as", s.stored_as}, {"format", s.format},           {"sha256", s.sha256},
          {"unit", s.unit},           {"unit_reason", s.unit_reason}, {"scale_to_mm", s.scale_to_mm},
          {"vertices", s.vertices},   {"triangles", s.triangles}};
}

// With findings of reading it.
nlohmann::json sourceJson(const BakeReport& r, std::size_t n) {
  nlohmann::json j = sourceJson(r.manifest.sources[n]);
  j["unit_is_doubtful"] = static_cast<bool>(r.unit_is_doubtful[n]);
  j["notes"] = r.notes[n];
  if (n < r.source_checks.size()) j["check"] = nlohmann::json::parse(kerf::toJson(r.source_checks[n]));
  return j;
}

nlohmann::json bakeJson(const BakeReport& r) {
  nlohmann::json j = bakeJson(r.manifest);
  j["solid"]["pieces"] = r.pieces.pieces;
  j["solid"]["cavities"] = r.pieces.cavities;
  j["solid"]["specks"] = r.pieces.specks;
  j["solid"]["specks_mm3"] = r.pieces.specks_mm3;
  j["was_up_to_date"] = r.was_up_to_date;
  j["warnings"] = r.manifest.warnings ? nlohmann::json(*r.manifest.warnings) : nlohmann::json();
  if (r.pair_check) j["pair_check"] = bakeJson(*r.pair_check);
  if (r.was_up_to_date) {  // the same keys: no timing, no closing
    j["seconds"] = nullptr;
    if (r.manifest.parts.empty()) j["closing"] = keptClosing(r.manifest);
    for (const CaseSource& s : r.manifest.sources) j["sources"].push_back(sourceJson(s));
    return j;
  }

  j["seconds"] = {{"read", r.times.read},         {"check", r.times.check}, {"close", r.times.close},
                  {"voxelize", r.times.voxelize}, {"write", r.times.write}, {"total", r.times.total()}};
  if (r.manifest.parts.empty()) j["closing"] = bakeJson(r.close);
  for (std::size_t n = 0; n < r.manifest.sources.size(); ++n) j["sources"].push_back(sourceJson(r, n));
  return j;
}

int runPair(const BakeArguments& a, const std::vector<std::filesystem::path>& paths) {
  if (paths.size() != 2)
    return complainOfUsage({.code = Error::Code::kBadValue,
                            .place = "--pair",
                            .found = fmt::format("{} meshes", paths.size()),
                            .expected = "two: the jaws in occlusion",
                            .hint = "kerf bake --pair upper.ply lower.ply -o patient"});
  const std::array<std::filesystem::path, 2> meshes{paths[0], paths[1]};
  const auto folders = pairFolders(meshes, a.output);
  if (!folders) return complainOfUsage(folders.error());
  auto reports = [&] {
    TerminalProgress progress;
    return bakePair(meshes, *folders, a.options, progress.callback());
  }();
  if (!reports) return complain(reports.error());

  nlohmann::json all;
  for (std::size_t k = 0; k < 2; ++k) {
    if (!a.json) printText("{}case written: {}\n", describe((*reports)[k]), (*folders)[k].string());
    all["pair"].push_back(bakeJson((*reports)[k]));
    all["pair"].back()["case"] = (*folders)[k].string();
  }
  all["frame"] = (*reports)[0].manifest.pair->frame;
  if (a.json) printJson(all);
  return kOk;
}

// Converts options to options.close. Errors are of the command line.
Expected<void> readCloseOptions(const BakeArguments& a, CloseOptions& close) {
  KERF_CHECK(readClose(a.close, close));
  if (a.fill_up_to > 0) close.fill_up_to_mm = a.fill_up_to;
  KERF_CHECK(readBase(a, close));
  if (a.occlusal_plane == "auto") {
    close.find_occlusal_plane = true;
  } else if (!a.occlusal_plane.empty()) {
    KERF_TRY(given, plane(a.occlusal_plane));
    close.occlusal_plane = given;
  }
  return {};
}

// The region around the tip's cutting positions in the path file of --fine-along.
Expected<FineRegion> readRegion(const BakeArguments& a) {
  KERF_TRY(path, readPath(a.fine_along));
  FineRegion region{{}, a.fine_radius, a.fine_voxel};
  for (std::size_t n = 0; n < path.poses.size(); ++n)
    if ((n > 0 && path.cuts[n - 1]) || (n < path.cuts.size() && path.cuts[n]))
      region.line.push_back(path.poses[n].T_object_tool.translation);
  if (region.line.empty())
    return fail({.code = Error::Code::kEmpty,
                 .file = a.fine_along,
                 .found = "no cutting motion",
                 .expected = "a path with cutting motions"});
  region.line = thinned(region.line, region.radius_mm / 8);
  return region;
}

int runOne(const BakeArguments& a, const std::vector<std::filesystem::path>& paths) {
  const auto recipe = std::find_if(paths.begin(), paths.end(), looksLikeRecipe);
  if (recipe != paths.end() && paths.size() > 1)
    return complainOfUsage({.code = Error::Code::kBadValue,
                            .file = recipe->string(),
                            .found = "a recipe together with other files",
                            .expected = "the recipe alone",
                            .hint = "name the other meshes in it, as [[part]]"});
  const auto report = [&] {
    TerminalProgress progress;
    return recipe != paths.end() ? bakeRecipe(paths[0], a.output, a.options, progress.callback())
                                 : bake(paths, a.output, a.options, progress.callback());
  }();
  if (!report) return complain(report.error());

  if (a.json)
    printJson(bakeJson(*report));
  else
    printText("{}{}: {}\n", describe(*report), report->was_up_to_date ? "up to date" : "case written", a.output);
  return kOk;
}

int runBake(BakeArguments& a) {
  if (const auto read = readCloseOptions(a, a.options.close); !read) return complainOfUsage(read.error());
  if (!a.trim.empty()) {
    if (a.pair)
      return complainOfUsage({.code = Error::Code::kBadValue,
                              .place = "--trim",
                              .found = "given with --pair",
                              .expected = "one scan",
                              .hint = "bake the jaws one by one"});
    auto trims = readTrims(a.trim);
    if (!trims) return complain(trims.error());
    a.options.close.trims = std::move(*trims);
  }
  if (!a.fine_along.empty()) {
    if (a.pair)
      return complainOfUsage({.code = Error::Code::kBadValue,
                              .place = "--fine-along",
                              .found = "given with --pair",
                              .expected = "one object",
                              .hint = "bake the jaws one by one"});
    const auto region = readRegion(a);
    if (!region) return complain(region.error());
    a.options.region = *region;
  }
  const std::vector<std::filesystem::path> paths(a.inputs.begin(), a.inputs.end());
  return a.pair ? runPair(a, paths) : runOne(a, paths);
}

void addClosingOptions(CLI::App& command, BakeArguments& a) {
  command
      .add_option(
          "--close", a.close,
          "closing method: auto (least repair, a flat base for an open scan) | base | repair (never a base) | wrap "
          "(shrink-wrap, approximate) | or steps separated by commas: weld,drop,stitch,orient,fill,base,union,wrap")
      ->capture_default_str();
  command
      .add_option("--wrap-alpha", a.options.close.wrap_alpha_mm,
                  "with --close wrap: bridge gaps narrower than this [mm]; below 0.3 it takes minutes")
      ->check(CLI::Range(0.05, 100.0))
      ->capture_default_str();
  command
      .add_option("--stitch-mm", a.options.close.stitch_mm, "join boundaries up to this distance apart [mm]; 0: none")
      ->check(CLI::Range(0.0, kWidestStitch))
      ->capture_default_str();
  command
      .add_option("--fill-holes-up-to", a.fill_up_to,
                  "fill boundaries up to this circumference [mm] (default: from the size of the mesh)")
      ->check(CLI::PositiveNumber);

  command.add_option("--base", a.base,
                     "shape of the base: horseshoe (walls follow the rim) | full (a plate under the outline of the "
                     "rim) (default: horseshoe)");
  command.add_option("--occlusal-plane", a.occlusal_plane,
                     "make the base parallel to this plane: auto (from the cusp tips) or NX,NY,NZ[@PX,PY,PZ], mm "
                     "(default: the base is square to an axis)");
  command.add_option("--base-height", a.base_height,
                     "height from the base to the occlusal plane, or to the highest point if there is no plane [mm]; "
                     "overrides --base-margin");
  command
      .add_option("--base-margin", a.options.close.base_margin_mm, "distance of the base below the lowest point [mm]")
      ->capture_default_str();
  command
      .add_option("--base-smoothing", a.options.close.base_smoothing_mm,
                  "smooth waves shorter than this out of the base walls, and bridge narrow gaps of the rim [mm]; 0: "
                  "straight walls under the rim")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command.add_option("--base-direction", a.base_direction,
                     "side of the base: +x -x +y -y +z -z (default: the open side of the scan)");
  command
      .add_option("--trim", a.trim,
                  "cut parts of the scan away first: a trim file (docs/reference/file-formats.md), or a case made with "
                  "one. The import of kerf-sim records them")
      ->check(CLI::ExistingPath);
  command
      .add_option("--trim-rim", a.options.close.trim_rim_mm,
                  "remove tongues and flakes of the rim narrower than this [mm] before building the base; the report "
                  "lists them (default: none)")
      ->check(CLI::Range(0.0, kWidestTrim));
  command
      .add_option("--drop-specks", a.options.close.drop_specks_mm3,
                  "drop pieces of the solid smaller than this [mm3] (default: none; overrides a recipe's)")
      ->check(CLI::NonNegativeNumber);
  command.add_flag("--accept-doubtful", a.options.close.accept_doubtful,
                   "accept, with a warning, a solid with more than twice or less than a quarter of the expected "
                   "volume, or without more than three fifths of the scan's vertices (default: reject it)");
}

void addFineOptions(CLI::App& command, BakeArguments& a) {
  CLI::Option* along =
      command
          .add_option("--fine-along", a.fine_along,
                      "path file (docs/reference/path-files.md): bake a fine region, with smaller voxels, around its "
                      "cutting motions; a cut inside the region uses them. Overrides a recipe's [region]")
          ->check(CLI::ExistingFile);
  command.add_option("--fine-radius", a.fine_radius, "radius of the fine region around the path [mm]")
      ->needs(along)
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  command.add_option("--fine-voxel", a.fine_voxel, "voxel size of the fine region [mm] (default: half the object's)")
      ->needs(along)
      ->check(CLI::Range(kSmallestVoxel, kLargestVoxel));
}

}  // namespace

void addBake(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<BakeArguments>();
  command.footer(
      "Examples: kerf bake upper.ply -o upper.case --voxel 0.1\n          kerf bake molar.toml -o molar.case\n"
      "          kerf bake --pair upper.ply lower.ply -o patient --occlusal-plane auto --base-height 20");
  command
      .add_option("INPUT", a->inputs,
                  readableFormats() +
                      "; Kerf unites several into one object. Or one recipe (.toml) that combines tissues from meshes, "
                      "depths and label volumes")
      ->required();
  command.add_option("-o,--output", a->output, "case folder to write")->required();
  command.add_flag(
      "--pair", a->pair,
      "bake two jaws in occlusion: writes two cases in one frame, NAME-STEM.case, from -o NAME and the file names");
  command
      .add_option("--unit", a->options.unit,
                  "unit of the files (default: the declared unit, or by size; the report gives the reason)")
      ->check(CLI::IsMember(unitNames()));
  addClosingOptions(command, *a);
  CLI::Option* voxel =
      command.add_option("--voxel", a->options.voxelize.voxel_mm, "voxel size [mm]; overrides a recipe's")
          ->check(CLI::Range(kSmallestVoxel, kLargestVoxel))
          ->capture_default_str();
  addFineOptions(command, *a);
  addOverwrite(command, a->options.overwrite, "bake again and replace an existing case");
  command.add_flag("--json", a->json, "print the report as JSON on standard output");
  command.callback([a, voxel, &exit_code] {
    a->options.voxel_is_given = voxel->count() > 0;
    exit_code = runBake(*a);
  });
}

}  // namespace kerf::cli
