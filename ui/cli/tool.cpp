#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <memory>
#include <nlohmann/json.hpp>

#include "geometry/base/atomic_file.h"
#include "geometry/base/toml_reader.h"
#include "geometry/field/sample_field.h"
#include "geometry/field/vdb_io.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/tool/head_shape.h"
#include "geometry/tool/tool_drawing.h"
#include "geometry/tool/tool_file.h"
#include "geometry/tool/tool_template.h"
#include "sim/run/tool_check.h"
#include "sim/step/tool_model.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;
constexpr const char* kToolCopy = "tool.toml";

struct Arguments {
  std::vector<std::string> tools;
  std::vector<std::string> words;
  std::string tool, output, shape;
  double voxel = 0;  // 0: defaultVoxel
  bool json = false, overwrite = false, all = false;
};

// Whether a text holds a word, in whatever case.
bool mentions(const std::string& text, const std::string& word) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
  };
  return std::search(text.begin(), text.end(), word.begin(), word.end(), same) != text.end();
}

// One line of `kerf tool list`.
std::string row(const Tool& tool) {
  const Vec3d size = tool.cut->bounds().size();
  const std::string numbers =
      tool.kind == ToolKind::kMesh
          ? fmt::format("{:<14} {:>5.2f} x {:<6.2f}", "mesh", std::max(size[0], size[1]), size[2])
      : tool.kind == ToolKind::kBur
          ? fmt::format("{:<14} {:>5.2f} x {:<6.2f}", tool.shape, tool.head_diameter_mm, tool.head_length_mm)
          : fmt::format("{:<14} kerf {:<9.3g}", tool.motion->name, tool.kerfWidth());
  return fmt::format("{:<22} {}  {:<15}  {}", tool.id, numbers, tool.iso6360, tool.name);
}

int list(const Arguments& a) {
  const auto folders = defaultToolFolders();
  if (folders.empty())
    return complain({Error::Code::kNotFound, "", "", "no tools folder", "a folder assets/tools",
                     "set KERF_ASSETS to the folder that holds tools/"});
  bool all_read = true;
  std::size_t shown = 0;
  nlohmann::json tools = nlohmann::json::array();
  for (const ToolListing& listing : listTools(folders)) {
    if (!listing.tool) {
      all_read = false;
      complain(*listing.error);
      if (a.json) tools.push_back({{"file", listing.file.string()}, {"error", listing.error->message()}});
      continue;
    }
    const std::string line = row(*listing.tool);
    if (!std::all_of(a.words.begin(), a.words.end(), [&](const std::string& word) { return mentions(line, word); }))
      continue;
    if (a.json) {
      tools.push_back(nlohmann::json::parse(toJson(*listing.tool)));
      tools.back()["file"] = listing.file.string();
    } else {
      if (shown++ == 0)
        fmt::print("{:<22} {:<14} {:<14}  {:<15}  {}\n", "id", "shape", "D x L, mm", "ISO 6360", "name");
      fmt::print("{}\n", line);
    }
  }
  if (a.json) printJson(tools);
  if (!a.json && shown == 0) fmt::print("No tool mentions that; kerf tool list shows all.\n");
  return all_read ? kOk : kFailed;
}

nlohmann::json withDrive(const Tool& tool) {
  nlohmann::json j = nlohmann::json::parse(toJson(tool));
  const ToolDrive drive = driveOf(tool);
  const bool is_stroke = motionOf(tool) == ToolMotion::kStroke;
  j["drive"] = {{is_stroke ? "mean_speed_mm_per_s" : "mean_speed_rad_per_s", drive.speed},
                {is_stroke ? "stall_force_N" : "stall_torque_Nmm", drive.stall_load},
                {"time_constant_s", drive.time_constant},
                {"energy_factor", drive.energy_factor},
                {"drag_factor", drive.drag_factor}};
  return j;
}

int info(const Arguments& a) {
  const auto file = findToolFile(a.tool, defaultToolFolders());
  if (!file) return complain(file.error());
  const auto tool = readTool(*file);
  if (!tool) return complain(tool.error());
  if (a.json)
    printJson(withDrive(*tool));
  else
    fmt::print("{}\n  drive: {}\n", describe(*tool), describeDrive(*tool));
  return kOk;
}

