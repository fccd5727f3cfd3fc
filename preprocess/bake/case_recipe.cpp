#include "preprocess/bake/case_recipe.h"

#include <fmt/format.h>

#include <algorithm>

#include "geometry/base/toml_reader.h"
#include "preprocess/unit/unit.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

std::optional<Material> materialOf(TomlTable& table, const std::string& key, const std::string& id,
                                   const MaterialTable& materials) {
  const auto row = materials.require(id);
  if (row) return row->material;
  table.reject(key, row.error().found, row.error().expected, row.error().hint);
  return {};
}

// Normalises the path, so that the same file has the same path.
fs::path fileName(TomlTable& table, const char* key, const char* expected) {
  const auto name = table.get<std::string>(key, expected);
  if (!table.failed() && name.empty()) table.reject(key, "an empty name", expected);
  return fs::path(name).lexically_normal();
}

// { point = [0, 0, 5], normal = [0, 0, 1] }
Expected<Plane> readPlane(const toml::table& part, const std::filesystem::path& file) {
  const toml::table* table = part.get_as<toml::table>("above");
  if (!table)
    return fail({.code = Error::Code::kBadFormat,
                 .file = file.string(),
                 .place = "key part.above",
                 .found = "of another form",
                 .expected = "{ point = [x, y, z], normal = [x, y, z] }"});
  TomlTable t(*table, file, "part.above");
  const auto point = t.numbers("point", 3), normal = t.numbers("normal", 3);
  Plane plane;
  plane.point = Vec3d(point[0], point[1], point[2]);
  plane.normal = Vec3d(normal[0], normal[1], normal[2]);
  const double length = plane.normal.norm();
  if (!t.failed() && !(length > 1e-9 && length < 1e9))
    t.reject("normal", "no direction", "a direction that is not zero, as [0, 0, 1]");
  KERF_CHECK(t.finish());
  plane.normal /= length;
  return plane;
}

Expected<RecipePart> readPart(const toml::table& table, const std::filesystem::path& file,
                              const MaterialTable& materials) {
  TomlTable t(table, file, "part");
  RecipePart part;
  const std::string known = "one of " + materials.ids();
  const auto id = t.get<std::string>("material", known.c_str());
  if (!t.failed())
    if (materialOf(t, "material", id, materials)) part.material = *materials.find(id);
  for (const char* key : {"mesh", "depth", "label", "above", "replaces"}) t.allow(key);

  // Where it is.
  const int kinds = t.has("mesh") + t.has("depth") + t.has("label");
  if (kinds != 1)
    t.reject(t.has("mesh") ? "mesh" : "material", kinds == 0 ? "a part without a place" : "more than one of them",
             "exactly one of mesh, depth and label");
  if (t.has("mesh")) {
    part.mesh = fileName(t, "mesh", "a mesh file, relative to the recipe");
    if (!t.failed() && !part.mesh.has_filename())
      t.reject("mesh", "\"" + part.mesh.string() + "\", a folder", "a mesh file, relative to the recipe");
  }
  if (t.has("depth")) part.depth = DepthRule{t.number("depth", 0.01, 50), {}};
  if (t.has("label")) {
    const auto label = t.get<std::int64_t>("label", "a whole number from 1 to 65535");
    if (!t.failed() && (label < 1 || label > 65535))
      t.reject("label", fmt::format("{}", label), "a whole number from 1 to 65535");
    part.label = static_cast<std::uint16_t>(label);
  }

  // Limits of the part.
  if (t.has("above")) {
    if (!part.depth) t.reject("above", "beside no depth", "above belongs to a part with a depth");
    KERF_TRY(plane, readPlane(table, file));
    if (part.depth) part.depth->above = plane;
  }
  if (t.has("replaces")) {
    for (const std::string& other : t.strings("replaces"))
      if (const auto m = materialOf(t, "replaces", other, materials)) part.replaces.push_back(*m);
    if (part.label) t.reject("replaces", "beside a label", "replaces belongs to a mesh or a depth");
    if (!t.failed() && part.replaces.empty()) t.reject("replaces", "an empty list", "the materials it may replace");
  }
  KERF_CHECK(t.finish());
  return part;
}

Expected<RecipeLabels> readLabelTables(const toml::table& table, const std::filesystem::path& file) {
  TomlTable t(table, file, "labels");
  RecipeLabels labels;
  labels.volume = fileName(t, "volume", "a volume file or folder, relative to the recipe");
  if (t.has("spacing")) {
    const auto s = t.numbers("spacing", 3);
    labels.spacing_mm = Vec3d(s[0], s[1], s[2]);
    if (!t.failed() && !(labels.spacing_mm->minCoeff() > 0)) t.reject("spacing", "not above zero", "mm per voxel");
  }
  if (t.has("threshold")) labels.threshold = t.number("threshold", -1e6, 1e6, "of the volume's intensity");
  if (t.has("smoothing")) labels.smoothing_voxels = t.number("smoothing", 0, 5, "label voxels");
  for (const char* key : {"spacing", "threshold", "smoothing"}) t.allow(key);
  KERF_CHECK(t.finish());
  return labels;
}

