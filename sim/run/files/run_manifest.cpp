#include "sim/run/files/run_manifest.h"

#include <fmt/format.h>

#include "geometry/base/atomic_file.h"
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
    b.name = t.getOr<std::string>("name", "", "a name");
    b.has_begin = t.getOr<bool>("has_begin", false, "true or false");
    if (b.has_begin && m.begin_sha256.empty()) t.reject("has_begin", "true", "a session that continues another run");
    KERF_CHECK(t.finish());
    m.beside.push_back(std::move(b));
  }
  return {};
}

// Inputs of a run along a path.
void readToolAndPath(TomlTable& top, RunManifest& m) {
  m.tool_id = top.get<std::string>("tool_id", "a tool");
  m.tool_sha256 = top.get<std::string>("tool_sha256", "64 hexadecimal digits");
  m.path_file = top.get<std::string>("path_file", "\"path.csv\" or \"path.toml\"");
  if (m.path_file != "path.csv" && m.path_file != "path.toml")
    top.reject("path_file", "\"" + m.path_file + "\"", "\"path.csv\" or \"path.toml\"");
  m.path_sha256 = top.get<std::string>("path_sha256", "64 hexadecimal digits");
  m.segments = static_cast<std::size_t>(top.number("segments", 0, 1e12, "motions"));
  m.path_length_mm = top.number("path_length_mm", 0, 1e9, "mm");
}

bool isInFolder(const std::string& file) {
  const fs::path path(file);
  return !path.empty() && path.is_relative() && *path.lexically_normal().begin() != "..";
}

Expected<void> readEarlier(TomlTable& top, const fs::path& path, RunManifest& m) {
  const toml::array* tables = top.has("earlier") ? top.tables("earlier") : nullptr;
  if (!tables) return {};

  for (const toml::node& node : *tables) {
    if (!node.is_table()) continue;
    TomlTable t(*node.as_table(), path, fmt::format("earlier {}", m.earlier.size() + 1));
    RunManifest::EarlierCut cut;
    cut.tool_id = t.get<std::string>("tool_id", "a tool");
    cut.tool_file = t.get<std::string>("tool_file", "a file in the run folder");
    cut.tool_sha256 = t.get<std::string>("tool_sha256", "64 hexadecimal digits");
    cut.path_file = t.get<std::string>("path_file", "a file in the run folder");
    cut.path_sha256 = t.get<std::string>("path_sha256", "64 hexadecimal digits");
    if (!isInFolder(cut.tool_file)) t.reject("tool_file", "\"" + cut.tool_file + "\"", "a file in the run folder");
    if (!isInFolder(cut.path_file)) t.reject("path_file", "\"" + cut.path_file + "\"", "a file in the run folder");
    KERF_CHECK(t.finish());
    m.earlier.push_back(std::move(cut));
  }
  return {};
}

Expected<void> readPlaneSides(TomlTable& of_piece, const fs::path& path, RunManifest::Piece& piece) {
  const toml::array* tables = of_piece.has("plane_cut") ? of_piece.tables("plane_cut") : nullptr;
  if (!tables) return {};
  for (const toml::node& node : *tables) {
    if (!node.is_table()) continue;
    const std::string name = fmt::format("plane cut {} of a piece", piece.sides.size() + 1);
    TomlTable t(*node.as_table(), path, name);
    PlaneSide side;
    side.cut = static_cast<std::uint32_t>(t.number("cut", 0, 4e9, "a count"));
    const std::string of = t.get<std::string>("side", "\"above\" or \"rest\"");
    if (of != "above" && of != "rest") t.reject("side", "\"" + of + "\"", "\"above\" or \"rest\"");
    side.is_above = of == "above";
    side.planes.kerf_mm = t.number("kerf_mm", 0, CutPlanes::kMostKerf, "mm");
    const auto count = static_cast<std::size_t>(t.number("planes", 0, CutPlanes::kMost, "a count"));
    std::vector<double> numbers, hole;
    if (count > 0) numbers = t.numbers("normals_and_points", 6 * count);
    if (t.has("hole")) hole = t.numbers("hole", side.planes.hole_numbers.size());
    KERF_CHECK(t.finish());
    std::copy(hole.begin(), hole.end(), side.planes.hole_numbers.begin());
    for (std::size_t n = 0; n < 6 * count; ++n) side.planes.numbers[n / 6][n % 6] = numbers[n];
    side.planes.count = static_cast<std::uint32_t>(count);
    if (!side.planes.isUsable())
      return fail({.code = Error::Code::kUnsupported,
                   .file = path.string(),
                   .place = name,
                   .found = "a normal that is no unit vector, or a number out of range",
                   .expected = "planes or a hole with unit vectors, and points below 1e5 mm",
                   .hint = "cut again; runs must not be edited"});
    piece.sides.push_back(side);
  }
  return {};
}

