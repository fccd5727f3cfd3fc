#include "sim/run/run_output.h"

#include <fmt/format.h>

#include "geometry/base/hash.h"
#include "geometry/base/version.h"
#include "sim/monitor/monitor.h"

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

// What TOML can hold: well-formed UTF-8 (RFC 3629).
bool isText(const std::string& bytes) {
  for (std::size_t i = 0; i < bytes.size();) {
    const auto byte = [&](std::size_t at) { return at < bytes.size() ? static_cast<unsigned char>(bytes[at]) : 0u; };
    const unsigned first = byte(i);
    const std::size_t length = first < 0x80                    ? 1
                               : first >= 0xc2 && first < 0xe0 ? 2
                               : first >> 4 == 0xe             ? 3
                               : first >= 0xf0 && first < 0xf5 ? 4
                                                               : 0;
    if (length == 0) return false;
    for (std::size_t k = 1; k < length; ++k)
      if (byte(i + k) >> 6 != 2) return false;
    if ((first == 0xe0 && byte(i + 1) < 0xa0) || (first == 0xed && byte(i + 1) >= 0xa0) ||
        (first == 0xf0 && byte(i + 1) < 0x90) || (first == 0xf4 && byte(i + 1) >= 0x90))
      return false;
    i += length;
  }
  return true;
}

}  // namespace

std::string neighbourKey(std::size_t beside) { return neighbourId(beside) + ".case_id"; }

Expected<void> copyInto(const fs::path& from, const fs::path& to) {
  std::error_code failed;
  fs::copy_file(from, to, failed);
  if (failed)
    return fail({.code = Error::Code::kWriteFailed,
                 .file = to.string(),
                 .found = failed.message(),
                 .expected = "a writable place with room",
                 .hint = "free some space"});
  return {};
}

Expected<void> requireAnother(const fs::path& from, const fs::path& run_folder) {
  std::error_code ignored;
  if (!fs::equivalent(from, run_folder, ignored)) return {};
  return fail({.code = Error::Code::kBadValue,
               .file = run_folder.string(),
               .found = "the run it goes on from",
               .expected = "a new folder: a run is never changed",
               .hint = "another name behind -o"});
}

Expected<std::string> storeBegin(const fs::path& from, const fs::path& run_folder) {
  KERF_TRY(before, readRunManifest(from));
  KERF_CHECK(copyInto(from / kRunField, run_folder / kRunBegin));
  KERF_CHECK(requireSha256(run_folder / kRunBegin, before.field_sha256, "the run it goes on from is damaged"));
  return before.field_sha256;
}

Expected<std::string> relativeCasePath(const fs::path& case_folder, const fs::path& run_folder) {
  // Links are resolved: ".." goes by the real folders.
  std::error_code ignored;
  const fs::path from = fs::weakly_canonical(fs::absolute(run_folder, ignored), ignored);
  const fs::path to = fs::weakly_canonical(fs::absolute(case_folder, ignored), ignored);
  const std::string path = to.lexically_relative(from).string();
  if (!isText(path))
    return fail({.code = Error::Code::kBadValue,
                 .file = case_folder.string(),
                 .place = "name",
                 .found = "bytes that are no UTF-8 text",
                 .expected = "a name the run can note down",
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

  // Hashed before they are copied: a file that changes meanwhile makes a run that is refused, not one that lies.
  KERF_TRY(tool_hash, sha256OfFile(tool_file));
  KERF_TRY(path_hash, sha256OfFile(path_file));
  m.tool_sha256 = tool_hash;
  m.path_sha256 = path_hash;
  KERF_CHECK(copyInto(tool_file, staging / kRunToolCopy));
  if (tool.mesh) KERF_CHECK(copyInto(tool.mesh_file, staging / tool.mesh_file.filename()));
  KERF_CHECK(copyInto(path_file, staging / m.path_file));

  KERF_TRY(field_hash, sha256OfFile(staging / kRunField));
  m.field_sha256 = field_hash;
  KERF_TRY(summary_hash, sha256OfFile(staging / kRunSummary));
  m.summary_sha256 = summary_hash;
  return writeRunManifest(staging, m);
}

}  // namespace kerf::internal
