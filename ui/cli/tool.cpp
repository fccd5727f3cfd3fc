#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "geometry/atomic_file.h"
#include "geometry/mesh_writer.h"
#include "geometry/sample_field.h"
#include "geometry/tool_file.h"
#include "geometry/vdb_io.h"
#include "sim/tool_check.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;
constexpr const char* kToolCopy = "tool.toml";

struct Arguments {
  std::vector<std::string> tools;
  std::string tool, output;
  double voxel = 0;  // 0: defaultVoxel
  bool json = false, overwrite = false;
};

int list(const Arguments& a) {
  const auto folders = defaultToolFolders();
  if (folders.empty())
    return complain({Error::Code::kNotFound, "", "", "no tools folder", "a folder assets/tools",
                     "set KERF_ASSETS to the folder that holds tools/"});
  bool all_read = true;
  nlohmann::json tools = nlohmann::json::array();
  for (const ToolListing& listing : listTools(folders)) {
    if (!listing.tool) {
      all_read = false;
      complain(*listing.error);
      if (a.json) tools.push_back({{"file", listing.file.string()}, {"error", listing.error->message()}});
    } else if (a.json) {
      tools.push_back(nlohmann::json::parse(toJson(*listing.tool)));
      tools.back()["file"] = listing.file.string();
    } else {
      fmt::print("{}\n", describe(*listing.tool));
    }
  }
  if (a.json) printJson(tools);
  return all_read ? kOk : kFailed;
}

int check(const Arguments& a) {
  bool all_passed = true;
  nlohmann::json results = nlohmann::json::array();
  for (const std::string& name : a.tools) {
    const auto file = findToolFile(name, defaultToolFolders());
    if (!file) return complain(file.error());
    const auto tool = readTool(*file);
    if (!tool) return complain(tool.error());
    const auto result = checkTool(*tool, a.voxel);
    if (!result) return complain(result.error());
    all_passed &= result->passed();
    if (a.json) {
      results.push_back({{"id", tool->id},
                         {"voxel_mm", result->voxel_mm},
                         {"depth_mm", result->depth_mm},
                         {"block_width_mm", result->block_width_mm},
                         {"expected_mm3", result->expected_mm3},
                         {"removed_mm3", result->removed_mm3},
                         {"error_percent", result->errorPercent()},
                         {"passed", result->passed()}});
    } else {
      fmt::print("{}\n", describe(*tool));
      const std::string block = result->block_width_mm > 0
                                    ? fmt::format(" through {:.3g} mm of the blade", result->block_width_mm)
                                    : std::string();
      fmt::print("  {:.3g} mm deep{}, voxel {:.3g} mm: removed {:.5f} mm3, by its numbers {:.5f} mm3, {:+.3f} %: {}\n",
                 result->depth_mm, block, result->voxel_mm, result->removed_mm3, result->expected_mm3,
                 result->errorPercent(),
                 result->passed() ? "PASS" : fmt::format("FAIL (allowed {} %)", ToolCheck::kLargestError));
    }
  }
  if (a.json) printJson(results);
  return all_passed ? kOk : kFailed;
}

Expected<void> write(const Arguments& a, const fs::path& file, const Tool& tool, double voxel) {
  KERF_TRY(folder, AtomicFolder::create(a.output, a.overwrite, kToolCopy));
  std::error_code failed;
  fs::copy_file(file, folder.staging() / kToolCopy, failed);
  if (failed)
    return fail({Error::Code::kWriteFailed, a.output, "", failed.message(), "a writable place with room", ""});
  const auto sampled = [&](const ToolShape& shape) {
    return sampleDistance([&](const Vec3d& p) { return shape.distance(p); }, shape.bounds(), voxel);
  };
  const BrickField cut = sampled(*tool.cut);
  const BrickField body = tool.body ? sampled(*tool.body) : BrickField();
  std::vector<NamedField> fields{{"cut", &cut}};
  if (tool.body) fields.push_back({"body", &body});
  KERF_CHECK(writeVdb(folder.staging() / "tool.vdb", fields, {{"tool_id", tool.id}}));
  KERF_CHECK(writeMesh(folder.staging() / "tool.ply", toolMesh(tool)));
  return folder.commit();
}

int bake(const Arguments& a) {
  const auto file = findToolFile(a.tool, defaultToolFolders());
  if (!file) return complain(file.error());
  const auto tool = readTool(*file);
  if (!tool) return complain(tool.error());
  const double voxel = a.voxel == 0 ? defaultVoxel(*tool) : a.voxel;
  if (!(voxel >= 0.001 && voxel <= 1))  // CLI::Range lets "nan" pass
    return complain({Error::Code::kBadValue, "", "--voxel", fmt::format("{} mm", voxel), "0.005 to 1 mm", ""});
  const TerminalProgress guard;  // Ctrl-C waits until the staging folder is gone
  if (const auto written = write(a, *file, *tool, voxel); !written) return complain(written.error());
  fmt::print("{} baked at {:.3g} mm voxels: {}\n", tool->id, voxel, a.output);
  return kOk;
}

}  // namespace

void addTool(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<Arguments>();
  CLI::App* c = app.add_subcommand("tool", "List, check and bake tools");
  c->require_subcommand(1);

  CLI::App* l = c->add_subcommand("list", "Tools found in $KERF_ASSETS/tools and beside the program");
  l->add_flag("--json", a->json, "as JSON on standard output");
  l->callback([a, &exit_code] { exit_code = list(*a); });

  CLI::App* k = c->add_subcommand("check", "Plunge tools into a block; compare what is gone with the closed formula");
  k->footer("Example: kerf tool check round-014 my-tool.toml");
  k->add_option("ID|FILE", a->tools, "tool ids or TOML files")->required();
  k->add_option("--voxel", a->voxel, "mm; default: head diameter / 20, blades thickness / 10")
      ->check(CLI::PositiveNumber);
  k->add_flag("--json", a->json, "as JSON on standard output");
  k->callback([a, &exit_code] { exit_code = check(*a); });

  CLI::App* b = c->add_subcommand("bake", "Write a tool's distance fields (OpenVDB) and its mesh into a folder");
  b->footer("Example: kerf tool bake round-014 -o round-014.tool");
  b->add_option("ID|FILE", a->tool, "tool id or TOML file")->required();
  b->add_option("-o,--output", a->output, "folder to write")->required();
  b->add_option("--voxel", a->voxel, "mm; default: head diameter / 20, blades thickness / 10")
      ->check(CLI::Range(0.005, 1.0));
  b->add_flag("--force", a->overwrite, "replace an existing folder of a baked tool");
  b->callback([a, &exit_code] { exit_code = bake(*a); });
}

}  // namespace kerf::cli
