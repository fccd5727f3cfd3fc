// The grids of a .vdb file: fields, materials and what `kerf info` says of them.
#include <cmath>

#include "geometry/field/material_field.h"
#include "geometry/field/vdb_io.h"
#include "tests/fuzz/file_harness.h"

namespace {

using namespace kerf;

void readField(const std::filesystem::path& file, const char* name) {
  const Expected<BrickField> field = readVdb(file, name);
  if (!field) return fuzz::requireError(field.error());
  fuzz::require(field->voxel() >= 1e-3 && field->voxel() <= 100, "a voxel size in range");
  fuzz::require(std::isfinite(field->background()) && field->background() > 0, "a background outside");
  for (std::size_t b = 0; b < field->brickCount(); ++b)
    for (const float value : field->brick(b)) fuzz::require(std::isfinite(value), "finite distances");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::ScratchFile file("anatomy.vdb");
  file.fill(data, size);
  const auto grids = inspectVdb(file.path());
  if (!grids) fuzz::requireError(grids.error());

  readField(file.path(), "phi");
  readField(file.path(), "sweep");
  const Expected<MaterialField> materials = readMaterialField(file.path());
  if (!materials) fuzz::requireError(materials.error());
  return 0;
}
