#include "geometry/tool_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/geometry/sampled_field.h"
#include "tests/temporary_file.h"

namespace kerf {
namespace {

constexpr double kPi = std::numbers::pi;
const std::string kHead = "format = \"kerf-tool\"\nversion = 1\nid = \"a\"\nname = \"A\"\n";
const std::string kBur = kHead + "kind = \"bur\"\n";  // five lines

Tool bur(const std::string& keys) {
  const TemporaryFile file("a.toml", kBur + keys);
  auto tool = readTool(file.path());
  EXPECT_TRUE(tool) << tool.error().message();
  return tool ? *tool : Tool{};
}

// The definition, by brute force: at every level the widest radius that has passed.
double plungedNumerically(const Tool& tool, double depth) {
  constexpr int kSteps = 200000;
  double sum = 0, widest = 0;
  for (int n = 0; n < kSteps; ++n) {
    widest = std::max(widest, tool.head->radiusAt(depth * (n + 0.5) / kSteps));
    sum += widest * widest;
  }
  return kPi * sum * depth / kSteps;
}

TEST(ToolFile, ToolsThatComeWithKerfAreRead) {
  const auto tools = listTools({std::filesystem::path(KERF_SOURCE_DIR) / "assets/tools"});
  ASSERT_GE(tools.size(), 3u);
  for (const ToolListing& t : tools) EXPECT_TRUE(t.tool) << t.error->message();
}

TEST(ToolFile, ACopyCalledToolTomlKeepsItsId) {
  const TemporaryFile file("tool.toml", kBur + "shape = \"round\"\nhead_diameter = 1.4\n");
  const auto tool = readTool(file.path());
  ASSERT_TRUE(tool) << tool.error().message();
  EXPECT_EQ(tool->id, "a");
}

TEST(ToolFile, BadFilesAreRefusedWithLineAndKey) {
  struct Case {
    std::string text;
    const char *place, *what;
  };
  const std::string saw =
      kHead + "kind = \"blade\"\nmotion = \"reciprocating\"\nthickness = 0.4\nwidth = 5\nlength = 25\nstroke = 3\n";
  const Case cases[] = {
      {"format = 3 4", "line 1", ""},
      {"", "key format", "missing"},
      {"format = \"kerf-case\"\n", "line 1, key format", "kerf-tool"},
      {"format = \"kerf-tool\"\nversion = 2\nid = \"a\"\nname = \"A\"\nkind = \"bur\"\n", "line 2, key version",
       "expected 1"},
      {"format = \"kerf-tool\"\nversion = 1\nid = \"b\"\nname = \"A\"\nkind = \"bur\"\n", "line 3, key id", "\"a\""},
      {kHead + "kind = \"drill\"\n", "line 5, key kind", "blade"},
      {kHead + "knid = \"bur\"\nshape = \"round\"\nhead_diameter = 1\n", "line 5, key knid", "Try: kind"},
      {kBur + "shape = \"ball\"\n", "line 6, key shape", "taper_round"},
      {kBur + "shape = \"round\"\n", "head_diameter", "missing"},
      {kBur + "shape = \"round\"\nhead_diametr = 1.4\n", "line 7, key head_diametr", "Try: head_diameter"},
      {kBur + "shape = \"round\"\nhead_diameter = 0\n", "line 7, key head_diameter", "0.1 to 50"},
      {kBur + "shape = \"round\"\nhead_diameter = nan\n", "line 7, key head_diameter", "0.1 to 50"},
      {kBur + "shape = \"round\"\nhead_diameter = \"1.4\"\n", "line 7, key head_diameter", "another type"},
      {kBur + "shape = \"round\"\nhead_diameter = 1.4\nhead_length = 2\n", "line 8, key head_length", "unknown"},
      {kBur + "shape = \"round\"\nhead_diameter = 1.4\niso6360 = \"500314001001016\"\n", "line 8, key iso6360",
       "1.4 mm"},
      {kBur + "shape = \"round\"\nhead_diameter = 1.4\niso6360 = \"50031400100101\"\n", "line 8, key iso6360",
       "15 digits"},
      {kBur + "shape = \"round\"\nhead_diameter = 1.4\nneck_length = 2\n", "line 8, key neck_length", "alone"},
      {kBur + "shape = \"round\"\nhead_diameter = 1.4\nneck_length = 2\nneck_diameter = 1.5\n",
       "line 9, key neck_diameter", "at most"},
      {kBur + "shape = \"taper_round\"\nhead_diameter = 1.6\nhead_length = 8\ntip_diameter = 1.7\n",
       "line 9, key tip_diameter", "at most"},
      {kBur + "shape = \"cylinder_round\"\nhead_diameter = 1.6\nhead_length = 0.5\n", "line 8, key head_length",
       "at least"},
      {kBur + "shape = \"profile\"\nhead_diameter = 1\nprofile = [[0, 1]]\n", "line 8, key profile", "1 points"},
      {kBur + "shape = \"profile\"\nhead_diameter = 1\nprofile = [[0.5, 1], [1, 1]]\n", "line 8, key profile",
       "height 0"},
      {kBur + "shape = \"profile\"\nhead_diameter = 1\nprofile = [[0, 1], [2, 1], [1, 1]]\n", "line 8, key profile",
       "point 3"},
      {kBur + "shape = \"profile\"\nhead_diameter = 2\nprofile = [[0, 1], [2, 1]]\n", "line 7, key head_diameter",
       "widest"},
      {saw, "tooth_pitch", "missing"},
      {saw + "tooth_pitch = 1.41\nedge_depth = 6\n", "line 12, key edge_depth", "at most"},
      {saw + "tooth_pitch = 1.41\nset = 0.02\n", "line 12, key set", "unknown"},
  };
  for (const Case& c : cases) {
    const TemporaryFile file("a.toml", c.text);
    const auto tool = readTool(file.path());
    ASSERT_FALSE(tool) << c.text;
    EXPECT_EQ(tool.error().file, file.path().string());
    EXPECT_NE(tool.error().place.find(c.place), std::string::npos) << tool.error().message();
    EXPECT_NE(tool.error().message().find(c.what), std::string::npos) << tool.error().message();
  }
}

TEST(ToolFile, AnUnknownIdNamesTheToolsThereAre) {
  const auto found = findToolFile("round-041", {std::filesystem::path(KERF_SOURCE_DIR) / "assets/tools"});
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message().find("round-014"), std::string::npos);
}

TEST(Tool, PlungeVolumeMatchesClosedForms) {
  const Tool ball = bur("shape = \"round\"\nhead_diameter = 1.4\n");
  const double r = 0.7, half_ball = 2.0 / 3 * kPi * r * r * r;
  EXPECT_NEAR(plungeVolume(ball, 0.3), kPi * 0.09 * (r - 0.1), 1e-12);  // a cap
  EXPECT_NEAR(plungeVolume(ball, r), half_ball, 1e-12);
  EXPECT_NEAR(plungeVolume(ball, 2.5), half_ball + kPi * r * r * (2.5 - r), 1e-12);
  const Tool flat = bur("shape = \"taper_flat\"\nhead_diameter = 1.6\ntip_diameter = 1.0\nhead_length = 6\n");
  EXPECT_NEAR(plungeVolume(flat, 6), kPi * 6 / 3 * (0.25 + 0.4 + 0.64), 1e-12);
  const Tool round = bur("shape = \"cylinder_round\"\nhead_diameter = 1\nhead_length = 4\n");
  EXPECT_NEAR(plungeVolume(round, 5), 2.0 / 3 * kPi * 0.125 + kPi * 0.25 * 4.5, 1e-12);
  EXPECT_EQ(plungeVolume(ball, 0), 0);
}

TEST(Tool, PlungeVolumeMatchesTheDefinitionForEveryShape) {
  for (const std::string shape :
       {"shape = \"round\"\nhead_diameter = 1.4\n", "shape = \"cylinder\"\nhead_diameter = 1\nhead_length = 3\n",
        "shape = \"taper_round\"\nhead_diameter = 1.6\ntip_diameter = 1\nhead_length = 8\n",
        "shape = \"cone\"\nhead_diameter = 2\nhead_length = 3\n",
        "shape = \"profile\"\nhead_diameter = 1.4\nprofile = [[0, 0.4], [0.8, 1.2], [1.5, 0.6], [1.5, 0.9], [3, 1.4], "
        "[4, 0]]\n"}) {
    const Tool tool = bur(shape);
    for (const double depth : {0.2, 0.9, 1.7, 2.9, 5.0})
      EXPECT_NEAR(plungeVolume(tool, depth) / plungedNumerically(tool, depth), 1, 2e-5) << shape << depth;
  }
}

TEST(Tool, TaperRoundIsSmoothWhereSphereAndConeTouch) {
  const Tool tool = bur("shape = \"taper_round\"\nhead_diameter = 1.6\ntip_diameter = 1.0\nhead_length = 8\n");
  const auto& pieces = tool.head->pieces();
  ASSERT_EQ(pieces.size(), 3u);
  const Eigen::Vector2d cone = pieces[1].to - pieces[1].from, radius = pieces[1].from - pieces[0].center;
  EXPECT_NEAR(cone.dot(radius), 0, 1e-12);
  EXPECT_NEAR(radius.norm(), 0.5, 1e-12);
  EXPECT_NEAR(tool.cut->distance(Vec3d::Zero()), 0, 1e-12);
  EXPECT_NEAR(tool.cut->distance(Vec3d(0.8, 0, 8)), 0, 1e-12);
}

TEST(Tool, BladeCutsItsKerfOverTheWholeStroke) {
  const auto tool = readTool(std::filesystem::path(KERF_SOURCE_DIR) / "assets/tools/saw-reciprocating-25.toml");
  ASSERT_TRUE(tool) << tool.error().message();
  EXPECT_NEAR(tool->kerfWidth(), 0.44, 1e-12);
  EXPECT_NEAR(plungeVolume(*tool, 2), 0.44 * 28 * 2, 1e-12);
  EXPECT_NEAR(tool->cut->distance(Vec3d(0.25, 0.22, 26.4)), 0, 1e-12);
  EXPECT_NEAR(tool->body->distance(Vec3d(3, 0.2, 10)), 0, 1e-12);
}

TEST(Tool, MeshesForTheEyeAreClosedAndAsBigAsTheirFormulas) {
  for (const char* id : {"round-014", "856-016", "saw-reciprocating-25"}) {
    const auto tool = readTool(std::filesystem::path(KERF_SOURCE_DIR) / "assets/tools" / (std::string(id) + ".toml"));
    ASSERT_TRUE(tool);
    const Mesh mesh = toolMesh(*tool);
    expectClosedManifold(mesh);
    EXPECT_GT(signedVolume(mesh), 0);
    for (const Vec3d& p : mesh.vertices)
      EXPECT_LT(std::min(tool->cut->distance(p), tool->body->distance(p)), 1e-9) << id;
  }
  const Tool ball = bur("shape = \"round\"\nhead_diameter = 1.4\n");
  EXPECT_NEAR(signedVolume(toolMesh(ball, 0.001)) / (kPi / 6 * 1.4 * 1.4 * 1.4), 1, 0.01);
}

}  // namespace
}  // namespace kerf
