#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "geometry/base/atomic_file.h"
#include "geometry/base/available_memory.h"
#include "geometry/base/toml_reader.h"
#include "geometry/catalogue/tool_catalogue.h"
#include "geometry/field/sample_field.h"
#include "geometry/field/vdb_io.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/tool/blade_motion.h"
#include "geometry/tool/head_shape.h"
#include "geometry/tool/tool_doubt.h"
#include "geometry/tool/tool_drawing.h"
#include "geometry/tool/tool_file.h"
#include "geometry/tool/tool_template.h"
#include "sim/run/sweep/tool_check.h"
#include "sim/step/tool_model.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;
constexpr const char* kToolCopy = "tool.toml";
constexpr const char* kMeshKind = "mesh";

// Options of all sub-commands; each reads its own.
struct ToolArguments {
  std::vector<std::string> tools;
  std::vector<std::string> words;
  std::string tool, output, shape;
  double voxel = 0;  // 0: defaultVoxel
  bool json = false, overwrite = false, all = false;
};

// True if a text holds a word, ignoring case.
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

int printRack(const ToolArguments& a) {
  const auto folders = defaultToolFolders();
  if (folders.empty())
    return complain({.code = Error::Code::kNotFound,
                     .found = "no tools folder",
                     .expected = "a folder assets/tools",
                     .hint = "set KERF_ASSETS to the folder that holds tools/"});

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
      if (shown++ == 0) printText("{:<22} {:<14} {:<14}  {:<15}  {}\n", "id", "shape", "D x L, mm", "ISO 6360", "name");
      printText("{}\n", line);
    }
  }

  if (a.json) printJson(tools);
  if (!a.json && shown == 0) printText("No tool matches; kerf tool list shows all.\n");
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

// By id or file.
Expected<Tool> toolNamed(const std::string& name) {
  KERF_TRY(file, findToolFile(name, defaultToolFolders()));
  return readTool(file);
}

void printDoubt(const Tool& tool) {
  if (const std::string doubt = doubtAbout(tool); !doubt.empty()) printText("  CHECK THIS: {}\n", doubt);
}

int info(const ToolArguments& a) {
  const auto tool = toolNamed(a.tool);
  if (!tool) return complain(tool.error());
  if (!a.json) {
    printText("{}\n  drive: {}\n", describe(*tool), describeDrive(*tool));
    printDoubt(*tool);
    return kOk;
  }
  nlohmann::json j = withDrive(*tool);
  if (const std::string doubt = doubtAbout(*tool); !doubt.empty()) j["doubt"] = doubt;
  printJson(j);
  return kOk;
}

nlohmann::json toolJson(const Tool& tool, const ToolCheck& c) {
  nlohmann::json j{{"id", tool.id},
                   {"voxel_mm", c.voxel_mm},
                   {"depth_mm", c.depth_mm},
                   {"block_width_mm", c.block_width_mm},
                   {"expected_mm3", c.expected_mm3},
                   {"removed_mm3", c.removed_mm3},
                   {"error_percent", c.errorPercent()},
                   {"passed", c.passed()}};
  if (const std::string doubt = doubtAbout(tool); !doubt.empty()) j["doubt"] = doubt;
  return j;
}

std::string verdict(const ToolCheck& c) {
  return c.passed() ? "PASS" : fmt::format("FAIL (allowed {} %)", ToolCheck::kLargestError);
}

void printHead() {
  printText("{:<22} {:>8} {:>9} {:>13} {:>13} {:>8}\n", "id", "deep, mm", "voxel, mm", "removed, mm3", "expected, mm3",
            "error, %");
}

void printRow(const Tool& tool, const ToolCheck& c) {
  printText("{:<22} {:>8.3g} {:>9.3g} {:>13.5f} {:>13.5f} {:>+8.3f}  {}\n", tool.id, c.depth_mm, c.voxel_mm,
            c.removed_mm3, c.expected_mm3, c.errorPercent(), verdict(c));
  printDoubt(tool);
}

