#include "geometry/case/case_bundle.h"

#include <fmt/format.h>

#include <cmath>

#include "geometry/base/atomic_file.h"
#include "geometry/base/hash.h"
#include "geometry/base/toml_reader.h"
#include "geometry/field/distance_check.h"
#include "geometry/field/vdb_io.h"
#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_io.h"

namespace kerf {
namespace {

constexpr int kManifestVersion = 2;

toml::array vec(const Vec3d& v) { return toml::array{v[0], v[1], v[2]}; }
std::int64_t integer(std::uint64_t n) { return static_cast<std::int64_t>(n); }

// --- Reading: one function a table ---

// A folder with a manifest; anything else gets a hint how to make one of it.
Expected<void> requireCase(const std::filesystem::path& folder) {
  std::error_code ignored;
  const MeshFormatRow* mesh = formatOfExtension(folder.extension().string());
  if (mesh && mesh->read && std::filesystem::is_regular_file(folder, ignored))
    return fail({.code = Error::Code::kNotFound,
                 .file = folder.string(),
                 .found = "a mesh file, not a case",
                 .expected = "a folder with case.toml",
                 .hint = fmt::format("kerf bake {} -o {}", folder.string(),
                                     std::filesystem::path(folder).replace_extension(".case").string())});
  if (std::filesystem::exists(folder / "run.toml", ignored) && !isCase(folder))
    return fail({.code = Error::Code::kNotFound,
                 .file = folder.string(),
                 .found = "a run, not a case",
                 .expected = "a folder with case.toml",
                 .hint = "the case that it was cut from; its run.toml names it as case_path"});
  if (!std::filesystem::is_directory(folder, ignored) || !isCase(folder))
    return fail({.code = Error::Code::kNotFound,
                 .file = folder.string(),
                 .found = "not a case bundle",
                 .expected = "a folder with case.toml",
                 .hint = "kerf bake MESH -o " + folder.string()});
  return {};
}

Expected<void> checkVersion(TomlTable& top, const std::filesystem::path& path) {
  const auto format = top.get<std::string>("format", "\"kerf-case\"");
  const auto version = top.get<std::int64_t>("version", "2");
  if (format == "kerf-case" && version == kManifestVersion) return {};
  return fail({.code = Error::Code::kUnsupported,
               .file = path.string(),
               .place = "key format / version",
               .found = fmt::format("{} version {}", format, version),
               .expected = fmt::format("kerf-case version {}", kManifestVersion),
               .hint = "bake the case again with this Kerf"});
}

// Hands a child table of the manifest to `read`; an empty one if it is missing, so that its first key is.
template <class Read>
Expected<void> readTable(const toml::table& root, const std::filesystem::path& path, const char* name,
                         const Read& read) {
  const toml::table empty;
  const toml::table* found = root.get_as<toml::table>(name);
  TomlTable t(found ? *found : empty, path, name);
  read(t);
  return t.finish();
}

// The same for every table of a list; null if none.
template <class Read>
Expected<void> forEachTable(const toml::array* list, const std::filesystem::path& path, const char* name,
                            const Read& read) {
  if (!list) return {};
  for (const toml::node& node : *list) {
    if (!node.is_table()) continue;
    TomlTable t(*node.as_table(), path, name);
    read(t);
    KERF_CHECK(t.finish());
  }
  return {};
}

constexpr double kMostMm2 = 1e12, kMostMm3 = 1e12, kFarthestMm = 1e11;  // enough for a mesh in metres

std::size_t readCount(TomlTable& t, const char* key) {
  constexpr std::int64_t kMost = std::int64_t{1} << 40;
  const auto count = t.get<std::int64_t>(key, "a count");
  if (count >= 0 && count <= kMost) return static_cast<std::size_t>(count);
  t.reject(key, fmt::format("{}", count), fmt::format("a count from 0 to {}", kMost));
  return 0;
}

// A file of the bundle itself: no path that leads out of it.
std::string readFileName(TomlTable& t, const char* key) {
  std::string name = t.get<std::string>(key, "a file name");
  const std::filesystem::path path = name;
  if (!t.failed() && (name.empty() || name == "." || name == ".." || path != path.filename()))
    t.reject(key, "\"" + name + "\"", "the name of a file in the case, without a path");
  return name;
}

CaseSource readSource(TomlTable& t) {
  CaseSource s;
  s.stored_as = readFileName(t, "stored_as");
  s.format = t.get<std::string>("format", "a mesh format");
  s.sha256 = t.get<std::string>("sha256", "64 hexadecimal digits");
  s.unit = t.get<std::string>("unit", "a unit");
  s.unit_reason = t.get<std::string>("unit_reason", "a string");
  s.scale_to_mm = t.number("scale_to_mm", 1e-9, 1e9, "mm");
  s.vertices = readCount(t, "vertices");
  s.triangles = readCount(t, "triangles");
  return s;
}

void readClose(TomlTable& close, CaseManifest& m) {
  m.close_mode = close.get<std::string>("mode", "a close mode");
  m.exact = close.get<bool>("exact", "true or false");
  m.changes = close.strings("changes");
  if (close.has("warnings")) m.warnings = close.strings("warnings");
  close.allow("numbers");
}

// A case of an older Kerf has none. Its keys are those of the Kerf that baked it: none is unknown.
Expected<void> readClosing(const toml::table& root, const std::filesystem::path& path, CaseManifest& m) {
  constexpr std::size_t kMostNumbers = 64;
  constexpr double kMost = 1e12;
  const toml::table* const numbers = root["close"]["numbers"].as_table();
  if (!numbers) return {};

  TomlTable t(*numbers, path, "close.numbers");
  for (const auto& [key, value] : *numbers) {
    const std::string name(key.str());
    if (m.closing.size() == kMostNumbers) t.reject(name, "more numbers", fmt::format("at most {}", kMostNumbers));
    const double number = t.number(name, -kMost, kMost, "");
    const double least = name == "handles_added" ? -kMost : 0;  // closing may also fill a hole right through
    if (isCountOfClosing(name) && !(number >= least && number == std::floor(number)))
      t.reject(name, fmt::format("{:g}", number),
               "a count: a whole number" + std::string(least == 0 ? ", 0 or more" : ""));
    m.closing[name] = number;
    if (t.failed()) break;
  }
  return t.finish();
}

void readSolid(TomlTable& solid, CaseManifest& m) {
  m.solid_vertices = readCount(solid, "vertices");
  m.solid_triangles = readCount(solid, "triangles");
  m.solid_volume_mm3 = solid.number("volume_mm3", 0, kMostMm3, "mm3");
  m.solid_area_mm2 = solid.number("area_mm2", 0, kMostMm2, "mm2");
  const auto low = solid.numbers("box_min_mm", 3), high = solid.numbers("box_max_mm", 3);
  for (std::size_t k = 0; k < 3 && !solid.failed(); ++k)
    if (!(low[k] <= high[k] && low[k] >= -kFarthestMm && high[k] <= kFarthestMm))
      solid.reject("box_min_mm", fmt::format("{} to {} mm along axis {}", low[k], high[k], k),
                   fmt::format("a box within {} mm, its smaller corner first", kFarthestMm));
  m.box.add(Vec3d(low[0], low[1], low[2]));
  m.box.add(Vec3d(high[0], high[1], high[2]));
  m.solid_sha256 = solid.get<std::string>("sha256", "64 hexadecimal digits");
}

void readField(TomlTable& field, CaseManifest& m) {
  m.voxel_mm = field.number("voxel_mm", 0.001, 100);
  m.field_voxels = readCount(field, "voxels");
  m.shell_points = readCount(field, "shell_points");
  m.shell_area_mm2 = field.number("shell_area_mm2", 0, kMostMm2, "mm2");
  m.field_sha256 = field.get<std::string>("sha256", "64 hexadecimal digits");
}

CaseMaterial readMaterial(TomlTable& t) {
  CaseMaterial c;
  c.id = t.get<std::string>("id", "a material");
  c.number = static_cast<int>(t.number("number", 1, 255, "as a whole number"));
  c.volume_mm3 = t.number("volume_mm3", 0, 1e12, "mm3");
  return c;
}

CasePart readPart(TomlTable& t) {
  CasePart c;
  c.material = t.get<std::string>("material", "a material");
  c.origin = t.get<std::string>("origin", "a mesh, label or depth");
  c.own_mm3 = t.number("own_mm3", 0, 1e12, "mm3");
  c.volume_mm3 = t.number("volume_mm3", 0, 1e12, "mm3");
  return c;
}

CasePair readPair(TomlTable& t) {
  CasePair pair{t.get<std::string>("frame", "64 hexadecimal digits"),
                t.get<std::string>("partner", "the name of a case folder")};
  if (const std::filesystem::path partner = pair.partner; !t.failed() && partner != partner.filename())
    t.reject("partner", "\"" + pair.partner + "\"", "the name of a case folder, without a path");
  return pair;
}

CaseGaps readGaps(TomlTable& t) {
  return {t.number("unclaimed_mm3", 0, 1e12, "mm3"), t.number("forgotten_mm3", 0, 1e12, "mm3")};
}

CaseRegion readRegion(TomlTable& t) {
  CaseRegion r;
  r.where = {t.points("line_mm"), t.number("radius_mm", 1e-3, 1e4), t.number("voxel_mm", 1e-3, 100)};
  r.field_voxels = readCount(t, "voxels");
  r.shell_points = readCount(t, "shell_points");
  r.shell_area_mm2 = t.number("shell_area_mm2", 0, kMostMm2, "mm2");
  return r;
}

// --- Writing ---

toml::array tablesOf(const std::vector<CaseSource>& sources) {
  toml::array out;
  for (const CaseSource& s : sources)
    out.push_back(toml::table{{"stored_as", s.stored_as},
                              {"format", s.format},
                              {"sha256", s.sha256},
                              {"unit", s.unit},
                              {"unit_reason", s.unit_reason},
                              {"scale_to_mm", s.scale_to_mm},
                              {"vertices", integer(s.vertices)},
                              {"triangles", integer(s.triangles)}});
  return out;
}

toml::array tablesOf(const std::vector<CaseMaterial>& materials) {
  toml::array out;
  for (const CaseMaterial& c : materials)
    out.push_back(toml::table{{"id", c.id}, {"number", c.number}, {"volume_mm3", c.volume_mm3}});
  return out;
}

toml::array tablesOf(const std::vector<CasePart>& parts) {
  toml::array out;
  for (const CasePart& c : parts)
    out.push_back(toml::table{
        {"material", c.material}, {"origin", c.origin}, {"own_mm3", c.own_mm3}, {"volume_mm3", c.volume_mm3}});
  return out;
}

toml::table tableOf(const CaseRegion& region) {
  toml::array line;
  for (const Vec3d& p : region.where.line) line.push_back(vec(p));
  return toml::table{{"line_mm", line},
                     {"radius_mm", region.where.radius_mm},
                     {"voxel_mm", region.where.voxel_mm},
                     {"voxels", integer(region.field_voxels)},
                     {"shell_points", integer(region.shell_points)},
                     {"shell_area_mm2", region.shell_area_mm2}};
}

toml::table tableOf(const CaseManifest& m) {
  toml::array changes;
  for (const std::string& c : m.changes) changes.push_back(c);
  toml::table close{{"mode", m.close_mode}, {"exact", m.exact}, {"changes", changes}};
  if (m.warnings) {
    toml::array warnings;
    for (const std::string& w : *m.warnings) warnings.push_back(w);
    close.insert("warnings", warnings);
  }
  toml::table numbers;
  for (const auto& [key, number] : m.closing) numbers.insert(key, number);
  if (!numbers.empty()) close.insert("numbers", numbers);

  toml::table root{
      {"format", "kerf-case"},
      {"version", kManifestVersion},
      {"kerf_version", m.kerf_version},
      {"id", m.id},
      {"source", tablesOf(m.sources)},
      {"close", close},
      {"solid", toml::table{{"vertices", integer(m.solid_vertices)},
                            {"triangles", integer(m.solid_triangles)},
                            {"volume_mm3", m.solid_volume_mm3},
                            {"area_mm2", m.solid_area_mm2},
                            {"box_min_mm", vec(m.box.min)},
                            {"box_max_mm", vec(m.box.max)},
                            {"sha256", m.solid_sha256}}},
      {"field", toml::table{{"voxel_mm", m.voxel_mm},
                            {"voxels", integer(m.field_voxels)},
                            {"shell_points", integer(m.shell_points)},
                            {"shell_area_mm2", m.shell_area_mm2},
                            {"sha256", m.field_sha256}}},
      {"material", tablesOf(m.materials)},
  };

  if (!m.parts.empty()) root.insert("part", tablesOf(m.parts));
  if (m.gaps)
    root.insert("gaps",
                toml::table{{"unclaimed_mm3", m.gaps->unclaimed_mm3}, {"forgotten_mm3", m.gaps->forgotten_mm3}});
  if (m.region) root.insert("region", tableOf(*m.region));
  if (m.pair) root.insert("pair", toml::table{{"frame", m.pair->frame}, {"partner", m.pair->partner}});
  return root;
}

}  // namespace

bool isCountOfClosing(std::string_view key) {
  return !key.ends_with("_mm") && !key.ends_with("_mm2") && !key.ends_with("_mm3") && !key.ends_with("_share");
}

bool isCase(const std::filesystem::path& folder) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(folder / kCaseManifest, ignored);
}

