#include "sim/run/sweep/tool_check.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/tool/tool_file.h"
#include "tests/support/places.h"

namespace kerf::tool_check_test {
namespace {

// One case per tool, so that they run in parallel and name the failing tool.
class EveryTool : public ::testing::TestWithParam<std::filesystem::path> {};

TEST_P(EveryTool, RemovesWhatItsNumbersSayAtTenVoxelsPerDiameter) {
  const auto tool = readTool(GetParam());
  ASSERT_TRUE(tool) << tool.error().message();
  const double voxel =
      tool->kind == ToolKind::kBur ? std::min(tool->head_diameter_mm / 10, tool->finest() / 3) : defaultVoxel(*tool);
  const auto check = checkTool(*tool, voxel);
  ASSERT_TRUE(check) << check.error().message();
  EXPECT_LE(std::abs(check->errorPercent()), 1.0) << check->removed_mm3 << " instead of " << check->expected_mm3;
}

std::vector<std::filesystem::path> filesOfTheRack() {
  std::vector<std::filesystem::path> files;
  for (const ToolListing& tool : listTools({std::filesystem::path(kSourceFolder) / "assets/tools"}))
    files.push_back(tool.file);
  return files;
}

std::string caseName(const ::testing::TestParamInfo<std::filesystem::path>& which) {
  std::string name = which.param.stem().string();
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(ThatComesWithKerf, EveryTool, ::testing::ValuesIn(filesOfTheRack()), caseName);

TEST(ToolCheck, ToolsRemoveWhatTheirNumbersSayAtTheDefaultVoxel) {
  for (const char* id : {"round-014", "us-35", "us-957", "878k-016", "saw-sagittal-6"}) {
    const auto tool = readTool(std::filesystem::path(kSourceFolder) / "assets/tools" / (std::string(id) + ".toml"));
    ASSERT_TRUE(tool) << tool.error().message();
    const auto check = checkTool(*tool);
    ASSERT_TRUE(check) << check.error().message();
    EXPECT_TRUE(check->passed()) << id << ": " << check->removed_mm3 << " instead of " << check->expected_mm3;
  }
}

TEST(ToolCheck, AToolThatCutsWiderThanItsNumbersFails) {
  auto tool = readTool(std::filesystem::path(kSourceFolder) / "assets/tools/round-014.toml");
  ASSERT_TRUE(tool);
  tool->cut = std::make_shared<RevolvedShape>(RevolvedProfile().arcTo({0, 0.705}, {0, 1.41}));  // 1.4 % more volume
  const auto check = checkTool(*tool);
  ASSERT_TRUE(check) << check.error().message();
  EXPECT_FALSE(check->passed());
  EXPECT_GT(check->errorPercent(), 1.0);
}

TEST(ToolCheck, ReportsHowFarItIsAndStopsWhenItIsTold) {
  const auto tool = readTool(std::filesystem::path(kSourceFolder) / "assets/tools/round-014.toml");
  ASSERT_TRUE(tool);
  std::vector<double> while_plunging;
  const auto check = checkTool(*tool, 0, [&](double fraction, std::string_view what) {
    if (what == "plunging") while_plunging.push_back(fraction);
    return true;
  });
  ASSERT_TRUE(check) << check.error().message();
  EXPECT_EQ(check->removed_mm3, checkTool(*tool)->removed_mm3) << "whether somebody watches or not";
  EXPECT_GT(while_plunging.size(), 5u);
  EXPECT_TRUE(std::is_sorted(while_plunging.begin(), while_plunging.end()));

  std::size_t asked_after = 0;
  bool is_stopped = false;
  const auto stopped = checkTool(*tool, 0, [&](double fraction, std::string_view) {
    asked_after += is_stopped;
    is_stopped |= fraction > 0.3;
    return !is_stopped;
  });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, Error::Code::kCancelled);
  EXPECT_EQ(asked_after, 0u) << "it went on";
}

TEST(ToolCheck, AVoxelTooCoarseForTheToolIsRefused) {
  const auto tool = readTool(std::filesystem::path(kSourceFolder) / "assets/tools/round-014.toml");
  ASSERT_TRUE(tool);
  EXPECT_FALSE(checkTool(*tool, 0.5));
  EXPECT_FALSE(checkTool(*tool, -0.1));
}

}  // namespace
}  // namespace kerf::tool_check_test
