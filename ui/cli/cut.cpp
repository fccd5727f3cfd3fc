#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "geometry/tool_file.h"
#include "sim/run_bundle.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

struct Arguments {
  std::string case_folder, tool, path, output;
  CutOptions options;
  bool json = false;
};

int run(const Arguments& a) {
  const auto tool = findToolFile(a.tool, defaultToolFolders());
  if (!tool) return complain(tool.error());
  auto manifest = [&] {
    TerminalProgress progress;
    return cutCase(a.case_folder, *tool, a.path, a.output, a.options, progress.callback());
  }();
  if (!manifest) return complain(manifest.error());
  if (manifest->beyond_region_mm > 0)
    fmt::print(
        stderr,
        "kerf: the cut reaches {:.2f} mm out of the case's fine region: cut on the object's voxels, {} mm. For the "
        "fine ones bake with a larger --fine-radius\n",
        manifest->beyond_region_mm, manifest->voxel_mm);
  if (a.json)
    printJson(nlohmann::json{{"tool", manifest->tool_id},
                             {"segments", manifest->segments},
                             {"path_length_mm", manifest->path_length_mm},
                             {"duration_s", manifest->duration_s},
                             {"voxel_mm", manifest->voxel_mm},
                             {"beyond_region_mm", manifest->beyond_region_mm},
                             {"state_hash", manifest->state_hash}});
  else
    fmt::print("cut with {} along {:.2f} mm in {} motions, voxels {} mm; state {}\nrun written: {}\n",
               manifest->tool_id, manifest->path_length_mm, manifest->segments, manifest->voxel_mm,
               manifest->state_hash, a.output);
  return kOk;
}

}  // namespace

void addCut(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<Arguments>();
  CLI::App* c = app.add_subcommand("cut", "Cut a case with a tool along a path");
  c->footer(
      "Geometry only: the cutting part removes what it sweeps; neck, shank and flanks do not collide yet.\nExample: "
      "kerf cut molar.case --tool round-014 --path cavity.toml -o molar.run");
  c->add_option("CASE", a->case_folder, "case folder")->required();
  c->add_option("--tool", a->tool, "tool id (kerf tool list) or a tool's TOML file")->required();
  c->add_option("--path", a->path, "CSV of poses (t,x,y,z,qw,qx,qy,qz) or TOML of strokes; see docs/path-files.md")
      ->required();
  c->add_option("-o,--output", a->output, "run folder to write")->required();
  c->add_flag("--force", a->options.overwrite, "replace an existing run");
  c->add_flag("--json", a->json, "summary as JSON on standard output");
  c->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace kerf::cli
