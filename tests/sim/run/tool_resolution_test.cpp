#include "sim/run/sweep/tool_resolution.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "geometry/tool/tool_file.h"
#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

namespace kerf::tool_resolution_test {
namespace {

std::vector<std::filesystem::path> rackFolder() { return {std::filesystem::path(kSourceFolder) / "assets/tools"}; }

Tool toolOfRack(const std::string& id) {
  const auto tool = readTool(rackFolder().front() / (id + ".toml"));
  EXPECT_TRUE(tool) << id;
  return *tool;
}

std::set<std::string> tooCoarseOfRack(double voxel, Held held = Held::kByHand) {
  std::set<std::string> out;
  for (const ToolListing& listed : listTools(rackFolder()))
    if (tooCoarseFor(toolOfRack(listed.file.stem().string()), voxel, held)) out.insert(listed.file.stem().string());
  return out;
}

// (0.3 - 0.2) / 2 wider where the taper is (1.2 - 0.2) / 2 on 10 mm: 1 mm, and a little more until a ball fits.
TEST(ToolResolution, TheLengthOfAPointIsThatOfItsTaper) {
  EXPECT_NEAR(pointLength(toolOfRack("859-012"), 0.3), 1.05, 0.05);
  EXPECT_NEAR(pointLength(toolOfRack("round-014"), 0.3), 0.15, 0.02);  // a ball fits at once
  EXPECT_NEAR(pointLength(toolOfRack("837-012"), 0.3), 0.15, 0.02);    // a flat end, too
  EXPECT_NEAR(pointLength(toolOfRack("round-005"), 0.6), 0.5, 0.02);   // never: the whole head
  EXPECT_EQ(pointLength(toolOfRack("saw-reciprocating-25"), 0.3), 0);
}

TEST(ToolResolution, FlamesAndNeedlesArePointedAndOthersOnlyToCoarseVoxels) {
  const std::set<std::string> flames{"862-012", "862-016", "863-012"};
  EXPECT_EQ(tooCoarseOfRack(0.05), flames);
  std::set<std::string> pointed = flames;
  pointed.insert({"858-012", "859-012"});
  EXPECT_EQ(tooCoarseOfRack(0.1), pointed);
  EXPECT_EQ(tooCoarseOfRack(0.1, Held::kOnPath), std::set<std::string>{});
  EXPECT_TRUE(tooCoarseOfRack(0.25, Held::kOnPath).contains("859-012"));
  const std::set<std::string> coarse = tooCoarseOfRack(0.25);
  for (const char* id : {"us-169", "round-005", "disc-22", "saw-die-254"}) EXPECT_TRUE(coarse.contains(id)) << id;
  for (const char* id : {"round-018", "drill-28", "368-023", "801-014"}) EXPECT_FALSE(coarse.contains(id)) << id;
}

TEST(ToolResolution, SaysWhatIsThinAndWhichVoxelsAreNearer) {
  const auto flame = tooCoarseFor(toolOfRack("863-012"), 0.1, Held::kByHand);
  ASSERT_TRUE(flame);
  EXPECT_NE(flame->what.find("863-012 is thinner than three voxels for 0.9 mm"), std::string::npos) << flame->what;
  EXPECT_NEAR(flame->finer_mm, 0.05, 1e-9);
  const auto ball = tooCoarseFor(toolOfRack("round-005"), 0.4, Held::kByHand);
  ASSERT_TRUE(ball);
  EXPECT_NE(ball->what.find("round-005 cuts 1.2 voxels wide"), std::string::npos) << ball->what;
  EXPECT_FALSE(tooCoarseFor(toolOfRack("863-012"), 0, Held::kByHand));
  const auto needle = tooCoarseFor(toolOfRack("859-012"), 0.25, Held::kOnPath);
  ASSERT_TRUE(needle);
  EXPECT_NE(needle->what.find("volumes may be off"), std::string::npos) << needle->what;
  EXPECT_FALSE(tooCoarseFor(toolOfRack("859-012"), needle->finer_mm, Held::kOnPath));
}

// Rounded to two digits, as in the message.
TEST(ToolResolution, WhoTakesTheAdviceForAThinToolIsNotWarnedAgain) {
  for (const ToolListing& listed : listTools(rackFolder())) {
    const Tool tool = toolOfRack(listed.file.stem().string());
    const double voxel = tool.finest() / 1.7;
    const auto thin = tooCoarseFor(tool, voxel, Held::kByHand);
    ASSERT_TRUE(thin) << tool.id;
    ASSERT_NE(thin->what.find("voxels wide"), std::string::npos) << thin->what;
    const double advised = std::stod(fmt::format("{:.2g}", thin->finer_mm));
    if (const auto again = tooCoarseFor(tool, advised, Held::kByHand)) {
      EXPECT_GT(pointLength(tool, 3 * advised), 4 * advised) << again->what;  // a flame: pointed at any voxel size
    }
  }
  EXPECT_FALSE(tooCoarseFor(toolOfRack("round-006"), 0.2, Held::kByHand));  // three voxels wide, rounded or not
}

TEST(ToolResolution, PointsThatResponsesLetThroughAreFlamesAndNeedles) {
  std::set<std::string> pointed;
  for (const ToolListing& listed : listTools(rackFolder()))
    if (isPointed(toolOfRack(listed.file.stem().string()))) pointed.insert(listed.file.stem().string());
  EXPECT_EQ(pointed, (std::set<std::string>{"858-012", "859-012", "862-012", "862-016", "863-012"}));
}

// A square rod of 0.2 mm, 4 mm long: turned, it is 0.28 mm wide.
TEST(ToolResolution, AThinMeshIsPointed) {
  const TemporaryFolder folder;
  folder.write("rod.obj",
               "v -0.1 -0.1 0\nv 0.1 -0.1 0\nv 0.1 0.1 0\nv -0.1 0.1 0\nv -0.1 -0.1 4\n"
               "v 0.1 -0.1 4\nv 0.1 0.1 4\nv -0.1 0.1 4\nf 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\n"
               "f 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n");
  folder.write("rod.toml",
               "format = \"kerf-tool\"\nversion = 1\nid = \"rod\"\nname = \"Rod\"\nkind = \"mesh\"\n"
               "mesh = \"rod.obj\"\nmm_per_unit = 1\ntip = [0, 0, 0]\naxis = [0, 0, 1]\ncut_below = 4\n");
  const auto rod = readTool(folder.path() / "rod.toml");
  ASSERT_TRUE(rod) << rod.error().message();
  EXPECT_NEAR(pointLength(*rod, 0.4), 4, 0.1);
  EXPECT_TRUE(isPointed(*rod));
  EXPECT_TRUE(tooCoarseFor(*rod, 0.1, Held::kByHand));
  EXPECT_FALSE(tooCoarseFor(*rod, 0.05, Held::kByHand));
}

}  // namespace
}  // namespace kerf::tool_resolution_test
