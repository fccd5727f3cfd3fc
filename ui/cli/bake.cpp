#include "preprocess/bake/pair.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "geometry/formats/mesh_formats.h"
#include "preprocess/bake/case_recipe.h"
#include "sim/hand/path.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

constexpr double kHighestBase = 1000;  // mm; closing allows no more

struct Arguments {
  std::vector<std::string> inputs;
  std::string output, close = "auto", base, base_direction, occlusal_plane;
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
    return fail({Error::Code::kBadValue, "", "--base-direction", "\"" + name + "\"", "+x, -x, +y, -y, +z or -z", ""});
  return it->second;
}

/// What the base options ask for; nothing if they were not given.
Expected<void> readBase(const Arguments& a, CloseOptions& options) {
  if (!a.base.empty() && a.base != "horseshoe" && a.base != "full")
    return fail({Error::Code::kBadValue, "", "--base", "\"" + a.base + "\"", "horseshoe or full", ""});
  options.base_style = a.base == "full" ? BaseStyle::kFull : BaseStyle::kHorseshoe;
  const double margin = options.base_margin_mm;
  if (!(margin > 0 && margin < kHighestBase))
    return fail({Error::Code::kBadValue, "", "--base-margin", fmt::format("{} mm", margin),
                 fmt::format("more than 0, less than {} mm", kHighestBase), "2, so that it does not break"});
  if (a.base_height && !(*a.base_height > 0 && *a.base_height < kHighestBase))
    return fail({Error::Code::kBadValue, "", "--base-height", fmt::format("{} mm", *a.base_height),
                 fmt::format("more than 0, less than {} mm", kHighestBase),
                 "20: the distance from the base up to the occlusal plane"});
  options.base_height_mm = a.base_height;
  if (!a.base_direction.empty()) {
    KERF_TRY(direction, axis(a.base_direction));
    options.base_direction = direction;
  }
  options.base_is_asked = !a.base.empty() || a.base_height || !a.occlusal_plane.empty() || !a.base_direction.empty();
  return {};
}

/// A mode, or steps with commas.
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
      return fail({Error::Code::kBadValue, "", "--close", "\"" + name + "\"",
                   "auto, base, repair, wrap, or some of weld,drop,stitch,orient,fill,base,union,wrap with commas",
                   "--close weld,orient,fill"});
    options.only.insert(static_cast<CloseStep>(known - kCloseStepNames.begin()));
    at = end + 1;
  }
  return {};
}

/// NX,NY,NZ or NX,NY,NZ@PX,PY,PZ.
Expected<GivenPlane> plane(const std::string& text) {
  const auto wrong = [&](const char* why) {
    return fail({Error::Code::kBadValue, "", "--occlusal-plane", "\"" + text + "\"", why,
                 "auto, 0,0,1 or 0.1,0,0.99@0,0,12.5"});
  };
  const auto vector = [](const std::string& s) -> std::optional<Vec3d> {
    Vec3d v;
    const char *at = s.data(), *end = s.data() + s.size();
    for (int k = 0; k < 3; ++k) {
      const auto [next, error] = std::from_chars(at, end, v[k]);
      if (error != std::errc() || !std::isfinite(v[k]) || (k < 2 ? next == end || *next != ',' : next != end))
        return {};
      at = next + 1;
    }
    return v;
  };
  const std::size_t at = text.find('@');
  const auto normal = vector(text.substr(0, at));
  if (!normal || !(normal->norm() > 0)) return wrong("auto, or three numbers with commas: a normal, not of length 0");
  GivenPlane given{*normal, {}};
  if (at == std::string::npos) return given;
  given.point = vector(text.substr(at + 1));
  if (!given.point) return wrong("after @ a point on the plane: three numbers with commas, mm");
  return given;
}

