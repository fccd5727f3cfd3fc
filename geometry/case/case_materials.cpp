#include "geometry/case/case_materials.h"

#include <fmt/format.h>

namespace kerf {
namespace {

std::string idOf(const MaterialProperties* row) {
  return row ? fmt::format("'{}'", row->id) : std::string("no material");
}

std::string tableName() {
  const auto file = findMaterialsFile();
  return file ? file->string() : std::string("the table of materials");
}

}  // namespace

Expected<void> requireSameMaterials(const std::filesystem::path& case_folder, const CaseManifest& manifest,
                                    const MaterialTable& table) {
  for (const CaseMaterial& material : manifest.materials) {
    const MaterialProperties* row = table.find(static_cast<Material>(material.number));
    if (row && row->id == material.id) continue;

    return fail({.code = Error::Code::kUnsupported,
                 .file = (case_folder / kCaseManifest).string(),
                 .place = fmt::format("[[material]] {}", material.id),
                 .found = fmt::format("number {}, which is {} in {}", material.number, idOf(row), tableName()),
                 .expected = fmt::format("the table that the case was baked with: there {} is '{}'", material.number,
                                         material.id),
                 .hint = "set KERF_ASSETS to the folder of that materials.toml; or bake again with this one"});
  }
  return {};
}

Material fallbackOf(const CaseManifest& manifest) {
  return manifest.materials.empty() ? Material::kGeneric : static_cast<Material>(manifest.materials.front().number);
}

Expected<void> requireSameMaterials(const MaterialBricks& added, const MaterialTable& table) {
  for (const auto& [number, id] : added.added) {
    const MaterialProperties* const row = table.find(static_cast<Material>(number));
    if (row && row->id == id) continue;

    return fail({.code = Error::Code::kUnsupported,
                 .file = added.file.string(),
                 .place = fmt::format("grid {}, {}", kMaterialGrid, id),
                 .found = fmt::format("number {}, which is {} in {}", number, idOf(row), tableName()),
                 .expected = fmt::format("the table that it was added by: there {} is '{}'", number, id),
                 .hint = "set KERF_ASSETS to the folder of that materials.toml"});
  }
  return {};
}

}  // namespace kerf