void printTool(const Tool& tool, const ToolCheck& c) {
  const std::string block =
      c.block_width_mm > 0 ? fmt::format(" through {:.3g} mm of the blade", c.block_width_mm) : std::string();
  printText("{}\n", describe(tool));
  printText("  {:.3g} mm deep{}, voxel {:.3g} mm: removed {:.5f} mm3, by its numbers {:.5f} mm3, {:+.3f} %: {}\n",
            c.depth_mm, block, c.voxel_mm, c.removed_mm3, c.expected_mm3, c.errorPercent(), verdict(c));
  printDoubt(tool);
}

Expected<std::vector<fs::path>> filesToCheck(const ToolArguments& a) {
  std::vector<fs::path> files;
  if (a.all)
    for (const ToolListing& listing : listTools(defaultToolFolders())) files.push_back(listing.file);
  for (const std::string& name : a.tools) {
    KERF_TRY(file, findToolFile(name, defaultToolFolders()));
    files.push_back(std::move(file));
  }
  return files;
}

int check(const ToolArguments& a) {
  constexpr bool kWritesFiles = false;
  TerminalProgress terminal(kWritesFiles);
  const Progress show = terminal.callback();
  show(0, "looking for tools");
  const auto files = filesToCheck(a);
  terminal.clear();
  if (!files) return complain(files.error());

  const bool is_table = files->size() > 1;
  std::size_t done = 0, passed = 0;
  nlohmann::json results = nlohmann::json::array();
  for (const fs::path& file : *files) {
    const std::string name = file.stem().string();
    const auto of_all = [&, n = static_cast<double>(done++)](double fraction, std::string_view what) {
      return show((n + fraction) / static_cast<double>(files->size()), fmt::format("{}: {}", name, what));
    };
    of_all(0, "reading");
    const auto tool = readTool(file);
    const auto result = tool ? checkTool(*tool, a.voxel, of_all) : Expected<ToolCheck>(fail(tool.error()));
    terminal.clear();
    if (!result) {
      complain(result.error());
      if (!a.all) return kFailed;
      continue;
    }
    passed += result->passed();
    if (a.json) {
      results.push_back(toolJson(*tool, *result));
    } else if (is_table) {
      if (file == files->front()) printHead();
      printRow(*tool, *result);
    } else {
      printTool(*tool, *result);
    }
  }

  if (a.json)
    printJson(results);
  else if (is_table)
    printText("{} of {} tools pass.\n", passed, files->size());
  return passed == files->size() ? kOk : kFailed;
}

// Memory of its bricks during writing: sampled, and once more as OpenVDB's leaves.
Expected<void> requireMemory(const Tool& tool, double voxel, const Progress& progress) {
  constexpr std::uint64_t kBrickBytes = 5000;
  const std::uint64_t most = internal::availableMemory() / 5 * 4;
  std::size_t left = static_cast<std::size_t>(most / kBrickBytes);
  for (const ToolShape* shape : {tool.cut.get(), tool.body.get()})
    if (shape)
      left -= std::min(left, countSampledBricks([&](const Vec3d& p) { return shape->distance(p); }, shape->bounds(),
                                                voxel, left, progress));
  if (left > 0) return {};
  return fail(
      {.code = Error::Code::kUnsupported,
       .file = tool.id,
       .place = "--voxel",
       .found = fmt::format("{:.3g} mm: more than {:.1f} GB of bricks", voxel, 1e-9 * static_cast<double>(most)),
       .expected = "a field that fits into the free memory",
       .hint = fmt::format("--voxel {:.2g}", std::min(2 * voxel, 1.0))});
}

