#include "geometry/case/case_materials.h"

#include <fmt/format.h>

namespace kerf {

Expected<void> requireSameMaterials(const std::filesystem::path& case_folder, const CaseManifest& manifest,
                                    const MaterialTable& table) {
  for (const CaseMaterial& material : manifest.materials) {
    const MaterialProperties* row = table.find(static_cast<Material>(material.number));
    if (row && row->id == material.id) continue;

    const auto file = findMaterialsFile();
    return fail({.code = Error::Code::kUnsupported,
                 .file = (case_folder / kCaseManifest).string(),
                 .place = fmt::format("[[material]] {}", material.id),
                 .found = fmt::format("number {}, which is {} in {}", material.number,
                                      row ? fmt::format("'{}'", row->id) : std::string("no material"),
                                      file ? file->string() : std::string("the table of materials")),
                 .expected = fmt::format("the table that the case was baked with: there {} is '{}'", material.number,
                                         material.id),
                 .hint = "set KERF_ASSETS to the folder of that materials.toml; or bake again with this one"});
  }
  return {};
}

}  // namespace kerf
