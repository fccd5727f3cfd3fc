#include "sim/run/files/run_output.h"

#include <fmt/format.h>

#include "geometry/base/atomic_file.h"
#include "geometry/base/hash.h"
#include "geometry/base/text.h"
#include "geometry/base/version.h"
#include "sim/monitor/monitor.h"

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

// Characters that TOML can hold.
bool isText(const std::string& bytes) {
  std::size_t at = 0;
  while (const std::size_t length = utf8Length(bytes, at)) at += length;
  return at == bytes.size();
}

}  // namespace

std::string neighbourKey(std::size_t beside) { return neighbourId(beside) + ".case_id"; }

Expected<void> requireAnother(const fs::path& from, const fs::path& run_folder) {
  std::error_code ignored;
  if (!fs::equivalent(from, run_folder, ignored)) return {};
  return fail({.code = Error::Code::kBadValue,
               .file = run_folder.string(),
               .found = "the run that it continues",
               .expected = "a new folder: Kerf never changes a run",
               .hint = "use another name after -o"});
}

Expected<std::string> storeBegin(const fs::path& from, const fs::path& run_folder) {
  KERF_TRY(before, readRunManifest(from));
  KERF_CHECK(copyFile(from / kRunField, run_folder / kRunBegin));
  KERF_CHECK(requireSha256(run_folder / kRunBegin, before.field_sha256, "the run that it continues is damaged"));
  return before.field_sha256;
}

Expected<std::string> relativeCasePath(const fs::path& case_folder, const fs::path& run_folder) {
  // Resolves links: ".." refers to the real folders.
  std::error_code ignored;
  const fs::path from = fs::weakly_canonical(fs::absolute(run_folder, ignored), ignored);
  const fs::path to = fs::weakly_canonical(fs::absolute(case_folder, ignored), ignored);
  const std::string path = to.lexically_relative(from).string();
  if (!isText(path))
    return fail({.code = Error::Code::kBadValue,
                 .file = case_folder.string(),
                 .place = "name",
                 .found = "bytes that are no UTF-8 text",
                 .expected = "a name in UTF-8",
                 .hint = "rename the folder"});
  return path;
}

void addMotions(const CutPath& path, RunManifest& m) {
  for (std::size_t s = 0; s + 1 < path.poses.size(); ++s) {
    if (!path.cuts[s]) continue;
    ++m.segments;
    m.path_length_mm += (path.poses[s + 1].T_object_tool.translation - path.poses[s].T_object_tool.translation).norm();
  }
}

std::string throughBox(const Box3& box) {
  return fmt::format("a path through the box ({:.2f}, {:.2f}, {:.2f}) to ({:.2f}, {:.2f}, {:.2f}) mm", box.min[0],
                     box.min[1], box.min[2], box.max[0], box.max[1], box.max[2]);
}

Expected<void> finishRun(const fs::path& staging, const Tool& tool, const fs::path& tool_file,
                         const fs::path& path_file, RunManifest& m) {
  m.kerf_version = kVersion;
  m.tool_id = tool.id;
  m.path_file = "path" + path_file.extension().string();

  // Hashes before copying: if a file changes meanwhile, readers reject the run instead of trusting a wrong hash.
  KERF_TRY(tool_hash, sha256OfFile(tool_file));
  KERF_TRY(path_hash, sha256OfFile(path_file));
  m.tool_sha256 = tool_hash;
  m.path_sha256 = path_hash;
  KERF_CHECK(copyFile(tool_file, staging / kRunToolCopy));
  if (!tool.companion.empty()) KERF_CHECK(copyFile(tool.companion, staging / tool.companion.filename()));
  KERF_CHECK(copyFile(path_file, staging / m.path_file));

  KERF_TRY(field_hash, sha256OfFile(staging / kRunField));
  m.field_sha256 = field_hash;
  KERF_TRY(summary_hash, sha256OfFile(staging / kRunSummary));
  m.summary_sha256 = summary_hash;
  return writeRunManifest(staging, m);
}

}  // namespace kerf::internal