Expected<void> write(const ToolArguments& a, const fs::path& file, const Tool& tool, double voxel) {
  TerminalProgress terminal;
  bool is_cancelled = false;
  const Progress progress = [&is_cancelled, show = terminal.callback()](double done, std::string_view what) {
    return is_cancelled ? false : !(is_cancelled = !show(done, what));
  };
  KERF_CHECK(requireMemory(tool, voxel, progress));
  KERF_TRY(folder, AtomicFolder::create(a.output, a.overwrite, kToolCopy));
  KERF_CHECK(copyFile(file, folder.staging() / kToolCopy));
  if (!tool.companion.empty()) KERF_CHECK(copyFile(tool.companion, folder.staging() / tool.companion.filename()));

  const auto sampled = [&](const ToolShape& shape) {
    return sampleDistance([&](const Vec3d& p) { return shape.distance(p); }, shape.bounds(), voxel, 4, progress);
  };
  const BrickField cut = sampled(*tool.cut);
  const BrickField body = tool.body ? sampled(*tool.body) : BrickField();
  if (!report(progress, 1, "writing")) return cancelledBeforeWriting();
  std::vector<NamedField> fields{{"cut", &cut}};
  if (tool.body) fields.push_back({"body", &body});
  KERF_CHECK(writeVdb(folder.staging() / "tool.vdb", fields, {{"tool_id", tool.id}}));
  KERF_CHECK(writeMesh(folder.staging() / "tool.ply", toolMesh(tool)));
  return folder.commit();
}

int bake(const ToolArguments& a) {
  const auto file = findToolFile(a.tool, defaultToolFolders());
  if (!file) return complain(file.error());
  const auto tool = readTool(*file);
  if (!tool) return complain(tool.error());
  const double voxel = a.voxel == 0 ? defaultVoxel(*tool) : a.voxel;
  if (!(voxel >= 0.001 && voxel <= 1))  // the default follows the tool
    return complain({.code = Error::Code::kBadValue,
                     .place = "--voxel",
                     .found = fmt::format("{} mm", voxel),
                     .expected = "0.005 to 1 mm"});

  if (const auto written = write(a, *file, *tool, voxel); !written) return complain(written.error());
  printText("{} baked at {:.3g} mm voxels: {}\n", tool->id, voxel, a.output);
  return kOk;
}

int draw(const ToolArguments& a) {
  const auto tool = toolNamed(a.tool);
  if (!tool) return complain(tool.error());
  const fs::path output = a.output.empty() ? fs::path(tool->id + ".svg") : fs::path(a.output);
  if (const auto free = requireFree(output, a.overwrite); !free) return complain(free.error());
  auto svg = AtomicFile::create(output);
  if (!svg) return complain(svg.error());
  svg->stream() << toolDrawing(*tool);
  if (const auto written = svg->commit(); !written) return complain(written.error());
  printText("drawn: {}\n", output.string());
  return kOk;
}

// The text of a new tool file: a bur by its head, a blade by its motion, a mesh.
Expected<std::string> newToolText(const std::string& name, const std::string& id) {
  if (const HeadShape* shape = findHeadShape(name)) return toolTemplate(*shape, id);
  if (const BladeMotion* motion = findBladeMotion(name)) return bladeTemplate(*motion, id);
  if (name == kMeshKind) return meshToolTemplate(id + ".stl", id);

  std::vector<std::string> names;
  std::string all;
  for (const HeadShape& s : headShapes()) {
    names.emplace_back(s.name);
    all += (all.empty() ? "" : ", ") + names.back();
  }
  for (const BladeMotion* motion : bladeMotions()) {
    names.emplace_back(motion->name);
    all += ", " + names.back();
  }
  names.emplace_back(kMeshKind);
  all += std::string(" or ") + kMeshKind;
  const std::string near = nearestName(name, names);
  return fail({.code = Error::Code::kBadValue,
               .place = "--shape",
               .found = "\"" + name + "\"",
               .expected = "one of " + all,
               .hint = !near.empty() ? near : "reciprocating, sagittal or piezo for a saw, spin for a disc"});
}