nlohmann::json toJson(const BakeReport& r) {
  nlohmann::json j{{"id", r.manifest.id},
                   {"exact", r.manifest.exact},
                   {"changes", r.manifest.changes},
                   {"was_up_to_date", r.was_up_to_date},
                   {"solid",
                    {{"vertices", r.manifest.solid_vertices},
                     {"triangles", r.manifest.solid_triangles},
                     {"volume_mm3", r.manifest.solid_volume_mm3},
                     {"area_mm2", r.manifest.solid_area_mm2}}},
                   {"field",
                    {{"voxel_mm", r.manifest.voxel_mm},
                     {"voxels", r.manifest.field_voxels},
                     {"shell_points", r.manifest.shell_points},
                     {"shell_area_mm2", r.manifest.shell_area_mm2}}},
                   {"seconds",
                    {{"read", r.times.read},
                     {"check", r.times.check},
                     {"close", r.times.close},
                     {"voxelize", r.times.voxelize},
                     {"write", r.times.write},
                     {"total", r.times.total()}}}};
  if (r.manifest.region)
    j["region"] = {
        {"voxel_mm", r.manifest.region->where.voxel_mm},   {"radius_mm", r.manifest.region->where.radius_mm},
        {"points", r.manifest.region->where.line.size()},  {"voxels", r.manifest.region->field_voxels},
        {"shell_points", r.manifest.region->shell_points}, {"shell_area_mm2", r.manifest.region->shell_area_mm2}};
  for (const CaseMaterial& m : r.manifest.materials)
    j["materials"].push_back({{"id", m.id}, {"number", m.number}, {"volume_mm3", m.volume_mm3}});
  for (const CasePart& p : r.manifest.parts)
    j["parts"].push_back(
        {{"material", p.material}, {"origin", p.origin}, {"own_mm3", p.own_mm3}, {"volume_mm3", p.volume_mm3}});
  if (r.manifest.gaps)
    j["gaps"] = {{"unclaimed_mm3", r.manifest.gaps->unclaimed_mm3}, {"forgotten_mm3", r.manifest.gaps->forgotten_mm3}};
  if (r.pair_check) {
    const PairCheck& c = *r.pair_check;
    j["pair_check"] = {{"boxes_apart_mm", c.boxes_apart_mm},
                       {"overlap_mm", c.overlap_mm},
                       {"notes", c.notes},
                       {"warnings", c.warnings}};
    if (c.planes_disagree_deg) j["pair_check"]["planes_disagree_deg"] = *c.planes_disagree_deg;
  }
  if (r.was_up_to_date) {
    j.erase("seconds");
    return j;
  }
  for (std::size_t i = 0; i < r.manifest.sources.size(); ++i) {
    const CaseSource& s = r.manifest.sources[i];
    j["sources"].push_back({{"stored_as", s.stored_as},
                            {"format", s.format},
                            {"sha256", s.sha256},
                            {"unit", s.unit},
                            {"unit_reason", s.unit_reason},
                            {"unit_is_doubtful", static_cast<bool>(r.unit_is_doubtful[i])},
                            {"scale_to_mm", s.scale_to_mm},
                            {"vertices", s.vertices},
                            {"triangles", s.triangles},
                            {"notes", r.notes[i]}});
    if (i < r.source_checks.size())
      j["sources"].back()["check"] = nlohmann::json::parse(kerf::toJson(r.source_checks[i]));
  }
  return j;
}

int runPair(const Arguments& a, const std::vector<std::filesystem::path>& paths) {
  if (paths.size() != 2) {
    complain({Error::Code::kBadValue, "", "--pair", fmt::format("{} meshes", paths.size()), "two: the jaws that meet",
              "kerf bake --pair upper.ply lower.ply -o patient"});
    return kUsage;
  }
  const std::array<std::filesystem::path, 2> meshes{paths[0], paths[1]};
  const auto folders = pairFolders(meshes, a.output);
  if (!folders) {
    complain(folders.error());
    return kUsage;
  }
  auto reports = [&] {
    TerminalProgress progress;
    return bakePair(meshes, *folders, a.options, progress.callback());
  }();
  if (!reports) return complain(reports.error());
  nlohmann::json all;
  for (std::size_t k = 0; k < 2; ++k) {
    if (!a.json) fmt::print("{}case written: {}\n", describe((*reports)[k]), (*folders)[k].string());
    all["pair"].push_back(toJson((*reports)[k]));
    all["pair"].back()["case"] = (*folders)[k].string();
  }
  all["frame"] = (*reports)[0].manifest.pair->frame;
  if (a.json) printJson(all);
  return kOk;
}

