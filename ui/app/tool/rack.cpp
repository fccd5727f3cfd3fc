#include "ui/app/tool/rack.h"

#include <algorithm>
#include <map>
#include <system_error>
#include <utility>

#include "geometry/base/toml_reader.h"
#include "geometry/tool/tool_file.h"

namespace kerf {

namespace fs = std::filesystem;

namespace {

constexpr double kHeadUpTo = 4;          // mm from the tip
constexpr double kHeadTolerance = 0.05;  // mm

Mesh headOf(const Tool& tool) {
  Mesh out;
  for (const Vec3d& v : toolMesh(tool, kHeadTolerance).vertices)
    if (v[2] < kHeadUpTo) out.vertices.push_back(v);
  return out;
}

std::optional<fs::file_time_type> timeOf(const fs::path& file) {
  std::error_code failed;
  const auto out = fs::last_write_time(file, failed);
  return failed ? std::nullopt : std::optional(out);
}

// Mesh or outline named in a tool's file, which may be invalid. Empty: none.
fs::path companionOf(const fs::path& tool_file) {
  const auto root = parseToml(tool_file);
  for (const char* key : {"mesh", "profile_file"})
    if (const auto name = root ? (*root)[key].value<std::string>() : std::nullopt; name && !name->empty())
      return tool_file.parent_path() / *name;
  return {};
}

bool isIn(const Rack& rack, const fs::path& file) {
  return std::any_of(rack.tools.begin(), rack.tools.end(),
                     [&](const RackTool& known) { return known.tool.file == file; });
}

void keepBroken(Rack& rack, const fs::path& file, const Error& error, const ToolTimes& times) {
  rack.broken.push_back({file, error, times});
  rack.errors.push_back(error);
}

}  // namespace

ToolTimes timesOf(const fs::path& tool_file) {
  ToolTimes out{timeOf(tool_file), {}};
  if (const fs::path mesh = companionOf(tool_file); !mesh.empty()) out.mesh = timeOf(mesh);
  return out;
}

ToolTimes timesOf(const SessionTool& tool) {
  ToolTimes out{timeOf(tool.file), {}};
  if (!tool.tool.companion.empty()) out.mesh = timeOf(tool.tool.companion);
  return out;
}

RackTool rackTool(SessionTool tool, const ToolTimes& times) {
  Mesh head = headOf(tool.tool);
  const Plunge plunge = plungeOf(tool.tool);
  TouchPoints touches(tool.tool);
  return {std::move(tool), times, std::move(head), plunge, std::move(touches)};
}

const std::vector<std::string>& defaultTools() {
  static const std::vector<std::string> kTools = {
      "round-014", "round-010", "round-018", "us-330",  "856-016",
      "837-012",   "847-016",   "862-012",   "disc-22", "saw-reciprocating-25"};
  return kTools;
}

Expected<Rack> readRack(const std::vector<std::string>& names, const fs::path& own_folder, const Progress& progress) {
  Rack out;
  auto folders = defaultToolFolders();
  folders.push_back(own_folder);
  const bool is_whole = names.empty();

  // The named tools, or those for a first look.
  for (const std::string& name : is_whole ? defaultTools() : names) {
    if (!report(progress, 0, name)) return cancelled();
    const auto file = findToolFile(name, folders);
    if (!file) {
      out.errors.push_back(file.error());
      continue;
    }
    if (isIn(out, *file)) continue;
    const ToolTimes times = timesOf(*file);
    auto tool = readTool(*file);
    if (tool)
      out.tools.push_back(rackTool({*file, std::move(*tool)}, times));
    else if (!is_whole)  // for the whole rack see below
      keepBroken(out, *file, tool.error(), times);
  }
  if (!is_whole) return out;
  out.first_look = out.tools.size();

  // All other tools.
  std::map<fs::path, ToolTimes> times;
  for (const fs::path& folder : folders) {
    std::error_code failed;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed))
      if (entry->path().extension() == ".toml") times.emplace(entry->path(), timesOf(entry->path()));
  }
  for (ToolListing& listed : listTools(folders)) {
    if (!report(progress, 0.5, listed.file.string())) return cancelled();
    if (!listed.tool)
      keepBroken(out, listed.file, *listed.error, times[listed.file]);
    else if (!isIn(out, listed.file))
      out.tools.push_back(rackTool({listed.file, std::move(*listed.tool)}, times[listed.file]));
  }
  return out;
}

}  // namespace kerf