// Checks that a tool of that id can be written to that file: the id is the file's name.
Expected<void> requireUsable(const std::string& id, const fs::path& output, bool overwrite) {
  if (id.empty() || id.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") != std::string::npos)
    return fail({.code = Error::Code::kBadValue,
                 .place = "ID",
                 .found = "\"" + id + "\"",
                 .expected = "lower-case letters, digits and hyphens",
                 .hint = "my-bur"});
  if (output.filename() != id + ".toml")
    return fail({.code = Error::Code::kBadValue,
                 .file = output.string(),
                 .place = "--output",
                 .found = "another name than the id",
                 .expected = "a file called " + id + ".toml: a tool's id is its file's name"});
  std::error_code ignored;
  if (fs::exists(output, ignored) && !overwrite)
    return fail({.code = Error::Code::kWriteFailed,
                 .file = output.string(),
                 .found = "exists already",
                 .expected = "a new file",
                 .hint = "another id, or --overwrite to replace it"});
  return {};
}

int makeNew(const ToolArguments& a) {
  const auto text = newToolText(a.shape, a.tool);
  if (!text) return complainOfUsage(text.error());
  const fs::path output = a.output.empty() ? fs::path(a.tool + ".toml") : fs::path(a.output);
  if (const auto usable = requireUsable(a.tool, output, a.overwrite); !usable)
    return usable.error().code == Error::Code::kBadValue ? complainOfUsage(usable.error()) : complain(usable.error());

  auto toml = AtomicFile::create(output);
  if (!toml) return complain(toml.error());
  toml->stream() << *text;
  if (const auto written = toml->commit(); !written) return complain(written.error());
  printText("written: {0}\nedit it, then: kerf tool check {0}\n", output.string());
  return kOk;
}

nlohmann::json importJson(const CatalogueImport& imported, const std::string& folder) {
  nlohmann::json j{{"folder", folder},
                   {"columns_as_comments", imported.remarks},
                   {"written", nlohmann::json::array()},
                   {"refused", nlohmann::json::array()}};
  for (const CatalogueImport::Written& w : imported.written) {
    j["written"].push_back({{"row", w.row}, {"id", w.id}, {"file", w.file.string()}});
    if (!w.doubt.empty()) j["written"].back()["doubt"] = w.doubt;
  }
  for (const CatalogueImport::Refused& r : imported.refused)
    j["refused"].push_back({{"row", r.row},
                            {"name", r.name},
                            {"column", r.column},
                            {"found", r.found},
                            {"expected", r.expected},
                            {"hint", r.hint}});
  return j;
}

// Columns as wide as their longest cell, the last one of any width.
void printTable(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t n = 0; n < row.size(); ++n) widths[n] = std::max(widths[n], row[n].size());
  }
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t n = 0; n < row.size(); ++n)
      line += fmt::format("{:<{}}  ", row[n], n + 1 < row.size() ? widths[n] : 0);
    printText("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
  }
}

int importTools(const ToolArguments& a) {
  TerminalProgress terminal;
  const auto imported = importCatalogue(a.tool, a.output, a.overwrite, terminal.callback());
  terminal.clear();
  if (!imported) return complain(imported.error());
  const int exit_code = imported->refused.empty() ? kOk : kFailed;
  if (a.json) {
    printJson(importJson(*imported, a.output));
    return exit_code;
  }

  for (const CatalogueImport::Written& w : imported->written)
    if (!w.doubt.empty()) printText("row {}, {}: CHECK THIS: {}\n", w.row, w.id, w.doubt);
  if (!imported->remarks.empty())
    printText("columns that are no keys, kept as comments: {}\n", fmt::join(imported->remarks, ", "));
  if (!imported->refused.empty()) {
    std::vector<std::vector<std::string>> rows{{"row", "name", "column", "found", "expected"}};
    for (const CatalogueImport::Refused& r : imported->refused)
      rows.push_back({fmt::format("{}", r.row), r.name, r.column, r.found,
                      r.hint.empty() ? r.expected : r.expected + ". Try: " + r.hint});
    printText("refused:\n");
    printTable(rows);
  }
  printText("written: {} of {} tools into {}\n", imported->written.size(),
            imported->written.size() + imported->refused.size(), a.output);
  return exit_code;
}

}  // namespace

