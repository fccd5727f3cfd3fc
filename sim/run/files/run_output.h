// Output of every kind of cut into its run folder: names of the files, copies of the inputs, the manifest.
#pragma once

#include <filesystem>
#include <string>

#include "geometry/tool/tool.h"
#include "sim/hand/path.h"
#include "sim/run/files/run_manifest.h"

namespace kerf::internal {

inline constexpr const char* kRunToolCopy = "tool.toml";
inline constexpr const char* kRunField = "run.vdb";
inline constexpr const char* kRunBegin = "begin.vdb";
inline constexpr const char* kRunLog = "session.kerflog";
inline constexpr const char* kRunForces = "forces.csv";
inline constexpr const char* kRunSummary = "summary.json";
inline constexpr std::size_t kMostSummaryBytes = 1 << 20;  // usual: some kB

/// Key in the session log's header for the id of the n-th neighbour.
std::string neighbourKey(std::size_t beside);

/// The case's folder as seen from the run, so that both can be moved together. Error: a name that TOML cannot hold.
Expected<std::string> relativeCasePath(const std::filesystem::path& case_folder,
                                       const std::filesystem::path& run_folder);

/// Counts the cutting motions of a path and adds up their length: `segments` and `path_length_mm` of the manifest.
void addMotions(const CutPath& path, RunManifest& manifest);

/// Text for a path that cut nothing: "a path through the box (...) to (...) mm".
std::string throughBox(const Box3& box);

/// Error kBadValue: the new run would replace the run that it continues.
Expected<void> requireAnother(const std::filesystem::path& from, const std::filesystem::path& run_folder);

/// Copies the field of an ended run into the folder of the run that continues it. @return its hash. Errors:
/// kWriteFailed; kBadValue for a damaged field.
Expected<std::string> storeBegin(const std::filesystem::path& from, const std::filesystem::path& run_folder);

/// Copies the tool, its mesh and the path into the staging folder, hashes run.vdb and summary.json, and writes the
/// manifest with these values.
Expected<void> finishRun(const std::filesystem::path& staging, const Tool& tool, const std::filesystem::path& tool_file,
                         const std::filesystem::path& path_file, RunManifest& manifest);

/// The error of a cut or an export that was cancelled.
inline tl::unexpected<Error> nothingWritten() {
  return fail({.code = Error::Code::kCancelled, .found = "cancelled; nothing was written"});
}

}  // namespace kerf::internal
