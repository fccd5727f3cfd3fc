#include <cmath>

#include "preprocess/bake/case_recipe.h"
#include "tests/fuzz/file_harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kerf;
  static const Expected<MaterialTable> materials = readDefaultMaterials();
  static const fuzz::ScratchFile file("recipe.toml");
  fuzz::require(materials.has_value(), "the program's own materials");
  file.fill(data, size);
  const Expected<CaseRecipe> recipe = readCaseRecipe(file.path(), *materials);
  if (!recipe) {
    fuzz::requireError(recipe.error());
    return 0;
  }
  fuzz::require(!recipe->parts.empty(), "a recipe has parts");
  for (const RecipePart& part : recipe->parts) {
    const int kinds = (part.mesh.empty() ? 0 : 1) + (part.depth ? 1 : 0) + (part.label ? 1 : 0);
    fuzz::require(kinds == 1, "a part is a mesh, a depth or a label");
    fuzz::require(!part.origin().empty(), "a part can be told");
    fuzz::require(!part.label || recipe->labels, "labels come with a volume");
  }
  fuzz::require(!recipe->voxel_mm || (std::isfinite(*recipe->voxel_mm) && *recipe->voxel_mm > 0), "a voxel has a size");
  recipe->meshes();
  return 0;
}