Expected<FineRegion> readRegion(const toml::table& table, const std::filesystem::path& file) {
  TomlTable t(table, file, "region");
  const FineRegion region{t.points("line"), t.number("radius", 0.1, 1000), t.number("voxel", 0.005, 5)};
  KERF_CHECK(t.finish());
  return region;
}

Expected<std::vector<fs::path>> readOutline(const toml::table& table, const fs::path& file) {
  TomlTable t(table, file, "outline");
  std::vector<fs::path> meshes;
  for (const std::string& mesh : t.strings("meshes")) {
    if (!fs::path(mesh).has_filename())
      t.reject("meshes", mesh.empty() ? "an empty name" : "\"" + mesh + "\", a folder",
               "a mesh file, relative to the recipe");
    meshes.push_back(fs::path(mesh).lexically_normal());
  }
  if (!t.failed() && meshes.empty()) t.reject("meshes", "an empty list", "one or more mesh files");
  KERF_CHECK(t.finish());
  return meshes;
}

// Reads the keys above all tables, and checks the types of the tables. Returns the array of parts.
Expected<const toml::array*> readTop(const toml::table& root, const MaterialTable& materials, CaseRecipe& recipe) {
  TomlTable top(root, recipe.file, "");
  const auto format = top.get<std::string>("format", "\"kerf-recipe\"");
  if (!top.failed() && format != "kerf-recipe") top.reject("format", "\"" + format + "\"", "\"kerf-recipe\"");
  const auto version = top.get<std::int64_t>("version", "1");
  if (!top.failed() && version != 1) top.reject("version", fmt::format("{}", version), "1");

  recipe.name = top.getOr<std::string>("name", "", "a name for people");
  recipe.unit = top.getOr<std::string>("unit", "", "mm, cm, m, um or inch");
  if (!top.failed() && !recipe.unit.empty() && !millimetresPer(recipe.unit))
    top.reject("unit", "\"" + recipe.unit + "\"", "mm, cm, m, um or inch");
  if (top.has("voxel")) recipe.voxel_mm = top.number("voxel", 0.005, 5);
  if (top.has("drop_specks_mm3")) recipe.drop_specks_mm3 = top.number("drop_specks_mm3", 0, 1e6, "mm3");
  const auto fallback = top.getOr<std::string>("fallback", "generic", "a material");
  if (!top.failed())
    if (const auto m = materialOf(top, "fallback", fallback, materials)) recipe.fallback = *m;

  const toml::array* parts = top.tables("part");
  for (const char* key : {"voxel", "drop_specks_mm3", "outline", "labels", "region"}) top.allow(key);
  for (const char* key : {"outline", "labels", "region"})
    if (top.has(key) && !root.get_as<toml::table>(key))
      top.reject(key, "of another form", fmt::format("a table, [{}]", key));
  KERF_CHECK(top.finish());
  return parts;
}

}  // namespace

std::string RecipePart::origin() const {
  if (label) return fmt::format("label {}", *label);
  if (depth) return fmt::format("depth < {} mm{}", depth->depth_mm, depth->above ? ", above a plane" : "");
  return mesh.filename().string();
}

std::vector<std::filesystem::path> CaseRecipe::meshes() const {
  std::vector<std::filesystem::path> out;
  const auto add = [&out](const std::filesystem::path& path) {
    if (!path.empty() && std::find(out.begin(), out.end(), path) == out.end()) out.push_back(path);
  };
  for (const RecipePart& part : parts) add(part.mesh);
  for (const auto& path : outline) add(path);
  return out;
}

bool looksLikeRecipe(const std::filesystem::path& path) { return path.extension() == ".toml"; }

Expected<CaseRecipe> readCaseRecipe(const std::filesystem::path& file, const MaterialTable& materials) {
  KERF_TRY(root, parseToml(file));
  CaseRecipe recipe;
  recipe.file = file;
  KERF_TRY(parts, readTop(root, materials, recipe));

  for (const toml::node& node : *parts) {
    KERF_TRY(part, readPart(*node.as_table(), file, materials));
    recipe.parts.push_back(std::move(part));
  }
  if (const toml::table* table = root.get_as<toml::table>("outline")) {
    KERF_TRY(outline, readOutline(*table, file));
    recipe.outline = std::move(outline);
  }
  if (const toml::table* table = root.get_as<toml::table>("labels")) {
    KERF_TRY(labels, readLabelTables(*table, file));
    recipe.labels = labels;
  }
  if (const toml::table* table = root.get_as<toml::table>("region")) {
    KERF_TRY(region, readRegion(*table, file));
    recipe.region = region;
  }

  const bool asks = std::any_of(recipe.parts.begin(), recipe.parts.end(), [](const auto& p) { return p.label; });
  if (asks != recipe.labels.has_value())
    return fail({.code = Error::Code::kBadValue,
                 .file = file.string(),
                 .place = asks ? "[labels]" : "[[part]]",
                 .found = asks ? "missing, though a part says label = ..."
                               : "no part says label = ..., though there is [labels]",
                 .expected = "[labels] with volume = \"...\", and parts with label = ..."});
  if (recipe.meshes().empty() && !recipe.labels)
    return fail({.code = Error::Code::kBadValue,
                 .file = file.string(),
                 .place = "[[part]]",
                 .found = "nothing but depths",
                 .expected = "a mesh or a label that gives the object its surface"});
  return recipe;
}

}  // namespace kerf
