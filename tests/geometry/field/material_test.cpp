#include "geometry/field/material.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temporary_file.h"

namespace kerf::material_test {
namespace {

TEST(Materials, TheTableThatComesWithKerfKnowsEveryTissue) {
  const auto table = readDefaultMaterials();
  ASSERT_TRUE(table) << table.error().message();
  for (int n = 1; n <= static_cast<int>(Material::kPdl); ++n)
    EXPECT_NE(table->find(static_cast<Material>(n)), nullptr) << "number " << n;
  const auto enamel = table->require("enamel"), dentin = table->require("dentin");
  ASSERT_TRUE(enamel && dentin);
  EXPECT_EQ(enamel->material, Material::kEnamel);
  EXPECT_GT(enamel->hardness.value, 3 * dentin->hardness.value);
  EXPECT_FALSE(enamel->hardness.source.empty());
}

TEST(Materials, AnUnknownOneIsRefusedWithTheListOfThose) {
  const auto table = readDefaultMaterials();
  ASSERT_TRUE(table);
  const auto row = table->require("adamantium");
  ASSERT_FALSE(row);
  EXPECT_NE(row.error().message().find("enamel, dentin"), std::string::npos);
}

struct Mistake {
  const char* from;
  const char* to;
  const char* message;  // part of it
};

class MaterialMistake : public testing::TestWithParam<Mistake> {};

TEST_P(MaterialMistake, IsNamedWithItsKey) {
  const auto file = findMaterialsFile();
  ASSERT_TRUE(file);
  std::ifstream in(*file);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const auto at = text.find(GetParam().from);
  ASSERT_NE(at, std::string::npos) << GetParam().from;
  text.replace(at, std::string(GetParam().from).size(), GetParam().to);
  const TemporaryFile copy("materials.toml", text);
  const auto table = readMaterials(copy.path());
  ASSERT_FALSE(table);
  EXPECT_NE(table.error().message().find(GetParam().message), std::string::npos) << table.error().message();
}

INSTANTIATE_TEST_SUITE_P(Materials, MaterialMistake,
                         testing::Values(Mistake{"kerf-materials", "kerf-tool", "format"},
                                         Mistake{"\"g/cm3\"", "\"kg/m3\"", "g/cm3"},
                                         Mistake{"number = 2", "number = 1", "number 1 a second time"},
                                         Mistake{"id = \"dentin\"", "id = \"enamel\"", "the id a second time"},
                                         Mistake{"number = 1\n", "number = 256\n", "1 to 255"},
                                         Mistake{"number = 9\n", "number = 12\n", "from 32 on"},
                                         Mistake{"friction = { value = 0.3", "friction = { value = 0", "friction"},
                                         Mistake{"#f4f1e8", "#f4f1ez", "#rrggbb"},
                                         Mistake{"hardness = {", "hardnes = {", "hardness"},
                                         Mistake{"value = 275", "value = nan", "HV"},
                                         Mistake{"id = \"pulp\"", "id = \"Pulp!\"", "lower-case"}));

}  // namespace
}  // namespace kerf::material_test