Expected<void> writeCaseManifest(const std::filesystem::path& folder, const CaseManifest& m) {
  KERF_TRY(file, AtomicFile::create(folder / kCaseManifest));
  file.stream() << "# Kerf case. Lengths in mm. Training and lab tool, not a medical device.\n" << tableOf(m) << "\n";
  return file.commit();
}

Expected<CaseManifest> readCaseManifest(const std::filesystem::path& folder) {
  KERF_CHECK(requireCase(folder));
  const auto path = folder / kCaseManifest;
  KERF_TRY(root, parseToml(path));
  TomlTable top(root, path, "");
  KERF_CHECK(checkVersion(top, path));

  CaseManifest m;
  m.kerf_version = top.get<std::string>("kerf_version", "a string");
  m.id = top.get<std::string>("id", "64 hexadecimal digits");
  KERF_CHECK(
      forEachTable(top.tables("source"), path, "source", [&](TomlTable& t) { m.sources.push_back(readSource(t)); }));

  KERF_CHECK(readTable(root, path, "close", [&](TomlTable& t) { readClose(t, m); }));
  KERF_CHECK(readClosing(root, path, m));
  KERF_CHECK(readTable(root, path, "solid", [&](TomlTable& t) { readSolid(t, m); }));
  KERF_CHECK(readTable(root, path, "field", [&](TomlTable& t) { readField(t, m); }));

  KERF_CHECK(forEachTable(top.tables("material"), path, "material",
                          [&](TomlTable& t) { m.materials.push_back(readMaterial(t)); }));
  if (top.has("part"))
    KERF_CHECK(forEachTable(top.tables("part"), path, "part", [&](TomlTable& t) { m.parts.push_back(readPart(t)); }));
  if (top.has("pair")) KERF_CHECK(readTable(root, path, "pair", [&](TomlTable& t) { m.pair = readPair(t); }));
  if (top.has("gaps")) KERF_CHECK(readTable(root, path, "gaps", [&](TomlTable& t) { m.gaps = readGaps(t); }));
  if (top.has("region")) KERF_CHECK(readTable(root, path, "region", [&](TomlTable& t) { m.region = readRegion(t); }));

  for (const char* name : {"close", "solid", "field", "gaps", "region", "pair"}) top.allow(name);
  KERF_CHECK(top.finish());
  return m;
}