int run(Arguments& a) {
  if (const auto close = readClose(a.close, a.options.close); !close) {
    complain(close.error());
    return kUsage;
  }
  if (a.fill_up_to > 0) a.options.close.fill_up_to_mm = a.fill_up_to;
  if (const auto base = readBase(a, a.options.close); !base) {
    complain(base.error());
    return kUsage;
  }
  if (a.occlusal_plane == "auto") {
    a.options.close.find_occlusal_plane = true;
  } else if (!a.occlusal_plane.empty()) {
    const auto given = plane(a.occlusal_plane);
    if (!given) {
      complain(given.error());
      return kUsage;
    }
    a.options.close.occlusal_plane = *given;
  }
  if (!a.fine_along.empty()) {
    if (a.pair) {
      complain({Error::Code::kBadValue, "", "--fine-along", "beside --pair", "one object", "bake the jaws one by one"});
      return kUsage;
    }
    const auto path = readPath(a.fine_along);
    if (!path) return complain(path.error());
    FineRegion region{{}, a.fine_radius, a.fine_voxel};
    for (std::size_t n = 0; n < path->poses.size(); ++n)
      if ((n > 0 && path->cuts[n - 1]) || (n < path->cuts.size() && path->cuts[n]))
        region.line.push_back(path->poses[n].T_object_tool.translation);
    if (region.line.empty())
      return complain(
          {Error::Code::kEmpty, a.fine_along, "", "no motion that cuts", "a path with cutting motions", ""});
    region.line = thinned(region.line, region.radius_mm / 8);
    a.options.region = region;
  }
  std::vector<std::filesystem::path> paths(a.inputs.begin(), a.inputs.end());
  if (a.pair) return runPair(a, paths);
  const auto recipe = std::find_if(paths.begin(), paths.end(), looksLikeRecipe);
  if (recipe != paths.end() && paths.size() > 1) {
    complain({Error::Code::kBadValue, recipe->string(), "", "a recipe beside other files", "the recipe alone",
              "name the other meshes in it, as [[part]]"});
    return kUsage;
  }
  auto report = [&] {
    TerminalProgress progress;
    return recipe != paths.end() ? bakeRecipe(paths[0], a.output, a.options, progress.callback())
                                 : bake(paths, a.output, a.options, progress.callback());
  }();
  if (!report) return complain(report.error());
  if (a.json)
    printJson(toJson(*report));
  else
    fmt::print("{}{}: {}\n", describe(*report), report->was_up_to_date ? "up to date" : "case written", a.output);
  return kOk;
}

}  // namespace

void addBake(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<Arguments>();
  CLI::App* c = app.add_subcommand(
      "bake", "Turn mesh files or a case recipe into a case: closed solid, distance field, materials, point shell");
  c->footer(
      "Examples: kerf bake upper.ply -o upper.case --voxel 0.1\n          kerf bake molar.toml -o molar.case\n"
      "          kerf bake --pair upper.ply lower.ply -o patient --occlusal-plane auto --base-height 20");
  c->add_option(
       "INPUT", a->inputs,
       readableFormats() +
           "; several are united into one object. Or one recipe (.toml) that puts tissues together from meshes, depths "
           "and label volumes")
      ->required();
  c->add_option("-o,--output", a->output, "case folder to write")->required();
  c->add_flag("--pair", a->pair,
              "two jaws that meet: two cases, NAME-STEM.case after -o NAME and the files' names, that share one frame");
  c->add_option("--unit", a->options.unit,
                "unit of the files: mm, cm, m, um, inch (default: as declared, or by size, with the reason said)");
  c->add_option("--close", a->close,
                "auto: least repair, a flat base for an open scan | base | repair: never a base | wrap: shrink-wrap, "
                "approximate | or exactly some of weld,drop,stitch,orient,fill,base,union,wrap with commas")
      ->capture_default_str();
  c->add_option("--stitch-mm", a->options.close.stitch_mm, "join boundaries no farther apart [mm]; 0: none")
      ->capture_default_str();
  c->add_option("--fill-holes-up-to", a->fill_up_to,
                "a longer boundary [mm around] is no hole (default: judged by the size of the mesh)")
      ->check(CLI::PositiveNumber);
  c->add_option("--base", a->base,
                "horseshoe: walls follow the rim | full: on a plate under the outline of the rim (default: horseshoe)");
  c->add_option("--occlusal-plane", a->occlusal_plane,
                "make the base parallel to it: auto (found from the cusp tips) or NX,NY,NZ[@PX,PY,PZ], mm "
                "(default: the base is square to an axis)");
  c->add_option("--base-height", a->base_height,
                "from the base up to the occlusal plane, or without one to the highest point [mm]; overrides "
                "--base-margin");
  c->add_option("--base-margin", a->options.close.base_margin_mm, "base below the lowest point [mm]")
      ->capture_default_str();
  c->add_option("--base-direction", a->base_direction,
                "where the base goes: +x -x +y -y +z -z (default: where the scan is open)");
  CLI::Option* voxel = c->add_option("--voxel", a->options.voxelize.voxel_mm, "voxel size [mm]; goes before a recipe's")
                           ->capture_default_str();
  CLI::Option* along =
      c->add_option("--fine-along", a->fine_along,
                    "path file (docs/reference/path-files.md): smaller voxels around where its tip cuts; a cut "
                    "that stays there uses them. Goes before a recipe's [region]")
          ->check(CLI::ExistingFile);
  c->add_option("--fine-radius", a->fine_radius, "how far around [mm]")
      ->needs(along)
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  c->add_option("--fine-voxel", a->fine_voxel, "their size [mm] (default: half the object's)")
      ->needs(along)
      ->check(CLI::PositiveNumber);
  c->add_flag("--force", a->options.overwrite, "bake anew and replace an existing case");
  c->add_flag("--json", a->json, "report as JSON on standard output");
  c->callback([a, voxel, &exit_code] {
    a->options.voxel_is_given = voxel->count() > 0;
    exit_code = run(*a);
  });
}

}  // namespace kerf::cli
