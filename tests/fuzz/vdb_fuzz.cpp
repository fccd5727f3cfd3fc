// The grids of a .vdb file: fields, materials and the text of `kerf info` about them.
#include <cmath>

#include "geometry/field/material_bricks.h"
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

// Materials added by a run to a case.
void readBricks(const std::filesystem::path& file, const Expected<MaterialField>& in_case) {
  const Expected<MaterialBricks> bricks = readMaterialBricks(file);
  if (!bricks) return fuzz::requireError(bricks.error());
  fuzz::require(bricks->bricks.size() == bricks->numbers.size(), "a brick for each of the numbers");
  for (std::size_t b = 0; b < bricks->bricks.size(); ++b) {
    fuzz::require(bricks->find(bricks->bricks[b]) == &bricks->numbers[b], "bricks that are found");
    for (const std::uint8_t number : bricks->numbers[b]) fuzz::require(number > 0, "numbers of materials");
  }
  if (!in_case || !requireOnlyAdded(*bricks, *in_case, Material::kGeneric)) return;
  const MaterialField labels = laidOver(*in_case, *bricks);
  for (const Vec3i& brick : bricks->bricks) (void)labels.oneOf(brick);
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
  readBricks(file.path(), materials);
  return 0;
}
