#include "geometry/field/vdb_io.h"

#include <gtest/gtest.h>

#include "tests/geometry/sampled_field.h"
#include "tests/support/temporary_folder.h"

namespace kerf {
namespace {

TEST(VdbIo, FieldsComeBackBitForBitWithTheirDeepInside) {
  const TemporaryFolder folder;
  BrickField field(0.05, 0.2f, -0.25f);
  for (std::size_t n = 0; n < kBrickNodes; ++n)
    field.brick(field.touch({-3, 2, 1}))[n] = 1e-3f * static_cast<float>(n) - 0.2f;
  field.markInterior({-2, 2, 1});
  field.markInterior({40, -17, 3});
  ASSERT_TRUE(writeVdb(folder.path() / "f.vdb", {{"phi", &field}}));
  const auto back = readVdb(folder.path() / "f.vdb", "phi");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->stateHash(), field.stateHash());
  EXPECT_EQ(back->interior(), -0.25f);
  EXPECT_EQ(back->at({-15, 17, 9}), -0.25f);
  EXPECT_EQ(back->at({8 * 40, 8 * -17, 8 * 3 + 7}), -0.25f);
  EXPECT_EQ(back->at({0, 0, 0}), 0.2f);
  EXPECT_EQ(back->interiorBricks().size(), 2u);
}

TEST(VdbIo, AMissingFileOrGridIsAnError) {
  const TemporaryFolder folder;
  EXPECT_FALSE(readVdb(folder.path() / "none.vdb", "phi"));
  const BrickField field(0.1, 0.3f);
  ASSERT_TRUE(writeVdb(folder.path() / "f.vdb", {{"phi", &field}}));
  const auto other = readVdb(folder.path() / "f.vdb", "sweep");
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message().find("sweep"), std::string::npos);
}

}  // namespace
}  // namespace kerf
