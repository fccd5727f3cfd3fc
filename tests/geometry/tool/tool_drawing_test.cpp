#include "geometry/tool/tool_drawing.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/tool/tool_file.h"
#include "geometry/tool/tool_template.h"
#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

namespace kerf::tool_drawing_test {
namespace {

const std::filesystem::path kRack = std::filesystem::path(kSourceFolder) / "assets/tools";

TEST(ToolDrawing, StatesNameCodeAndDimensions) {
  const auto tool = readTool(kRack / "856-016.toml");
  ASSERT_TRUE(tool) << tool.error().message();
  const std::string svg = toolDrawing(*tool);
  for (const char* said : {"Round-end taper 856/016", "806314198524016", ">8.0<", "⌀ 1.6", "2.0 mm<"})
    EXPECT_NE(svg.find(said), svg.npos) << said;
}

TEST(ToolDrawing, OfEveryToolIsWellFormedAndInsideItsSheet) {
  for (const ToolListing& t : listTools({kRack})) {
    ASSERT_TRUE(t.tool);
    const std::string svg = toolDrawing(*t.tool);
    EXPECT_EQ(svg.substr(0, 5), "<svg ");
    EXPECT_EQ(svg.substr(svg.size() - 7), "</svg>\n");
    EXPECT_EQ(svg.find("nan"), svg.npos) << t.tool->id;
    EXPECT_EQ(svg.find("inf"), svg.npos) << t.tool->id;
    for (std::size_t at = svg.find("points=\""); at != svg.npos; at = svg.find("points=\"", at + 1)) {
      std::istringstream points(svg.substr(at + 8, svg.find('"', at + 8) - at - 8));
      double x, y;
      for (char comma; points >> x >> comma >> y;) {
        EXPECT_GE(x, 0) << t.tool->id;
        EXPECT_LE(x, 720) << t.tool->id;
        EXPECT_GE(y, 110) << t.tool->id;
        EXPECT_LE(y, 900) << t.tool->id;
      }
    }
  }
}

TEST(ToolDrawing, TextFromAFileStaysText) {
  auto tool = readTool(kRack / "round-014.toml");
  ASSERT_TRUE(tool);
  tool->name = "<script>&\"";
  EXPECT_NE(toolDrawing(*tool).find("&lt;script&gt;&amp;&quot;"), std::string::npos);
}

TEST(ToolTemplate, OfEveryShapeIsAToolAsItIsAndWithEveryCommentedKey) {
  const TemporaryFolder folder;
  for (const HeadShape& shape : headShapes()) {
    const std::string text = toolTemplate(shape, "my-bur");
    const auto tool = readTool(folder.write("my-bur.toml", text));
    ASSERT_TRUE(tool) << tool.error().message() << "\n" << text;
    EXPECT_EQ(tool->shape, shape.name);
    EXPECT_NEAR(tool->head_diameter_mm, 1.6, 1e-12);
    EXPECT_NEAR(tool->body->bounds().max[2], 19, 1e-9);
    std::string all = text;  // every key of the head, the optional ones too
    for (const HeadShape::Key& key : shape.keys)
      if (const std::size_t at = all.find(fmt::format("# {} =", key.name)); at != all.npos) all.erase(at, 2);
    const auto full = readTool(folder.write("my-bur.toml", all));
    EXPECT_TRUE(full) << full.error().message() << "\n" << all;
  }
}

TEST(ToolTemplate, OfEveryMotionIsABladeAsItIs) {
  const TemporaryFolder folder;
  for (const BladeMotion* motion : bladeMotions()) {
    const std::string text = bladeTemplate(*motion, "my-saw");
    const auto tool = readTool(folder.write("my-saw.toml", text));
    ASSERT_TRUE(tool) << motion->name << ": " << tool.error().message() << "\n" << text;
    EXPECT_EQ(tool->motion, motion);
    for (const char* key : motion->keys) EXPECT_NE(text.find(std::string(key) + " = "), text.npos) << key;
  }
}

TEST(ToolTemplate, OfAMeshIsAToolWhenTheMeshIsThere) {
  const TemporaryFolder folder;
  const std::string text = meshToolTemplate("point.off", "my-mesh");
  const auto without = readTool(folder.write("my-mesh.toml", text));
  ASSERT_FALSE(without);
  EXPECT_NE(without.error().message().find("point.off"), std::string::npos) << without.error().message();
  folder.write("point.off",
               "OFF\n5 6 0\n0 0 0\n1 1 8\n-1 1 8\n-1 -1 8\n1 -1 8\n"
               "3 0 2 1\n3 0 3 2\n3 0 4 3\n3 0 1 4\n3 1 2 3\n3 1 3 4\n");
  const auto tool = readTool(folder.path() / "my-mesh.toml");
  EXPECT_TRUE(tool) << tool.error().message();
}

}  // namespace
}  // namespace kerf::tool_drawing_test
