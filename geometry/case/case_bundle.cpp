#include "geometry/case/case_bundle.h"

#include <fmt/format.h>

#include <fstream>

#include "geometry/base/hash.h"
#include "geometry/base/toml_reader.h"
#include "geometry/field/vdb_io.h"
#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_io.h"

namespace kerf {
namespace {

constexpr int kManifestVersion = 2;

toml::array vec(const Vec3d& v) { return toml::array{v[0], v[1], v[2]}; }
std::int64_t integer(std::uint64_t n) { return static_cast<std::int64_t>(n); }

}  // namespace

bool isCase(const std::filesystem::path& folder) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(folder / kCaseManifest, ignored);
}

Expected<void> writeCaseManifest(const std::filesystem::path& folder, const CaseManifest& m) {
  toml::array sources, changes, materials, parts;
  for (const CaseMaterial& c : m.materials)
    materials.push_back(toml::table{{"id", c.id}, {"number", c.number}, {"volume_mm3", c.volume_mm3}});
  for (const CasePart& c : m.parts)
    parts.push_back(toml::table{
        {"material", c.material}, {"origin", c.origin}, {"own_mm3", c.own_mm3}, {"volume_mm3", c.volume_mm3}});
  for (const CaseSource& s : m.sources)
    sources.push_back(toml::table{{"stored_as", s.stored_as},
                                  {"format", s.format},
                                  {"sha256", s.sha256},
                                  {"unit", s.unit},
                                  {"unit_reason", s.unit_reason},
                                  {"scale_to_mm", s.scale_to_mm},
                                  {"vertices", integer(s.vertices)},
                                  {"triangles", integer(s.triangles)}});
  for (const std::string& c : m.changes) changes.push_back(c);
  toml::table root{
      {"format", "kerf-case"},
      {"version", kManifestVersion},
      {"kerf_version", m.kerf_version},
      {"id", m.id},
      {"source", sources},
      {"close", toml::table{{"mode", m.close_mode}, {"exact", m.exact}, {"changes", changes}}},
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
      {"material", materials},
  };
  if (!parts.empty()) root.insert("part", parts);
  if (m.gaps)
    root.insert("gaps",
                toml::table{{"unclaimed_mm3", m.gaps->unclaimed_mm3}, {"forgotten_mm3", m.gaps->forgotten_mm3}});
  if (m.region) {
    toml::array line;
    for (const Vec3d& p : m.region->where.line) line.push_back(vec(p));
    root.insert("region", toml::table{{"line_mm", line},
                                      {"radius_mm", m.region->where.radius_mm},
                                      {"voxel_mm", m.region->where.voxel_mm},
                                      {"voxels", integer(m.region->field_voxels)},
                                      {"shell_points", integer(m.region->shell_points)},
                                      {"shell_area_mm2", m.region->shell_area_mm2}});
  }
  if (m.pair) root.insert("pair", toml::table{{"frame", m.pair->frame}, {"partner", m.pair->partner}});
  const auto path = folder / kCaseManifest;
  std::ofstream out(path, std::ios::binary);
  out << "# Kerf case. Lengths in mm. Training and lab tool, not a medical device.\n" << root << "\n";
  out.close();
  if (!out)
    return fail({Error::Code::kWriteFailed, path.string(), "", "could not be written", "a writable place with room",
                 "free some space"});
  return {};
}

