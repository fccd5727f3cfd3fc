#include "geometry/field/material.h"
#include "tests/fuzz/file_harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kerf;
  static const fuzz::ScratchFile file("materials.toml");
  file.fill(data, size);
  const Expected<MaterialTable> table = readMaterials(file.path());
  if (!table) {
    fuzz::requireError(table.error());
    return 0;
  }
  for (const MaterialProperties& row : table->rows()) {
    fuzz::require(table->find(row.id) == &row && table->find(row.material) == &row, "ids and numbers are not repeated");
    fuzz::require(static_cast<int>(row.material) >= 0 && static_cast<int>(row.material) <= 255, "a voxel can hold it");
  }
  return 0;
}