// Results and tools of a person's session.
Expected<void> readPieces(TomlTable& top, const fs::path& path, RunManifest& m) {
  const toml::array* tables = top.has("piece") ? top.tables("piece") : nullptr;
  if (!tables) return {};

  for (const toml::node& node : *tables) {
    if (!node.is_table()) continue;
    TomlTable t(*node.as_table(), path, fmt::format("piece {}", m.pieces.size() + 1));
    RunManifest::Piece piece;
    piece.id = static_cast<std::uint32_t>(t.number("id", 0, 4e9, "a count"));
    piece.name = t.get<std::string>("name", "a name");
    piece.colour = t.getOr<std::string>("colour", "", "the name of a colour");
    piece.volume_mm3 = t.number("volume_mm3", 0, 1e12, "mm3");
    const std::vector<double> inside = t.numbers("inside", 3), translation = t.numbers("translation", 3),
                              rotation = t.numbers("rotation", 4);
    KERF_CHECK(readPlaneSides(t, path, piece));
    KERF_CHECK(t.finish());

    piece.inside = {inside[0], inside[1], inside[2]};
    piece.T_case_piece.translation = {translation[0], translation[1], translation[2]};
    piece.T_case_piece.rotation = {rotation[0], rotation[1], rotation[2], rotation[3]};
    Rigid3 at_inside;
    at_inside.translation = piece.inside;
    if (!at_inside.isUsable())
      top.reject("piece", fmt::format("piece {}: inside is out of range", m.pieces.size() + 1), "mm below 1e5");
    if (!piece.T_case_piece.isUsable())
      top.reject("piece", fmt::format("piece {}: a pose that cannot be computed with", m.pieces.size() + 1),
                 "mm below 1e5, and a unit quaternion w x y z");
    m.pieces.push_back(std::move(piece));
  }
  return {};
}

Expected<void> readTools(TomlTable& top, const fs::path& path, RunManifest& m) {
  m.is_open = top.get<bool>("is_open", "true or false");
  m.tool_id = top.get<std::string>("tool_id", "tools");
  const toml::array* tables = top.tables("tool");
  if (!tables) return top.finish();

  for (const toml::node& node : *tables) {
    if (!node.is_table()) continue;
    TomlTable t(*node.as_table(), path, fmt::format("tool {}", m.tools.size() + 1));
    RunManifest::ToolFile tool;
    tool.id = t.get<std::string>("id", "a tool");
    tool.file = t.get<std::string>("file", "a file in the run folder");
    tool.sha256 = t.get<std::string>("sha256", "64 hexadecimal digits");
    if (!isInFolder(tool.file)) t.reject("file", "\"" + tool.file + "\"", "a file in the run folder");
    KERF_CHECK(t.finish());
    m.tools.push_back(std::move(tool));
  }
  if (m.tools.empty()) top.reject("tool", "none", "at least one [[tool]]: a session has a current tool");
  return {};
}

}  // namespace

