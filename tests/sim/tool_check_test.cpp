#include "sim/tool_check.h"

#include <gtest/gtest.h>

#include "geometry/tool_file.h"

namespace kerf {
namespace {

TEST(ToolCheck, EveryToolThatComesWithKerfRemovesWhatItsNumbersSay) {
  const auto tools = listTools({std::filesystem::path(KERF_SOURCE_DIR) / "assets/tools"});
  ASSERT_GE(tools.size(), 3u);
  for (const ToolListing& listing : tools) {
    ASSERT_TRUE(listing.tool) << listing.error->message();
    const auto check = checkTool(*listing.tool);
    ASSERT_TRUE(check) << check.error().message();
    EXPECT_TRUE(check->passed()) << listing.tool->id << ": " << check->removed_mm3 << " instead of "
                                 << check->expected_mm3;
  }
}

TEST(ToolCheck, AToolThatCutsWiderThanItsNumbersFails) {
  auto tool = readTool(std::filesystem::path(KERF_SOURCE_DIR) / "assets/tools/round-014.toml");
  ASSERT_TRUE(tool);
  tool->cut = std::make_shared<RevolvedShape>(RevolvedProfile().arcTo({0, 0.705}, {0, 1.41}));  // 1.4 % more volume
  const auto check = checkTool(*tool);
  ASSERT_TRUE(check) << check.error().message();
  EXPECT_FALSE(check->passed());
  EXPECT_GT(check->errorPercent(), 1.0);
}

TEST(ToolCheck, AVoxelTooCoarseForTheToolIsRefused) {
  const auto tool = readTool(std::filesystem::path(KERF_SOURCE_DIR) / "assets/tools/round-014.toml");
  ASSERT_TRUE(tool);
  EXPECT_FALSE(checkTool(*tool, 0.5));
  EXPECT_FALSE(checkTool(*tool, -0.1));
}

}  // namespace
}  // namespace kerf
