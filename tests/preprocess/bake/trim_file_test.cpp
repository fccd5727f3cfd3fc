// A trim file repeats the cuts of a scan, bit for bit.
#include "preprocess/bake/trim_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "geometry/formats/mesh_writer.h"
#include "preprocess/bake/bake.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/support/temporary_folder.h"

namespace kerf::trim_file_test {
namespace {

namespace fs = std::filesystem;

std::vector<ScanTrim> someTrims() {
  OutlineTrim lasso{{{0.1, 1.0 / 3, -0.0}, {4e-9, 0, 5}, {10, 8, 5}}, Vec3d(1, 2, -3).normalized(), {}, true};
  OutlineTrim seen = lasso;
  seen.eye = Vec3d(-200.0 / 7, -300, 400);
  seen.keeps_inside = false;
  return {lasso, seen, PlaneTrim{{0, 0, 1.0 / 7}, Vec3d(0.3, -0.4, 0.1).normalized()}};
}

TEST(TrimFile, ReadsBackTheSameBits) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "a.toml";
  ASSERT_TRUE(writeTrims(file, someTrims()));
  const auto read = readTrims(file);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(*read, someTrims());
  EXPECT_EQ(textOf(*read), textOf(someTrims()));
}

TEST(TrimFile, ErrorsNameFileAndKey) {
  const TemporaryFolder folder;
  const std::string head = "format = \"kerf-trim\"\nversion = 1\n[[trim]]\n";
  const std::pair<std::string, const char*> cases[] = {
      {"format = \"kerf-recipe\"\nversion = 1\ntrim = []\n", "kerf-trim"},
      {head + "remove = \"inside\"\ndirection = [0, 0, 1]\n", "outline"},
      {head + "remove = \"all\"\ndirection = [0, 0, 1]\noutline = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\n", "remove"},
      {head + "remove = \"inside\"\ndirection = [0, 0, 0]\noutline = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\n", "direction"},
      {head + "remove = \"inside\"\ndirection = [0, 0, 1]\noutline = [[0, 0, 0], [1, 0, 0]]\n", "3 to 10000"},
      {head + "point = [0, 0, 0]\nnormal = [0, 0, nan]\n", "normal"},
      {head + "point = [0, 0, 0]\nnormal = [0, 0, 1]\nside = 1\n", "side"}};
  for (const auto& [text, words] : cases) {
    const auto read = readTrims(folder.write("bad.toml", text));
    ASSERT_FALSE(read) << text;
    EXPECT_NE(read.error().message().find("bad.toml"), std::string::npos) << read.error().message();
    EXPECT_NE(read.error().message().find(words), std::string::npos) << read.error().message();
  }
}

TEST(TrimFile, TheFileOfACaseBakesTheSameCase) {
  const TemporaryFolder folder;
  const fs::path scan = folder.path() / "ball.ply", first = folder.path() / "first.case";
  ASSERT_TRUE(writeMesh(scan, ballMesh({0, 0, 0}, 5, 30)));
  BakeOptions options;
  options.voxelize.voxel_mm = 0.3;
  options.close.trims = {PlaneTrim{{0, 0, -1}, -Vec3d::UnitZ()}};
  const auto baked = bake({scan}, first, options);
  ASSERT_TRUE(baked) << baked.error().message();
  EXPECT_GT(baked->manifest.closing.at("triangles_cut_away"), 0);
  EXPECT_GT(baked->manifest.closing.at("cut_away_mm2"), 1);

  const auto known = readTrims(first);
  ASSERT_TRUE(known) << known.error().message();
  EXPECT_EQ(*known, options.close.trims);
  options.close.trims = *known;
  const auto again = bake({scan}, first, options);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->was_up_to_date);

  options.close.trims.clear();
  const auto whole = bake({scan}, folder.path() / "whole.case", options);
  ASSERT_TRUE(whole);
  EXPECT_NE(whole->manifest.id, baked->manifest.id);
  EXPECT_EQ(readTrims(folder.path() / "whole.case").error().code, Error::Code::kNotFound);
}

// As much as that would hold the window for minutes.
TEST(TrimFile, TooManyCutsAreRefused) {
  const TemporaryFolder folder;
  const std::vector<ScanTrim> many(101, PlaneTrim{{0, 0, 1}, Vec3d::UnitZ()});
  ASSERT_TRUE(writeTrims(folder.path() / "trim.toml", many));
  const auto read = readTrims(folder.path() / "trim.toml");
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message().find("at most 100 cuts"), std::string::npos) << read.error().message();
  ASSERT_TRUE(writeTrims(folder.path() / "trim.toml", std::span(many).first(100)));
  EXPECT_TRUE(readTrims(folder.path() / "trim.toml"));
}

TEST(TrimFile, ARecipeTakesNoTrims) {
  const TemporaryFolder folder;
  ASSERT_TRUE(writeMesh(folder.path() / "ball.ply", ballMesh({0, 0, 0}, 5, 30)));
  const fs::path recipe = folder.write("ball.toml",
                                       "format = \"kerf-recipe\"\nversion = 1\n[[part]]\nmaterial = \"dentin\"\n"
                                       "mesh = \"ball.ply\"\n");
  BakeOptions options;
  options.close.trims = {PlaneTrim{{0, 0, -1}, -Vec3d::UnitZ()}};
  const auto baked = bakeRecipe(recipe, folder.path() / "ball.case", options);
  ASSERT_FALSE(baked);
  EXPECT_NE(baked.error().message().find("--trim"), std::string::npos) << baked.error().message();
}

}  // namespace
}  // namespace kerf::trim_file_test
