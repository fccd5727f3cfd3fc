#include "preprocess/bake/case_recipe.h"

#include <gtest/gtest.h>

#include "tests/support/temporary_file.h"

namespace kerf::case_recipe_test {
namespace {

const std::string kHead = "format = \"kerf-recipe\"\nversion = 1\n";
const std::string kTooth = "[[part]]\nmaterial = \"dentin\"\nmesh = \"tooth.stl\"\n";

Expected<CaseRecipe> read(const std::string& text) {
  const TemporaryFile file("case.toml", text);
  KERF_TRY(materials, readDefaultMaterials());
  return readCaseRecipe(file.path(), materials);
}

TEST(CaseRecipe, KeepsThePartsInTheOrderOfTheirPriority) {
  const auto recipe =
      read(kHead +
           "name = \"A tooth\"\nunit = \"mm\"\nvoxel = 0.05\nfallback = \"gingiva\"\n"
           "[[part]]\nmaterial = \"pulp\"\nmesh = \"pulp.stl\"\n"
           "[[part]]\nmaterial = \"enamel\"\ndepth = 1.5\nabove = { point = [0, 0, 5], normal = [0, 0, 2] }\n"
           "replaces = [\"dentin\"]\n" +
           kTooth + "[[part]]\nmaterial = \"cortical\"\nlabel = 2\n" +
           "[outline]\nmeshes = [\"tooth.stl\", \"socket.stl\"]\n"
           "[labels]\nvolume = \"ct.nii.gz\"\nspacing = [0.2, 0.2, 0.5]\nthreshold = 120\nsmoothing = 1\n"
           "[region]\nline = [[0, 0, 5], [10, 0, 5.5]]\nradius = 3\nvoxel = 0.025\n");
  ASSERT_TRUE(recipe) << recipe.error().message();

  EXPECT_EQ(recipe->name, "A tooth");
  EXPECT_EQ(recipe->voxel_mm, 0.05);
  EXPECT_EQ(recipe->fallback, Material::kGingiva);

  ASSERT_EQ(recipe->parts.size(), 4u);
  EXPECT_EQ(recipe->parts[0].origin(), "pulp.stl");
  EXPECT_EQ(recipe->parts[1].origin(), "depth < 1.5 mm, above a plane");
  EXPECT_EQ(recipe->parts[1].depth->above->normal, Vec3d::UnitZ()) << "made a unit vector";
  EXPECT_EQ(recipe->parts[1].replaces, std::vector{Material::kDentin});
  EXPECT_EQ(recipe->parts[3].origin(), "label 2");
  EXPECT_EQ(recipe->meshes(), (std::vector<std::filesystem::path>{"pulp.stl", "tooth.stl", "socket.stl"}));
  EXPECT_EQ(recipe->labels->threshold, 120);
  ASSERT_TRUE(recipe->region);
  EXPECT_EQ(recipe->region->line, (std::vector<Vec3d>{{0, 0, 5}, {10, 0, 5.5}}));
  EXPECT_EQ(recipe->region->radius_mm, 3);
  EXPECT_EQ(recipe->region->voxel_mm, 0.025);
  EXPECT_EQ(recipe->resolve("a.stl").filename(), "a.stl");
  EXPECT_TRUE(recipe->resolve("a.stl").has_parent_path()) << "relative to the recipe, not to where Kerf runs";
}

struct Mistake {
  std::string text;
  const char* message;  // part of it
};

class RecipeMistake : public testing::TestWithParam<Mistake> {};

TEST_P(RecipeMistake, IsNamedWithWhatWasExpected) {
  const auto recipe = read(GetParam().text);
  ASSERT_FALSE(recipe);
  EXPECT_NE(recipe.error().message().find(GetParam().message), std::string::npos) << recipe.error().message();
  EXPECT_NE(recipe.error().message().find("case.toml"), std::string::npos) << "names the file";
}

INSTANTIATE_TEST_SUITE_P(
    CaseRecipe, RecipeMistake,
    testing::Values(
        Mistake{kHead, "part"}, Mistake{"format = \"kerf-tool\"\nversion = 1\n" + kTooth, "kerf-recipe"},
        Mistake{"format = \"kerf-recipe\"\nversion = 2\n" + kTooth, "version"},
        Mistake{kHead + "[[part]]\nmaterial = \"wood\"\nmesh = \"a.stl\"\n", "one of enamel, dentin"},
        Mistake{kHead + "[[part]]\nmaterial = \"wood\"\nmesh = \"a.stl\"\n",
                "Try: another id, or a [[material]] of that id in materials.toml"},
        Mistake{kHead + "[[part]]\nmaterial = \"pulp\"\n", "exactly one of mesh, depth and label"},
        Mistake{kHead + "[[part]]\nmaterial = \"pulp\"\nmesh = \"a.stl\"\ndepth = 1\n", "exactly one of mesh"},
        Mistake{kHead + kTooth + "[[part]]\nmaterial = \"enamel\"\ndepth = -1\n", "0.01 to 50"},
        Mistake{kHead + kTooth + "above = { point = [0, 0, 0], normal = [0, 0, 1] }\n", "beside no depth"},
        Mistake{kHead + kTooth +
                    "[[part]]\nmaterial = \"enamel\"\ndepth = 1\nabove = { point = [0, 0, 0], normal = [0, 0, 0] }\n",
                "no direction"},
        Mistake{kHead + kTooth + "replaces = []\n", "empty list"},
        Mistake{kHead + kTooth + "meshh = \"b.stl\"\n", "meshh"},
        Mistake{kHead + "[[part]]\nmaterial = \"enamel\"\nlabel = 0\n", "1 to 65535"},
        Mistake{kHead + "[[part]]\nmaterial = \"enamel\"\nlabel = 3\n", "[labels]"},
        Mistake{kHead + kTooth + "[labels]\nvolume = \"a.nrrd\"\n", "no part says label"},
        Mistake{kHead + "[[part]]\nmaterial = \"enamel\"\ndepth = 1\n", "nothing but depths"},
        Mistake{kHead + "unit = \"furlong\"\n" + kTooth, "inch"}, Mistake{kHead + "voxel = 0\n" + kTooth, "0.005"},
        Mistake{kHead + kTooth + "[outline]\nmeshes = []\n", "one or more mesh files"},
        Mistake{kHead + "outline = \"tooth.stl\"\n" + kTooth, "[outline]"}, Mistake{kHead + "part = 3\n", "[[part]]"},
        Mistake{kHead + "[[part]]\nmaterial = \"pulp\"\nmesh = \"\"\n", "an empty name"},
        Mistake{kHead + kTooth + "[outline]\nmeshes = [\"\"]\n", "an empty name"},
        Mistake{kHead + "[[parts]]\nmaterial = \"pulp\"\n", "Try: part"},
        Mistake{kHead + kTooth + "[region]\nline = [0, 0, 5]\nradius = 3\nvoxel = 0.05\n", "list of points"},
        Mistake{kHead + kTooth + "[region]\nline = [[0, 0, nan]]\nradius = 3\nvoxel = 0.05\n", "list of points"},
        Mistake{kHead + kTooth + "[region]\nline = [[0, 0, 5]]\nradius = 0\nvoxel = 0.05\n", "0.1"},
        Mistake{kHead + kTooth + "[region]\nline = [[0, 0, 5]]\nradius = 3\n", "voxel"}));

}  // namespace
}  // namespace kerf::case_recipe_test
