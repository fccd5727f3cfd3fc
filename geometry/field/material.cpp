#include "geometry/field/material.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <set>

#include "geometry/base/assets.h"
#include "geometry/base/toml_reader.h"

namespace kerf {
namespace {

// { value = 275, unit = "HV", source = "..." }
Expected<SourcedNumber> readNumber(TomlTable& row, const toml::table& table, const std::filesystem::path& file,
                                   const std::string& key, const std::string& unit, double low, double high) {
  row.allow(key);
  const toml::table* inner = table.get_as<toml::table>(key);
  if (!inner) {
    row.reject(key, table.contains(key) ? "of another form" : "missing",
               fmt::format("{{ value = ..., unit = \"{}\", source = \"...\" }}", unit));
    return SourcedNumber{};
  }
  TomlTable t(*inner, file, "material." + key);
  SourcedNumber out;
  out.value = t.number("value", low, high, unit.c_str());
  if (const auto found = t.get<std::string>("unit", "a unit in quotes"); !t.failed() && found != unit)
    t.reject("unit", "\"" + found + "\"", "\"" + unit + "\"", "convert the value; the unit is fixed");
  out.source = t.get<std::string>("source", "where the number comes from");
  if (!t.failed() && out.source.empty()) t.reject("source", "nothing", "where the number comes from");
  KERF_CHECK(t.finish());
  return out;
}

// "#rrggbb"
bool readColor(const std::string& text, Rgba8& color) {
  if (text.size() != 7 || text[0] != '#') return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const char* begin = text.data() + 1 + 2 * i;
    if (std::from_chars(begin, begin + 2, color[i], 16).ptr != begin + 2) return false;
  }
  color[3] = 255;
  return true;
}

Expected<MaterialProperties> readRow(const toml::table& table, const std::filesystem::path& file) {
  TomlTable row(table, file, "material");
  MaterialProperties m;
  m.id = row.get<std::string>("id", "a word for recipes");
  if (!row.failed() &&
      (m.id.empty() || m.id.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") != std::string::npos))
    row.reject("id", "\"" + m.id + "\"", "lower-case letters, digits and underscores");
  const auto number = row.get<std::int64_t>("number", "a whole number from 1 to 255");
  if (!row.failed() && (number < 1 || number > 255))
    row.reject("number", fmt::format("{}", number), "a whole number from 1 to 255", "32 and more are yours");
  constexpr int kLastOfKerf = static_cast<int>(Material::kComposite), kFirstOfUsers = 32;
  if (!row.failed() && number > kLastOfKerf && number < kFirstOfUsers)
    row.reject("number", fmt::format("{}", number),
               fmt::format("1 to {}, or a number from {} on: those between are kept for later versions of Kerf",
                           kLastOfKerf, kFirstOfUsers));
  m.material = static_cast<Material>(number);
  m.name = row.get<std::string>("name", "a name for people");
  const auto color = row.get<std::string>("color", "\"#rrggbb\"");
  if (!row.failed() && !readColor(color, m.color)) row.reject("color", "\"" + color + "\"", "\"#rrggbb\"");
  KERF_TRY(density, readNumber(row, table, file, "density", "g/cm3", 0.01, 25));
  KERF_TRY(hardness, readNumber(row, table, file, "hardness", "HV", 0, 3000));
  KERF_TRY(energy, readNumber(row, table, file, "specific_cutting_energy", "J/mm3", 1e-4, 1000));
  KERF_TRY(stiffness, readNumber(row, table, file, "contact_stiffness", "N/mm3", 0.01, 1e5));
  KERF_TRY(friction, readNumber(row, table, file, "friction", "1", 0.01, 2));
  KERF_CHECK(row.finish());

  m.density = density;
  m.hardness = hardness;
  m.specific_cutting_energy = energy;
  m.contact_stiffness = stiffness;
  m.friction = friction;
  return m;
}

}  // namespace

const MaterialProperties* MaterialTable::find(std::string_view id) const {
  const auto it = std::find_if(rows_.begin(), rows_.end(), [&](const auto& m) { return m.id == id; });
  return it == rows_.end() ? nullptr : &*it;
}
const MaterialProperties* MaterialTable::find(Material material) const {
  const auto it = std::find_if(rows_.begin(), rows_.end(), [&](const auto& m) { return m.material == material; });
  return it == rows_.end() ? nullptr : &*it;
}
std::string MaterialTable::ids() const {
  std::string out;
  for (const MaterialProperties& m : rows_) out += (out.empty() ? "" : ", ") + m.id;
  return out;
}
Expected<MaterialProperties> MaterialTable::require(std::string_view id) const {
  if (const MaterialProperties* m = find(id)) return *m;
  return fail({.code = Error::Code::kBadValue,
               .place = "material",
               .found = fmt::format("\"{}\"", id),
               .expected = "one of " + ids(),
               .hint = "another id, or a [[material]] of that id in materials.toml"});
}

Expected<MaterialTable> readMaterials(const std::filesystem::path& file) {
  KERF_TRY(root, parseToml(file));
  TomlTable top(root, file, "");
  const auto format = top.get<std::string>("format", "\"kerf-materials\"");
  if (!top.failed() && format != "kerf-materials") top.reject("format", "\"" + format + "\"", "\"kerf-materials\"");
  const auto version = top.get<std::int64_t>("version", "1");
  if (!top.failed() && version != 1) top.reject("version", fmt::format("{}", version), "1");

  std::vector<MaterialProperties> rows;
  std::set<std::string> ids;
  std::set<Material> numbers;
  const toml::array* tables = top.tables("material");
  KERF_CHECK(top.finish());

  for (const toml::node& node : *tables) {
    KERF_TRY(row, readRow(*node.as_table(), file));
    const bool repeats_id = !ids.insert(row.id).second;
    if (repeats_id || !numbers.insert(row.material).second)
      return fail({.code = Error::Code::kBadValue,
                   .file = file.string(),
                   .place = fmt::format("line {}, [[material]] {}", node.source().begin.line, row.id),
                   .found = repeats_id ? "the id a second time"
                                       : fmt::format("number {} a second time", static_cast<int>(row.material)),
                   .expected = "an id and a number of its own for each material"});

    rows.push_back(std::move(row));
  }
  return MaterialTable(std::move(rows));
}

Expected<std::filesystem::path> findMaterialsFile() {
  const auto files = findAssets("materials.toml");
  if (files.empty())
    return fail({.code = Error::Code::kNotFound,
                 .file = "materials.toml",
                 .found = "no such file",
                 .expected = "the table of materials",
                 .hint = "set KERF_ASSETS to the folder that holds it"});
  return files.front();
}

Expected<MaterialTable> readDefaultMaterials() {
  KERF_TRY(file, findMaterialsFile());
  return readMaterials(file);
}

}  // namespace kerf