Expected<CaseManifest> readCaseManifest(const std::filesystem::path& folder) {
  const auto path = folder / kCaseManifest;
  std::error_code ignored;
  if (const MeshFormatRow* mesh = formatOfExtension(folder.extension().string());
      mesh && mesh->read && std::filesystem::is_regular_file(folder, ignored))
    return fail({Error::Code::kNotFound, folder.string(), "", "a mesh file, not a case", "a folder with case.toml",
                 fmt::format("kerf bake {} -o {}", folder.string(),
                             std::filesystem::path(folder).replace_extension(".case").string())});
  if (!std::filesystem::is_directory(folder, ignored) || !isCase(folder))
    return fail({Error::Code::kNotFound, folder.string(), "", "not a case bundle", "a folder with case.toml",
                 "kerf bake MESH -o " + folder.string()});
  KERF_TRY(root, parseToml(path));
  TomlTable top(root, path, "");
  CaseManifest m;
  const auto format = top.get<std::string>("format", "\"kerf-case\"");
  const auto version = top.get<std::int64_t>("version", "2");
  if (format != "kerf-case" || version != kManifestVersion)
    return fail({Error::Code::kUnsupported, path.string(), "key format / version",
                 fmt::format("{} version {}", format, version), fmt::format("kerf-case version {}", kManifestVersion),
                 "bake the case again with this Kerf"});
  m.kerf_version = top.get<std::string>("kerf_version", "a string");
  m.id = top.get<std::string>("id", "64 hexadecimal digits");
  if (const toml::array* sources = top.tables("source"))
    for (const toml::node& node : *sources) {
      if (!node.is_table()) continue;
      TomlTable t(*node.as_table(), path, "source");
      CaseSource s;
      s.stored_as = t.get<std::string>("stored_as", "a file name");
      s.format = t.get<std::string>("format", "a mesh format");
      s.sha256 = t.get<std::string>("sha256", "64 hexadecimal digits");
      s.unit = t.get<std::string>("unit", "a unit");
      s.unit_reason = t.get<std::string>("unit_reason", "a string");
      s.scale_to_mm = t.get<double>("scale_to_mm", "a number");
      s.vertices = static_cast<std::size_t>(t.get<std::int64_t>("vertices", "a count"));
      s.triangles = static_cast<std::size_t>(t.get<std::int64_t>("triangles", "a count"));
      KERF_CHECK(t.finish());
      m.sources.push_back(s);
    }
  const toml::table empty;
  const auto child = [&](const char* name) -> const toml::table& {
    const toml::table* t = root.get_as<toml::table>(name);
    return t ? *t : empty;
  };
  TomlTable close(child("close"), path, "close");
  m.close_mode = close.get<std::string>("mode", "a close mode");
  m.exact = close.get<bool>("exact", "true or false");
  m.changes = close.strings("changes");
  KERF_CHECK(close.finish());
  TomlTable solid(child("solid"), path, "solid");
  m.solid_vertices = static_cast<std::size_t>(solid.get<std::int64_t>("vertices", "a count"));
  m.solid_triangles = static_cast<std::size_t>(solid.get<std::int64_t>("triangles", "a count"));
  m.solid_volume_mm3 = solid.get<double>("volume_mm3", "a number");
  m.solid_area_mm2 = solid.get<double>("area_mm2", "a number");
  const auto low = solid.numbers("box_min_mm", 3), high = solid.numbers("box_max_mm", 3);
  m.box.add(Vec3d(low[0], low[1], low[2]));
  m.box.add(Vec3d(high[0], high[1], high[2]));
  m.solid_sha256 = solid.get<std::string>("sha256", "64 hexadecimal digits");
  KERF_CHECK(solid.finish());
  TomlTable field(child("field"), path, "field");
  m.voxel_mm = field.number("voxel_mm", 0.001, 100);
  m.field_voxels = static_cast<std::uint64_t>(field.get<std::int64_t>("voxels", "a count"));
  m.shell_points = static_cast<std::uint64_t>(field.get<std::int64_t>("shell_points", "a count"));
  m.shell_area_mm2 = field.get<double>("shell_area_mm2", "a number");
  m.field_sha256 = field.get<std::string>("sha256", "64 hexadecimal digits");
  KERF_CHECK(field.finish());
  if (const toml::array* materials = top.tables("material"))
    for (const toml::node& node : *materials) {
      if (!node.is_table()) continue;
      TomlTable t(*node.as_table(), path, "material");
      CaseMaterial c;
      c.id = t.get<std::string>("id", "a material");
      c.number = static_cast<int>(t.number("number", 1, 255, "as a whole number"));
      c.volume_mm3 = t.number("volume_mm3", 0, 1e12, "mm3");
      KERF_CHECK(t.finish());
      m.materials.push_back(c);
    }
  if (const toml::array* parts = top.has("part") ? top.tables("part") : nullptr)
    for (const toml::node& node : *parts) {
      if (!node.is_table()) continue;
      TomlTable t(*node.as_table(), path, "part");
      CasePart c;
      c.material = t.get<std::string>("material", "a material");
      c.origin = t.get<std::string>("origin", "a mesh, label or depth");
      c.own_mm3 = t.number("own_mm3", 0, 1e12, "mm3");
      c.volume_mm3 = t.number("volume_mm3", 0, 1e12, "mm3");
      KERF_CHECK(t.finish());
      m.parts.push_back(c);
    }
  if (top.has("pair")) {
    TomlTable pair(child("pair"), path, "pair");
    m.pair = CasePair{pair.get<std::string>("frame", "64 hexadecimal digits"),
                      pair.get<std::string>("partner", "the name of a case folder")};
    if (const std::filesystem::path partner = m.pair->partner; !pair.failed() && partner != partner.filename())
      pair.reject("partner", "\"" + m.pair->partner + "\"", "the name of a case folder, without a path");
    KERF_CHECK(pair.finish());
  }
  if (top.has("gaps")) {
    TomlTable gaps(child("gaps"), path, "gaps");
    m.gaps = CaseGaps{gaps.number("unclaimed_mm3", 0, 1e12, "mm3"), gaps.number("forgotten_mm3", 0, 1e12, "mm3")};
    KERF_CHECK(gaps.finish());
  }
  if (top.has("region")) {
    TomlTable region(child("region"), path, "region");
    CaseRegion r;
    r.where = {region.points("line_mm"), region.number("radius_mm", 1e-3, 1e4), region.number("voxel_mm", 1e-3, 100)};
    r.field_voxels = static_cast<std::uint64_t>(region.get<std::int64_t>("voxels", "a count"));
    r.shell_points = static_cast<std::uint64_t>(region.get<std::int64_t>("shell_points", "a count"));
    r.shell_area_mm2 = region.get<double>("shell_area_mm2", "a number");
    KERF_CHECK(region.finish());
    m.region = r;
  }
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

Expected<BrickField> readCaseField(const std::filesystem::path& folder) {
  KERF_TRY(manifest, readCaseManifest(folder));
  KERF_CHECK(requireSha256(folder / kCaseAnatomy, manifest.field_sha256, "bake the case again"));
  return readVdb(folder / kCaseAnatomy, "phi");
}

Expected<BrickField> readCaseRegionField(const std::filesystem::path& folder) {
  KERF_TRY(manifest, readCaseManifest(folder));
  if (!manifest.region)
    return fail({Error::Code::kNotFound, folder.string(), "", "no fine region", "a case baked with one",
                 "kerf bake --fine-along"});
  KERF_CHECK(requireSha256(folder / kCaseAnatomy, manifest.field_sha256, "bake the case again"));
  return readVdb(folder / kCaseAnatomy, std::string("phi") + kFineSuffix);
}

Expected<MaterialField> readCaseMaterials(const std::filesystem::path& folder) {
  KERF_TRY(manifest, readCaseManifest(folder));
  KERF_CHECK(requireSha256(folder / kCaseAnatomy, manifest.field_sha256, "bake the case again"));
  return readMaterialField(folder / kCaseAnatomy);
}

}  // namespace kerf
