// Reading tools: one strict TOML file per tool (assets/tools/README.md lists every key).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/tool/tool.h"

namespace kerf {

/// Reads one tool. Unknown keys, missing keys, values out of range, an ISO 6360 code that disagrees with the diameter:
/// errors with file, line, key, found and expected value (and the nearest known key).
Expected<Tool> readTool(const std::filesystem::path& file);
/// readTool() of a text that is in no file yet.   @param file  its future place: its name is the tool's id.
Expected<Tool> readToolText(const std::string& toml, const std::filesystem::path& file);

struct ToolListing {
  std::filesystem::path file;
  std::optional<Tool> tool;
  std::optional<Error> error;  ///< reading error of the file
};
/// Every *.toml in the folders, sorted by id; for an id in several folders the first. Skips missing folders.
std::vector<ToolListing> listTools(const std::vector<std::filesystem::path>& folders);

/// $KERF_ASSETS/tools, then beside the installed program, then the source tree this program was built from.
std::vector<std::filesystem::path> defaultToolFolders();

/// A tool's file by id (in the folders) or by path. kNotFound names the ids that resemble it.
Expected<std::filesystem::path> findToolFile(const std::string& id_or_path,
                                             const std::vector<std::filesystem::path>& folders);

}  // namespace kerf