int check(const Arguments& a) {
  std::vector<fs::path> files;
  if (a.all)
    for (const ToolListing& listing : listTools(defaultToolFolders())) files.push_back(listing.file);
  for (const std::string& name : a.tools) {
    const auto file = findToolFile(name, defaultToolFolders());
    if (!file) return complain(file.error());
    files.push_back(*file);
  }
  const bool is_table = files.size() > 1;
  std::size_t passed = 0;
  nlohmann::json results = nlohmann::json::array();
  for (const fs::path& file : files) {
    const auto tool = readTool(file);
    const auto result = tool ? checkTool(*tool, a.voxel) : Expected<ToolCheck>(fail(tool.error()));
    if (!result) {
      complain(result.error());
      if (!a.all) return kFailed;
      continue;
    }
    passed += result->passed();
    const std::string verdict =
        result->passed() ? "PASS" : fmt::format("FAIL (allowed {} %)", ToolCheck::kLargestError);
    if (a.json) {
      results.push_back({{"id", tool->id},
                         {"voxel_mm", result->voxel_mm},
                         {"depth_mm", result->depth_mm},
                         {"block_width_mm", result->block_width_mm},
                         {"expected_mm3", result->expected_mm3},
                         {"removed_mm3", result->removed_mm3},
                         {"error_percent", result->errorPercent()},
                         {"passed", result->passed()}});
    } else if (is_table) {
      if (file == files.front())
        fmt::print("{:<22} {:>8} {:>9} {:>13} {:>13} {:>8}\n", "id", "deep, mm", "voxel, mm", "removed, mm3",
                   "expected, mm3", "error, %");
      fmt::print("{:<22} {:>8.3g} {:>9.3g} {:>13.5f} {:>13.5f} {:>+8.3f}  {}\n", tool->id, result->depth_mm,
                 result->voxel_mm, result->removed_mm3, result->expected_mm3, result->errorPercent(), verdict);
    } else {
      fmt::print("{}\n", describe(*tool));
      const std::string block = result->block_width_mm > 0
                                    ? fmt::format(" through {:.3g} mm of the blade", result->block_width_mm)
                                    : std::string();
      fmt::print("  {:.3g} mm deep{}, voxel {:.3g} mm: removed {:.5f} mm3, by its numbers {:.5f} mm3, {:+.3f} %: {}\n",
                 result->depth_mm, block, result->voxel_mm, result->removed_mm3, result->expected_mm3,
                 result->errorPercent(), verdict);
    }
  }
  if (a.json)
    printJson(results);
  else if (is_table)
    fmt::print("{} of {} tools pass.\n", passed, files.size());
  return passed == files.size() ? kOk : kFailed;
}

