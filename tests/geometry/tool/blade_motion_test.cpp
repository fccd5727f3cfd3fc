#include "geometry/tool/blade_motion.h"

#include <gtest/gtest.h>

#include <set>

#include "geometry/tool/tool_file.h"
#include "tests/support/places.h"

namespace kerf::blade_motion_test {
namespace {

TEST(BladeMotions, HaveNamesOfTheirOwnAndAreFoundByThem) {
  std::set<std::string> names;
  for (const BladeMotion* motion : bladeMotions()) {
    EXPECT_TRUE(names.insert(motion->name).second) << motion->name;
    EXPECT_EQ(findBladeMotion(motion->name), motion);
    EXPECT_EQ(findBladeMotion(motion->also_called), nullptr) << "another word is no name";
    EXPECT_FALSE(motion->keys.empty()) << motion->name;
    EXPECT_LT(motion->drive_keys.low, motion->drive_keys.high) << motion->name;
  }
  EXPECT_EQ(findBladeMotion(""), nullptr);
}

// Every row must have a tool in the rack, which tests its drawing, its sound and its removal.
TEST(BladeMotions, HaveEachAToolInTheRackThatCutsAndMoves) {
  std::set<const BladeMotion*> seen;
  for (const ToolListing& listing : listTools({std::filesystem::path(kSourceFolder) / "assets/tools"})) {
    ASSERT_TRUE(listing.tool) << listing.file;
    const Tool& tool = *listing.tool;
    EXPECT_EQ(tool.motion != nullptr, tool.kind == ToolKind::kBlade) << tool.id;
    if (!tool.motion) continue;
    seen.insert(tool.motion);
    EXPECT_GT(tool.motion->way(tool), 0) << tool.id;
    EXPECT_GT(tool.motion->plunge_volume(tool, 1, 4), 0) << tool.id;
    EXPECT_FALSE(tool.motion->mesh(tool, 0.01).triangles.empty()) << tool.id;
    EXPECT_NE(toJson(tool).find(tool.motion->numbers(tool).front().first), std::string::npos) << tool.id;
    EXPECT_NE(describe(tool).find(tool.motion->describe(tool)), std::string::npos) << tool.id;
    const DriveNumbers drive = tool.motion->usual_drive(tool);
    EXPECT_EQ(drive.frequency_hz.has_value(), tool.motion->form != ToolMotion::kSpin)
        << "only a disc is driven as a bur";
  }
  EXPECT_EQ(seen.size(), bladeMotions().size());
}

}  // namespace
}  // namespace kerf::blade_motion_test
