#include "sim/run/load_scene.h"

#include <algorithm>

namespace kerf {

Expected<std::shared_ptr<const BakedObject>> loadObject(const std::filesystem::path& case_folder) {
  KERF_TRY(manifest, readCaseManifest(case_folder));
  KERF_TRY(fields, readCaseFields(case_folder, manifest));
  const Material fallback =
      manifest.materials.empty() ? Material::kGeneric : static_cast<Material>(manifest.materials.front().number);
  auto object = BakedObject::make(std::move(fields.phi0), std::move(fields.materials), fallback);
  if (!object) {
    object.error().file = case_folder.string();
    return fail(object.error());
  }
  return std::move(*object);
}

double widestBand(std::span<const std::shared_ptr<const BakedObject>> objects) {
  double out = 0;
  for (const auto& object : objects) out = std::max(out, -static_cast<double>(object->phi0().interior()));
  return out;
}

Expected<Model> makeModel(std::span<const Tool> tools, const StepSettings& settings, double band_mm) {
  KERF_TRY(materials, readDefaultMaterials());
  KERF_TRY(tissues, tissueTable(materials));
  Model model;
  model.tissues = tissues;
  model.settings = settings;
  for (const Tool& tool : tools) model.tools.push_back(makeToolModel(tool, std::max(band_mm, 0.2)));
  return model;
}

}  // namespace kerf
