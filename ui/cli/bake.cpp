#include "preprocess/bake.h"

#include <fmt/format.h>

#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

struct Arguments {
  std::vector<std::string> meshes;
  std::string output, base_direction;
  BakeOptions options;
  bool json = false;
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

nlohmann::json toJson(const BakeReport& r) {
  nlohmann::json j{{"id", r.manifest.id},
                   {"exact", r.manifest.exact},
                   {"changes", r.manifest.changes},
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
                            {"notes", r.notes[i]},
                            {"check", nlohmann::json::parse(kerf::toJson(r.source_checks[i]))}});
  }
  return j;
}

int run(Arguments& a) {
  if (!a.base_direction.empty()) {
    const auto direction = axis(a.base_direction);
    if (!direction) return complain(direction.error()), kUsage;
    a.options.close.base_direction = *direction;
  }
  a.options.close.cleanup_length_mm = 0.01 * a.options.voxelize.voxel_mm;
  std::vector<std::filesystem::path> paths(a.meshes.begin(), a.meshes.end());
  auto report = [&] {
    TerminalProgress progress;
    return bake(paths, a.output, a.options, progress.callback());
  }();
  if (!report) return complain(report.error());
  if (a.json)
    printJson(toJson(*report));
  else
    fmt::print("{}case written: {}\n", describe(*report), a.output);
  return kOk;
}

}  // namespace

void addBake(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<Arguments>();
  CLI::App* c = app.add_subcommand("bake", "Turn mesh files into a case: closed solid, distance field, point shell");
  c->footer("Example: kerf bake upper.ply -o upper.case --voxel 0.1");
  c->add_option("MESH", a->meshes, "STL, PLY, OBJ, OFF or 3MF; several are united into one object")->required();
  c->add_option("-o,--output", a->output, "case folder to write")->required();
  c->add_option("--unit", a->options.unit,
                "unit of the files: mm, cm, m, um, inch (default: as declared, or by size, with the reason said)");
  const std::map<std::string, CloseMode> modes{{"auto", CloseMode::kAuto},
                                               {"base", CloseMode::kBase},
                                               {"repair", CloseMode::kRepair},
                                               {"wrap", CloseMode::kWrap}};
  c->add_option("--close", a->options.close.mode,
                "auto: least repair, a flat base for an open scan | base | repair: never a base | wrap: shrink-wrap, "
                "approximate")
      ->transform(CLI::CheckedTransformer(modes, CLI::ignore_case))
      ->default_str("auto");
  c->add_option("--base-margin", a->options.close.base_margin_mm, "base below the lowest point [mm]")
      ->capture_default_str();
  c->add_option("--base-direction", a->base_direction,
                "where the base goes: +x -x +y -y +z -z (default: where the scan is open)");
  c->add_option("--voxel", a->options.voxelize.voxel_mm, "voxel size [mm]")->capture_default_str();
  c->add_flag("--force", a->options.overwrite, "replace an existing case");
  c->add_flag("--json", a->json, "report as JSON on standard output");
  c->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace kerf::cli