Expected<void> write(const Arguments& a, const fs::path& file, const Tool& tool, double voxel) {
  KERF_TRY(folder, AtomicFolder::create(a.output, a.overwrite, kToolCopy));
  std::error_code failed;
  fs::copy_file(file, folder.staging() / kToolCopy, failed);
  if (failed)
    return fail({Error::Code::kWriteFailed, a.output, "", failed.message(), "a writable place with room", ""});
  if (tool.mesh) {
    fs::copy_file(tool.mesh_file, folder.staging() / tool.mesh_file.filename(), failed);
    if (failed)
      return fail({Error::Code::kWriteFailed, a.output, "", failed.message(), "a writable place with room", ""});
  }
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

int draw(const Arguments& a) {
  const auto file = findToolFile(a.tool, defaultToolFolders());
  if (!file) return complain(file.error());
  const auto tool = readTool(*file);
  if (!tool) return complain(tool.error());
  const fs::path output = a.output.empty() ? fs::path(tool->id + ".svg") : fs::path(a.output);
  auto svg = AtomicFile::create(output);
  if (!svg) return complain(svg.error());
  svg->stream() << toolDrawing(*tool);
  if (const auto written = svg->commit(); !written) return complain(written.error());
  fmt::print("drawn: {}\n", output.string());
  return kOk;
}

int makeNew(const Arguments& a) {
  const HeadShape* shape = findHeadShape(a.shape);
  if (!shape) {
    std::vector<std::string> names;
    std::string all;
    for (const HeadShape& s : headShapes()) {
      names.emplace_back(s.name);
      all += (all.empty() ? "" : ", ") + names.back();
    }
    return complain(
        {Error::Code::kBadValue, "", "--shape", "\"" + a.shape + "\"", "one of " + all, nearestName(a.shape, names)});
  }
  const fs::path output = a.output.empty() ? fs::path(a.tool + ".toml") : fs::path(a.output);
  if (a.tool.empty() || a.tool.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") != std::string::npos)
    return complain(
        {Error::Code::kBadValue, "", "ID", "\"" + a.tool + "\"", "lower-case letters, digits and hyphens", "my-bur"});
  if (output.filename() != a.tool + ".toml")
    return complain({Error::Code::kBadValue, a.output, "--output", "another name than the id",
                     "a file called " + a.tool + ".toml: a tool's id is its file's name", ""});
  std::error_code ignored;
  if (fs::exists(output, ignored) && !a.overwrite)
    return complain({Error::Code::kWriteFailed, output.string(), "", "exists already", "a new file",
                     "another id, or --force to replace it"});
  auto toml = AtomicFile::create(output);
  if (!toml) return complain(toml.error());
  toml->stream() << toolTemplate(*shape, a.tool);
  if (const auto written = toml->commit(); !written) return complain(written.error());
  const std::string quoted = output.string();
  fmt::print("written: {0}\nedit it, then: kerf tool check {0}\n", quoted);
  return kOk;
}

}  // namespace

void addTool(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<Arguments>();
  CLI::App* c = app.add_subcommand("tool", "List, check, draw, start and bake tools");
  c->require_subcommand(1);

  CLI::App* l = c->add_subcommand("list", "Tools found in $KERF_ASSETS/tools and beside the program");
  l->footer("Example: kerf tool list pear");
  l->add_option("WORD", a->words, "only tools whose line holds all of these words");
  l->add_flag("--json", a->json, "as JSON on standard output");
  l->callback([a, &exit_code] { exit_code = list(*a); });

  CLI::App* i = c->add_subcommand("info", "A tool's numbers, its drive, and what its ISO 6360 code says");
  i->footer("Example: kerf tool info 856-016");
  i->add_option("ID|FILE", a->tool, "tool id or TOML file")->required();
  i->add_flag("--json", a->json, "as JSON on standard output");
  i->callback([a, &exit_code] { exit_code = info(*a); });

  CLI::App* k = c->add_subcommand("check", "Plunge tools into a block; compare what is gone with the closed formula");
  k->footer("Example: kerf tool check round-014 my-tool.toml");
  auto* ids = k->add_option("ID|FILE", a->tools, "tool ids or TOML files; several make a table");
  auto* all = k->add_flag("--all", a->all, "every tool there is");
  ids->excludes(all);
  k->add_option("--voxel", a->voxel, "mm; default: head diameter / 20, blades thickness / 10")
      ->check(CLI::PositiveNumber);
  k->add_flag("--json", a->json, "as JSON on standard output");
  k->callback([a, &exit_code] {
    if (a->tools.empty() && !a->all) throw CLI::RequiredError("ID|FILE or --all");
    exit_code = check(*a);
  });

  CLI::App* d = c->add_subcommand("draw", "Draw a tool with its dimensions (SVG)");
  d->footer("Example: kerf tool draw 856-016 -o 856-016.svg");
  d->add_option("ID|FILE", a->tool, "tool id or TOML file")->required();
  d->add_option("-o,--output", a->output, "SVG file to write; default: ID.svg");
  d->callback([a, &exit_code] { exit_code = draw(*a); });

  CLI::App* n = c->add_subcommand("new", "Write a tool file to start from, every key explained");
  n->footer("Example: kerf tool new my-taper --shape taper_round");
  n->add_option("ID", a->tool, "the new tool's id: lower-case letters, digits, hyphens")->required();
  n->add_option("--shape", a->shape, "shape of its head: round, taper_round, profile, ... (a wrong one lists all)")
      ->required();
  n->add_option("-o,--output", a->output, "file to write, named after the id; default: ID.toml here");
  n->add_flag("--force", a->overwrite, "replace an existing file");
  n->callback([a, &exit_code] { exit_code = makeNew(*a); });

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