bool RunManifest::Piece::isMoved() const {
  return T_case_piece.translation != Vec3d::Zero() || T_case_piece.rotation.vec() != Vec3d::Zero();
}

bool isRun(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_regular_file(folder / kRunManifest, ignored);
}

namespace {

// Error for a path that is no run, with a hint.
Error noRun(const fs::path& folder) {
  std::error_code ignored;
  Error out{.code = Error::Code::kNotFound,
            .file = folder.string(),
            .found = "not a run bundle",
            .expected = "a folder with run.toml",
            .hint = "make one with kerf cut CASE ... -o RUN"};
  if (!fs::exists(folder, ignored))
    out.found = "no such folder: not a run bundle";
  else if (fs::exists(folder / "case.toml", ignored))
    out = {.code = Error::Code::kNotFound,
           .file = folder.string(),
           .found = "a case, not a run bundle",
           .expected = "a run that was cut from it: a folder with run.toml",
           .hint = "kerf cut " + folder.string() + " ... -o RUN"};
  return out;
}

}  // namespace

Expected<RunManifest> readRunManifest(const fs::path& folder) {
  const fs::path path = folder / kRunManifest;
  if (!isRun(folder)) return fail(noRun(folder));
  KERF_TRY(root, parseToml(path));
  TomlTable top(root, path, "");
  KERF_CHECK(requireFormat(top, path));

  RunManifest m;
  m.kerf_version = top.get<std::string>("kerf_version", "a string");
  m.case_path = top.get<std::string>("case_path", "a path");
  m.case_id = top.get<std::string>("case_id", "64 hexadecimal digits");
  const char* const modes = "\"geometry\", \"haptic\" or \"session\"";
  m.mode = top.get<std::string>("mode", modes);
  if (m.mode == kModeSession)
    KERF_CHECK(readTools(top, path, m));
  else if (m.mode == kModeGeometry || m.mode == kModeHaptic)
    readToolAndPath(top, m);
  else
    top.reject("mode", "\"" + m.mode + "\"", modes);

  m.summary_sha256 = top.getOr<std::string>("summary_sha256", "", "64 hexadecimal digits");
  m.begin_sha256 = top.getOr<std::string>("begin_sha256", "", "64 hexadecimal digits");
  m.duration_s = top.number("duration_s", 0, 1e9, "s");
  m.voxel_mm = top.number("voxel_mm", 0.001, 100);
  m.state_hash = top.get<std::string>("state_hash", "16 hexadecimal digits");
  m.field_sha256 = top.get<std::string>("field_sha256", "64 hexadecimal digits");

  KERF_CHECK(readPieces(top, path, m));
  KERF_CHECK(readBeside(top, path, m));
  if (m.mode == kModeGeometry) KERF_CHECK(readEarlier(top, path, m));
  if (!m.beside.empty() && m.hasSweep())
    top.reject("beside", "in mode " + m.mode, "mode haptic or session, or a run that continues such a run");
  if (m.beside.size() >= kMostObjects)
    top.reject("beside", fmt::format("{} cases", m.beside.size()), fmt::format("at most {}", kMostObjects - 1));
  KERF_CHECK(top.finish());
  return m;
}

