#include "sim/run/run_files.h"

#include <fmt/format.h>

#include <fstream>

#include "geometry/base/hash.h"
#include "geometry/base/toml_reader.h"
#include "geometry/base/version.h"
#include "sim/monitor/monitor.h"

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

Expected<void> writeManifest(const fs::path& folder, const RunManifest& m) {
  toml::table root{
      {"format", "kerf-run"},
      {"version", kRunFormatVersion},
      {"kerf_version", m.kerf_version},
      {"case_path", m.case_path},
      {"case_id", m.case_id},
      {"mode", m.mode},
      {"tool_id", m.tool_id},
      {"tool_sha256", m.tool_sha256},
      {"path_file", m.path_file},
      {"path_sha256", m.path_sha256},
      {"segments", static_cast<std::int64_t>(m.segments)},
      {"path_length_mm", m.path_length_mm},
      {"duration_s", m.duration_s},
      {"voxel_mm", m.voxel_mm},
      {"state_hash", m.state_hash},
      {"field_sha256", m.field_sha256},
  };
  if (!m.beside.empty()) {
    toml::array beside;
    for (const RunManifest::Beside& b : m.beside)
      beside.push_back(toml::table{{"case_path", b.case_path},
                                   {"case_id", b.case_id},
                                   {"voxel_mm", b.voxel_mm},
                                   {"removed_mm3", b.removed_mm3}});
    root.insert("beside", std::move(beside));
  }
  const fs::path path = folder / kRunManifest;
  std::ofstream out(path, std::ios::binary);
  out << "# Kerf run. Lengths in mm, times in s. Training and lab tool, not a medical device.\n" << root << "\n";
  out.close();
  if (!out)
    return fail({Error::Code::kWriteFailed, path.string(), "", "could not be written", "a writable place with room",
                 "free some space"});
  return {};
}

Expected<void> copyInto(const fs::path& from, const fs::path& to) {
  std::error_code failed;
  fs::copy_file(from, to, failed);
  if (failed)
    return fail({Error::Code::kWriteFailed, to.string(), "", failed.message(), "a writable place with room",
                 "free some space"});
  return {};
}

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

Expected<std::string> relativeCasePath(const fs::path& case_folder, const fs::path& run_folder) {
  // Links are resolved: ".." goes by the real folders.
  std::error_code ignored;
  const fs::path from = fs::weakly_canonical(fs::absolute(run_folder, ignored), ignored);
  const fs::path to = fs::weakly_canonical(fs::absolute(case_folder, ignored), ignored);
  const std::string path = to.lexically_relative(from).string();
  if (!isText(path))
    return fail({Error::Code::kBadValue, case_folder.string(), "name", "bytes that are no UTF-8 text",
                 "a name the run can note down", "rename the folder"});
  return path;
}

Expected<void> finishRun(const fs::path& staging, const Tool& tool, const fs::path& tool_file,
                         const fs::path& path_file, RunManifest& m) {
  m.kerf_version = kVersion;
  m.tool_id = tool.id;
  m.path_file = "path" + path_file.extension().string();
  KERF_TRY(tool_hash, sha256OfFile(tool_file));
  KERF_TRY(path_hash, sha256OfFile(path_file));
  m.tool_sha256 = tool_hash;
  m.path_sha256 = path_hash;
  KERF_CHECK(copyInto(tool_file, staging / kRunToolCopy));
  if (tool.mesh) KERF_CHECK(copyInto(tool.mesh_file, staging / tool.mesh_file.filename()));
  KERF_CHECK(copyInto(path_file, staging / m.path_file));
  KERF_TRY(field_hash, sha256OfFile(staging / kRunField));
  m.field_sha256 = field_hash;
  return writeManifest(staging, m);
}

}  // namespace kerf::internal
