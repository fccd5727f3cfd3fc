#include "sim/run/scene/load_scene.h"

#include <fmt/format.h>

#include <algorithm>

#include "geometry/case/case_materials.h"
#include "sim/object/huge_pages.h"

namespace kerf {

Expected<std::shared_ptr<const BakedObject>> loadObject(const std::filesystem::path& case_folder,
                                                        const BrickField* begin, const MaterialBricks* added) {
  KERF_TRY(manifest, readCaseManifest(case_folder));
  KERF_TRY(table, readDefaultMaterials());
  KERF_CHECK(requireSameMaterials(case_folder, manifest, table));
  internal::returnFreeMemory();  // of the document open before
  KERF_TRY(fields, readCaseFields(case_folder, manifest));
  if (begin && begin->voxel() != fields.phi0.voxel())
    return fail({.code = Error::Code::kBadValue,
                 .file = case_folder.string(),
                 .found = fmt::format("voxels of {:g} mm in the earlier cut", begin->voxel()),
                 .expected = fmt::format("{:g} mm, as in the case", fields.phi0.voxel()),
                 .hint = "that run was cut in a finer region of the case: continue it with kerf cut without --hand"});
  if (begin)
    for (std::size_t b = 0; b < begin->brickCount(); ++b)
      fields.phi0.brick(fields.phi0.touch(begin->brickCoord(b))) = begin->brick(b);
  const Material fallback = fallbackOf(manifest);
  if (added && !added->isEmpty()) {
    KERF_CHECK(requireSameMaterials(*added, table));
    KERF_CHECK(requireOnlyAdded(*added, fields.materials, fallback));
    fields.materials = laidOver(std::move(fields.materials), *added);
  }
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