Expected<void> writeRunManifest(const fs::path& folder, const RunManifest& m) {
  toml::table root{
      {"format", "kerf-run"},       {"version", kRunFormatVersion},   {"kerf_version", m.kerf_version},
      {"case_path", m.case_path},   {"case_id", m.case_id},           {"mode", m.mode},
      {"tool_id", m.tool_id},       {"duration_s", m.duration_s},     {"voxel_mm", m.voxel_mm},
      {"state_hash", m.state_hash}, {"field_sha256", m.field_sha256},
  };
  if (!m.begin_sha256.empty()) root.insert("begin_sha256", m.begin_sha256);
  if (!m.summary_sha256.empty()) root.insert("summary_sha256", m.summary_sha256);
  if (m.mode == kModeSession) {
    root.insert("is_open", m.is_open);
    toml::array tools;
    for (const RunManifest::ToolFile& t : m.tools)
      tools.push_back(toml::table{{"id", t.id}, {"file", t.file}, {"sha256", t.sha256}});
    root.insert("tool", std::move(tools));
  } else {
    root.insert("tool_sha256", m.tool_sha256);
    root.insert("path_file", m.path_file);
    root.insert("path_sha256", m.path_sha256);
    root.insert("segments", static_cast<std::int64_t>(m.segments));
    root.insert("path_length_mm", m.path_length_mm);
  }
  toml::array earlier;
  for (const RunManifest::EarlierCut& cut : m.earlier)
    earlier.push_back(toml::table{{"tool_id", cut.tool_id},
                                  {"tool_file", cut.tool_file},
                                  {"tool_sha256", cut.tool_sha256},
                                  {"path_file", cut.path_file},
                                  {"path_sha256", cut.path_sha256}});
  if (!earlier.empty()) root.insert("earlier", std::move(earlier));
  toml::array pieces;
  for (const RunManifest::Piece& p : m.pieces) {
    const Vec3d& i = p.inside;
    const Vec3d& t = p.T_case_piece.translation;
    const Eigen::Quaterniond& q = p.T_case_piece.rotation;
    toml::table row{
        {"id", static_cast<std::int64_t>(p.id)},        {"name", p.name},
        {"inside", toml::array{i[0], i[1], i[2]}},      {"volume_mm3", p.volume_mm3},
        {"translation", toml::array{t[0], t[1], t[2]}}, {"rotation", toml::array{q.w(), q.x(), q.y(), q.z()}}};
    if (!p.colour.empty()) row.insert("colour", p.colour);
    toml::array sides;
    for (const PlaneSide& side : p.sides) {
      toml::array numbers;
      for (std::size_t k = 0; k < side.planes.count; ++k)
        for (const double number : side.planes.numbers[k]) numbers.push_back(number);
      toml::table cut{{"cut", static_cast<std::int64_t>(side.cut)},
                      {"side", side.is_above ? "above" : "rest"},
                      {"kerf_mm", side.planes.kerf_mm},
                      {"planes", static_cast<std::int64_t>(side.planes.count)}};
      if (!numbers.empty()) cut.insert("normals_and_points", std::move(numbers));
      if (side.planes.hasHole()) {
        toml::array hole;
        for (const double number : side.planes.hole_numbers) hole.push_back(number);
        cut.insert("hole", std::move(hole));
      }
      sides.push_back(std::move(cut));
    }
    if (!sides.empty()) row.insert("plane_cut", std::move(sides));
    pieces.push_back(std::move(row));
  }
  if (!pieces.empty()) root.insert("piece", std::move(pieces));
  if (!m.beside.empty()) {
    toml::array beside;
    for (const RunManifest::Beside& b : m.beside) {
      toml::table row{
          {"case_path", b.case_path}, {"case_id", b.case_id}, {"voxel_mm", b.voxel_mm}, {"removed_mm3", b.removed_mm3}};
      if (!b.name.empty()) row.insert("name", b.name);
      if (b.has_begin) row.insert("has_begin", true);
      beside.push_back(std::move(row));
    }
    root.insert("beside", std::move(beside));
  }

  KERF_TRY(file, AtomicFile::create(folder / kRunManifest));
  file.stream() << "# Kerf run. Lengths in mm, times in s. Training and lab tool, not a medical device.\n"
                << root << "\n";
  return file.commit();
}

Expected<void> requireEnded(const fs::path& folder, const RunManifest& m) {
  if (!m.is_open) return {};
  return fail({.code = Error::Code::kUnsupported,
               .file = folder.string(),
               .found = "a session that has not ended: it has only its log",
               .expected = "an ended session",
               .hint = "end it in the window, or, after a crash: kerf recover " + folder.string()});
}

}  // namespace kerf
