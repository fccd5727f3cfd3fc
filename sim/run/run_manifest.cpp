#include "sim/run/run_manifest.h"

#include <fmt/format.h>

#include <fstream>

#include "geometry/base/toml_reader.h"
#include "sim/monitor/monitor.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
constexpr int kRunFormatVersion = 1;

Expected<void> requireFormat(TomlTable& top, const fs::path& path) {
  const auto format = top.get<std::string>("format", "\"kerf-run\"");
  const auto version = top.get<std::int64_t>("version", "1");
  if (format == "kerf-run" && version == kRunFormatVersion) return {};
  return fail({.code = Error::Code::kUnsupported,
               .file = path.string(),
               .place = "key format / version",
               .found = fmt::format("{} version {}", format, version),
               .expected = fmt::format("kerf-run version {}", kRunFormatVersion),
               .hint = "cut again with this Kerf"});
}

Expected<void> readBeside(TomlTable& top, const fs::path& path, RunManifest& m) {
  const toml::array* tables = top.has("beside") ? top.tables("beside") : nullptr;
  if (!tables) return {};

  for (const toml::node& node : *tables) {
    if (!node.is_table()) continue;
    TomlTable t(*node.as_table(), path, neighbourId(m.beside.size() + 1));
    RunManifest::Beside b;
    b.case_path = t.get<std::string>("case_path", "a path");
    b.case_id = t.get<std::string>("case_id", "64 hexadecimal digits");
    b.voxel_mm = t.number("voxel_mm", 0.001, 100);
    b.removed_mm3 = t.number("removed_mm3", 0, 1e12, "mm3");
    KERF_CHECK(t.finish());
    m.beside.push_back(std::move(b));
  }
  return {};
}

}  // namespace

bool isRun(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_regular_file(folder / kRunManifest, ignored);
}

Expected<RunManifest> readRunManifest(const fs::path& folder) {
  const fs::path path = folder / kRunManifest;
  if (!isRun(folder))
    return fail({.code = Error::Code::kNotFound,
                 .file = folder.string(),
                 .found = "not a run bundle",
                 .expected = "a folder with run.toml",
                 .hint = "kerf cut CASE ... -o " + folder.string()});
  KERF_TRY(root, parseToml(path));
  TomlTable top(root, path, "");
  KERF_CHECK(requireFormat(top, path));

  RunManifest m;
  m.kerf_version = top.get<std::string>("kerf_version", "a string");
  m.case_path = top.get<std::string>("case_path", "a path");
  m.case_id = top.get<std::string>("case_id", "64 hexadecimal digits");
  m.mode = top.get<std::string>("mode", "\"geometry\" or \"haptic\"");
  if (m.mode != kModeGeometry && m.mode != kModeHaptic)
    top.reject("mode", "\"" + m.mode + "\"", "\"geometry\" or \"haptic\"");

  m.tool_id = top.get<std::string>("tool_id", "a tool");
  m.tool_sha256 = top.get<std::string>("tool_sha256", "64 hexadecimal digits");
  m.path_file = top.get<std::string>("path_file", "\"path.csv\" or \"path.toml\"");
  if (m.path_file != "path.csv" && m.path_file != "path.toml")
    top.reject("path_file", "\"" + m.path_file + "\"", "\"path.csv\" or \"path.toml\"");
  m.path_sha256 = top.get<std::string>("path_sha256", "64 hexadecimal digits");

  m.segments = static_cast<std::size_t>(top.get<std::int64_t>("segments", "a count"));
  m.path_length_mm = top.get<double>("path_length_mm", "mm");
  m.duration_s = top.get<double>("duration_s", "s");
  m.voxel_mm = top.number("voxel_mm", 0.001, 100);
  m.state_hash = top.get<std::string>("state_hash", "16 hexadecimal digits");
  m.field_sha256 = top.get<std::string>("field_sha256", "64 hexadecimal digits");

  KERF_CHECK(readBeside(top, path, m));
  if (!m.beside.empty() && m.mode != kModeHaptic) top.reject("beside", "in mode " + m.mode, "mode haptic");
  if (m.beside.size() >= kMostObjects)
    top.reject("beside", fmt::format("{} cases", m.beside.size()), fmt::format("at most {}", kMostObjects - 1));
  KERF_CHECK(top.finish());
  return m;
}

Expected<void> writeRunManifest(const fs::path& folder, const RunManifest& m) {
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
    return fail({.code = Error::Code::kWriteFailed,
                 .file = path.string(),
                 .found = "could not be written",
                 .expected = "a writable place with room",
                 .hint = "free some space"});
  return {};
}

}  // namespace kerf
