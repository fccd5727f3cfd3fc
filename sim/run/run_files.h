// What every kind of cut writes into its run folder.
#pragma once

#include <filesystem>
#include <string>

#include "geometry/tool/tool.h"
#include "sim/run/run_bundle.h"

namespace kerf::internal {

inline constexpr const char* kRunToolCopy = "tool.toml";
inline constexpr const char* kRunField = "run.vdb";
inline constexpr const char* kRunLog = "session.kerflog";
inline constexpr int kRunFormatVersion = 1;

/// Where the session log's header names the id of the n-th case beside the one cut.
std::string neighbourKey(std::size_t beside);

/// From the run to the case, so that both can be moved together. Error: a name that no TOML file can hold.
Expected<std::string> relativeCasePath(const std::filesystem::path& case_folder,
                                       const std::filesystem::path& run_folder);
/// Copies tool, its mesh and path into the staging folder, hashes run.vdb, fills in what the manifest says of them, and
/// writes it.
Expected<void> finishRun(const std::filesystem::path& staging, const Tool& tool, const std::filesystem::path& tool_file,
                         const std::filesystem::path& path_file, RunManifest& manifest);

}  // namespace kerf::internal