Expected<Mesh> readCaseSolid(const std::filesystem::path& folder) {
  KERF_TRY(manifest, readCaseManifest(folder));
  KERF_CHECK(requireSha256(folder / kCaseSolid, manifest.solid_sha256, "bake the case again"));
  KERF_TRY(file, readMesh(folder / kCaseSolid));
  return std::move(file.mesh);
}

namespace {

// Adds the file to the error of a check of its values.
Expected<void> ofFile(Expected<void> checked, const std::filesystem::path& file) {
  if (checked) return {};
  checked.error().file = file.string();
  return fail(std::move(checked).error());
}

// The field of the whole object, checked as distances.
Expected<BrickField> readDistances(const std::filesystem::path& file) {
  KERF_TRY(phi, readVdb(file, "phi"));
  KERF_CHECK(ofFile(requireDistances(phi), file));
  return std::move(phi);
}

}  // namespace

Expected<BrickField> readCaseField(const std::filesystem::path& folder) {
  KERF_TRY(manifest, readCaseManifest(folder));
  KERF_CHECK(requireSha256(folder / kCaseAnatomy, manifest.field_sha256, "bake the case again"));
  return readDistances(folder / kCaseAnatomy);
}

Expected<BrickField> readCaseRegionField(const std::filesystem::path& folder, const BrickField& whole) {
  KERF_TRY(manifest, readCaseManifest(folder));
  if (!manifest.region)
    return fail({.code = Error::Code::kNotFound,
                 .file = folder.string(),
                 .found = "no fine region",
                 .expected = "a case baked with one",
                 .hint = "kerf bake --fine-along"});
  KERF_CHECK(requireSha256(folder / kCaseAnatomy, manifest.field_sha256, "bake the case again"));

  const std::filesystem::path file = folder / kCaseAnatomy;
  const std::string grid = std::string("phi") + kFineSuffix;
  KERF_TRY(fine, readVdb(file, grid));
  KERF_CHECK(ofFile(requireDistancesInPart(fine, grid), file));
  KERF_CHECK(ofFile(requireSameSides(fine, whole, grid), file));
  return std::move(fine);
}

Expected<MaterialField> readCaseMaterials(const std::filesystem::path& folder) {
  KERF_TRY(manifest, readCaseManifest(folder));
  KERF_CHECK(requireSha256(folder / kCaseAnatomy, manifest.field_sha256, "bake the case again"));
  return readMaterialField(folder / kCaseAnatomy);
}

Expected<CaseFields> readCaseFields(const std::filesystem::path& folder, const CaseManifest& manifest) {
  KERF_CHECK(requireSha256(folder / kCaseAnatomy, manifest.field_sha256, "bake the case again"));
  KERF_TRY(phi0, readDistances(folder / kCaseAnatomy));
  KERF_TRY(materials, readMaterialField(folder / kCaseAnatomy));
  return CaseFields{std::move(phi0), std::move(materials)};
}

}  // namespace kerf
