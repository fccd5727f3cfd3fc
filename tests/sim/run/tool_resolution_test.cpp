#include "sim/run/tool_resolution.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "geometry/tool/tool_file.h"

namespace kerf {
namespace {

std::vector<std::filesystem::path> rackFolder() { return {std::filesystem::path(KERF_SOURCE_DIR) / "assets/tools"}; }

Tool toolOfRack(const std::string& id) {
  const auto tool = readTool(rackFolder().front() / (id + ".toml"));
  EXPECT_TRUE(tool) << id;
  return *tool;
}

std::set<std::string> tooCoarseOfRack(double voxel) {
  std::set<std::string> out;
  for (const ToolListing& listed : listTools(rackFolder()))
    if (tooCoarseFor(toolOfRack(listed.file.stem().string()), voxel)) out.insert(listed.file.stem().string());
  return out;
}

// (0.3 - 0.2) / 2 wider where the taper is (1.2 - 0.2) / 2 on 10 mm: 1 mm, and a little as a ball is to fit.
TEST(ToolResolution, TheLengthOfAPointIsThatOfItsTaper) {
  EXPECT_NEAR(pointLength(toolOfRack("859-012"), 0.3), 1.05, 0.05);
  EXPECT_NEAR(pointLength(toolOfRack("round-014"), 0.3), 0.15, 0.02);  // a ball fits at once
  EXPECT_NEAR(pointLength(toolOfRack("837-012"), 0.3), 0.15, 0.02);    // a flat end, too
  EXPECT_NEAR(pointLength(toolOfRack("round-005"), 0.6), 0.5, 0.02);   // never: all of its head
  EXPECT_EQ(pointLength(toolOfRack("saw-reciprocating-25"), 0.3), 0);
}

TEST(ToolResolution, FlamesAndNeedlesArePointedAndOthersOnlyToCoarseVoxels) {
  const std::set<std::string> flames{"862-012", "862-016", "863-012"};
  EXPECT_EQ(tooCoarseOfRack(0.05), flames);
  std::set<std::string> pointed = flames;
  pointed.insert({"858-012", "859-012"});
  EXPECT_EQ(tooCoarseOfRack(0.1), pointed);
  const std::set<std::string> coarse = tooCoarseOfRack(0.25);
  for (const char* id : {"us-169", "round-005", "disc-22", "saw-die-254"}) EXPECT_TRUE(coarse.contains(id)) << id;
  for (const char* id : {"round-018", "drill-28", "368-023", "801-014"}) EXPECT_FALSE(coarse.contains(id)) << id;
}

TEST(ToolResolution, SaysWhatIsThinAndWhichVoxelsAreNearer) {
  const auto flame = tooCoarseFor(toolOfRack("863-012"), 0.1);
  ASSERT_TRUE(flame);
  EXPECT_NE(flame->what.find("863-012 is thinner than three voxels for 0.9 mm"), std::string::npos) << flame->what;
  EXPECT_NEAR(flame->finer_mm, 0.05, 1e-9);
  const auto ball = tooCoarseFor(toolOfRack("round-005"), 0.4);
  ASSERT_TRUE(ball);
  EXPECT_NE(ball->what.find("round-005 cuts 1.2 voxels wide"), std::string::npos) << ball->what;
  EXPECT_NEAR(ball->finer_mm, 0.5 / 3, 1e-9);
  EXPECT_FALSE(tooCoarseFor(toolOfRack("863-012"), 0));
}

}  // namespace
}  // namespace kerf
