#include "geometry/tool/tool_file.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "geometry/base/assets.h"
#include "geometry/tool/tool_kinds.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
constexpr const char* kCopyInRun = "tool.toml";  // a copy inside a run folder keeps its id

// Sorted by id. Of an id in several folders the first: the one that findToolFile() finds.
std::map<std::string, fs::path> toolFiles(const std::vector<fs::path>& folders) {
  std::map<std::string, fs::path> files;
  for (const fs::path& folder : folders) {
    std::error_code failed;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed))
      if (entry->path().extension() == ".toml") files.emplace(entry->path().stem().string(), entry->path());
  }
  return files;
}

Expected<Tool> toolOf(const toml::table& root, const fs::path& file) {
  TomlTable top(root, file, "");
  Tool tool;
  const auto format = top.get<std::string>("format", "\"kerf-tool\"");
  if (format != "kerf-tool") top.reject("format", "\"" + format + "\"", "\"kerf-tool\"");

  const auto version = top.get<std::int64_t>("version", "1");
  if (version != 1) top.reject("version", fmt::format("{}", version), "1");

  tool.id = top.get<std::string>("id", "the file's name without .toml");
  if (tool.id.empty() || tool.id.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") != std::string::npos)
    top.reject("id", "\"" + tool.id + "\"", "lower-case letters, digits and hyphens");
  tool.name = top.get<std::string>("name", "a name for people");
  tool.description = top.getOr<std::string>("description", "", "a text");

  const auto kind = top.get<std::string>("kind", "\"bur\", \"blade\" or \"mesh\"");
  if (kind == "bur") {
    tool.kind = ToolKind::kBur;
    readBur(top, file.parent_path(), tool);
  } else if (kind == "blade") {
    tool.kind = ToolKind::kBlade;
    readBlade(top, tool);
  } else if (kind == "mesh") {
    tool.kind = ToolKind::kMesh;
    readMeshTool(top, file.parent_path(), tool);
  } else {
    top.reject("kind", "\"" + kind + "\"", "\"bur\", \"blade\" or \"mesh\"",
               top.has("motion") || top.has("thickness") ? "\"blade\"" : "\"bur\", drills and discs of diamond too");
    allowBurKeys(top);
    allowBladeKeys(top);
    allowMeshKeys(top);
  }

  top.allow("drive");
  KERF_CHECK(top.finish());
  KERF_CHECK(readDrive(top, file, tool));

  // Last, so that a renamed copy of a tool reports its other errors first.
  if (file.filename() != kCopyInRun && file.stem() != tool.id) {
    const std::string stem = file.stem().string();
    top.reject("id", "\"" + tool.id + "\"", "the file's name, \"" + stem + "\"", "id = \"" + stem + "\"");
    KERF_CHECK(top.finish());
  }
  return tool;
}

}  // namespace

Expected<Tool> readTool(const fs::path& file) {
  KERF_TRY(root, parseToml(file));
  return toolOf(root, file);
}

Expected<Tool> readToolText(const std::string& toml, const fs::path& file) {
  KERF_TRY(root, parseTomlText(toml, file));
  return toolOf(root, file);
}

std::vector<ToolListing> listTools(const std::vector<fs::path>& folders) {
  std::vector<ToolListing> out;
  for (const auto& [id, file] : toolFiles(folders)) {
    ToolListing& listing = out.emplace_back();
    listing.file = file;
    if (auto tool = readTool(file))
      listing.tool = std::move(*tool);
    else
      listing.error = tool.error();
  }
  return out;
}

std::vector<fs::path> defaultToolFolders() { return findAssets("tools"); }

Expected<fs::path> findToolFile(const std::string& id_or_path, const std::vector<fs::path>& folders) {
  const fs::path path(id_or_path);
  std::error_code ignored;
  if (path.has_parent_path() || path.extension() == ".toml") {
    if (fs::is_regular_file(path, ignored)) return path;
    return fail({.code = Error::Code::kNotFound,
                 .file = id_or_path,
                 .found = "no such file",
                 .expected = "a tool's TOML file",
                 .hint = "kerf tool list"});
  }

  std::vector<std::string> ids;
  for (const fs::path& folder : folders)
    if (fs::path file = folder / (id_or_path + ".toml"); fs::is_regular_file(file, ignored)) return file;
  for (const auto& [id, file] : toolFiles(folders)) ids.push_back(id);

  // Ids that hold the word ("330" is in us-330), or that look like it.
  std::vector<std::string> like;
  for (const std::string& id : ids)
    if (!id_or_path.empty() && id.find(id_or_path) != id.npos && like.size() < 5) like.push_back(id);
  if (like.empty()) like = nearestNames(id_or_path, ids, 5);

  std::string near;
  for (const std::string& id : like) near += (near.empty() ? "" : ", ") + id;
  return fail({.code = Error::Code::kNotFound,
               .place = "tool " + id_or_path,
               .found = "no such tool",
               .expected = ids.empty() ? "a tools folder"
                                       : fmt::format("one of {} ids, or the path of a TOML file", ids.size()),
               .hint = ids.empty()    ? "set KERF_ASSETS to the folder that holds tools/"
                       : near.empty() ? "kerf tool list"
                                      : near + "; kerf tool list shows all"});
}

}  // namespace kerf