void addTool(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<ToolArguments>();
  command.footer("Example: kerf tool list pear");
  command.require_subcommand(1);

  CLI::App* l = command.add_subcommand("list", "List the tools in $KERF_ASSETS/tools and next to the program");
  l->footer("Example: kerf tool list pear");
  l->add_option("WORD", a->words, "list only tools whose line contains all these words");
  l->add_flag("--json", a->json, "print JSON on standard output");
  l->callback([a, &exit_code] { exit_code = printRack(*a); });

  CLI::App* i = command.add_subcommand("info", "Show dimensions, drive and ISO 6360 code of a tool");
  i->footer("Example: kerf tool info 856-016");
  i->add_option("ID|FILE", a->tool, "tool id or TOML file")->required();
  i->add_flag("--json", a->json, "print JSON on standard output");
  i->callback([a, &exit_code] { exit_code = info(*a); });

  CLI::App* k =
      command.add_subcommand("check", "Plunge tools into a block; compare the removed volume with the closed formula");
  k->footer("Example: kerf tool check round-014 my-tool.toml");
  auto* ids = k->add_option("ID|FILE", a->tools, "tool ids or TOML files; several make a table");
  auto* all = k->add_flag("--all", a->all, "check all tools");
  ids->excludes(all);
  k->add_option("--voxel", a->voxel, "mm; default: head diameter / 20, blades thickness / 10")
      ->check(CLI::PositiveNumber);
  k->add_flag("--json", a->json, "print JSON on standard output");
  k->callback([a, &exit_code] {
    if (a->tools.empty() && !a->all) throw CLI::RequiredError("ID|FILE or --all");
    exit_code = check(*a);
  });

  CLI::App* d = command.add_subcommand("draw", "Draw a tool with its dimensions (SVG)");
  d->footer("Example: kerf tool draw 856-016 -o 856-016.svg");
  d->add_option("ID|FILE", a->tool, "tool id or TOML file")->required();
  d->add_option("-o,--output", a->output, "SVG file to write; default: ID.svg");
  addOverwrite(*d, a->overwrite, "replace an existing picture");
  d->callback([a, &exit_code] { exit_code = draw(*a); });

  CLI::App* n = command.add_subcommand("new", "Write a tool file to start from, every key explained");
  n->footer("Example: kerf tool new my-taper --shape taper_round");
  n->add_option("ID", a->tool, "the new tool's id: lower-case letters, digits, hyphens")->required();
  n->add_option("--shape", a->shape,
                "shape of its head: round, taper_round, profile, ...; of a saw or a disc its motion: reciprocating, "
                "sagittal, piezo, spin; or mesh (a wrong one lists all)")
      ->required();
  n->add_option("-o,--output", a->output, "file to write, named after the id; default: ID.toml here");
  addOverwrite(*n, a->overwrite, "replace an existing file");
  n->callback([a, &exit_code] { exit_code = makeNew(*a); });

  CLI::App* m = command.add_subcommand("import", "Write a tool file for each bur of a catalogue (CSV)");
  m->footer("Example: kerf tool import catalogue.csv -o my-tools");
  m->add_option("CSV", a->tool,
                "table in UTF-8 whose first row names its columns: keys of a bur file, lengths in mm; or iso6360")
      ->required();
  m->add_option("-o,--output", a->output, "folder for the files, made if missing")->required();
  addOverwrite(*m, a->overwrite, "replace existing files");
  m->add_flag("--json", a->json, "print JSON on standard output");
  m->callback([a, &exit_code] { exit_code = importTools(*a); });

  CLI::App* b = command.add_subcommand("bake", "Write a tool's distance fields (OpenVDB) and its mesh into a folder");
  b->footer("Example: kerf tool bake round-014 -o round-014.tool");
  b->add_option("ID|FILE", a->tool, "tool id or TOML file")->required();
  b->add_option("-o,--output", a->output, "folder to write")->required();
  b->add_option("--voxel", a->voxel, "mm; default: head diameter / 20, blades thickness / 10")
      ->check(CLI::Range(0.005, 1.0));
  addOverwrite(*b, a->overwrite, "replace an existing folder of a baked tool");
  b->callback([a, &exit_code] { exit_code = bake(*a); });
}

}  // namespace kerf::cli
