#include "geometry/tool/tool_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/tool/head_shape.h"
#include "tests/geometry/sampled_field.h"
#include "tests/support/places.h"
#include "tests/support/temporary_file.h"
#include "tests/support/temporary_folder.h"

namespace kerf::tool_file_test {
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

// The definition, by brute force: at every level, the maximum radius that has passed.
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
  const auto tools = listTools({std::filesystem::path(kSourceFolder) / "assets/tools"});
  ASSERT_GE(tools.size(), 90u);
  for (const ToolListing& t : tools) EXPECT_TRUE(t.tool) << t.error->message();
}

TEST(ToolFile, AnIdInAnEarlierFolderHidesTheSameIdInLaterOnes) {
  const TemporaryFolder mine;
  const std::filesystem::path rack = std::filesystem::path(kSourceFolder) / "assets/tools";
  std::filesystem::copy_file(rack / "us-330.toml", mine.path() / "us-330.toml");
  const std::size_t all = listTools({rack}).size();
  const auto tools = listTools({mine.path(), rack});
  EXPECT_EQ(tools.size(), all);
  for (const ToolListing& t : tools)
    EXPECT_EQ(t.file.parent_path(), t.file.stem() == "us-330" ? mine.path() : rack) << t.file;

  const auto none = findToolFile("no-such-tool", {mine.path(), rack});
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message().find("one of " + std::to_string(all) + " ids"), std::string::npos)
      << none.error().message();
}

TEST(ToolFile, EveryToolThatComesWithKerfSaysWhatItIsAndWhereItsNumbersComeFrom) {
  for (const ToolListing& t : listTools({std::filesystem::path(kSourceFolder) / "assets/tools"})) {
    ASSERT_TRUE(t.tool) << t.error->message();
    EXPECT_FALSE(t.tool->description.empty()) << t.tool->id;
    EXPECT_EQ(contentOf(t.file).substr(0, 2), "# ") << t.tool->id;
    if (t.tool->iso) {
      EXPECT_NE(t.tool->iso->materialName(), "") << t.tool->id;
      EXPECT_NE(t.tool->iso->shapeName(), "") << t.tool->id;
      EXPECT_TRUE(t.tool->iso->shankKnown()) << t.tool->id;
    }
  }
}

TEST(ToolFile, NoCuttingPartOfTheRackHidesInItsNeckOrShank) {
  for (const ToolListing& t : listTools({std::filesystem::path(kSourceFolder) / "assets/tools"})) {
    ASSERT_TRUE(t.tool) << t.error->message();
    if (!t.tool->cutting) continue;
    for (const Eigen::Vector2d& p : t.tool->cutting->polyline(0.01)) {
      if (p[1] > 0.5 * t.tool->head_length_mm || p[0] == 0) continue;  // a neck may begin in the upper half
      EXPECT_GT(t.tool->body->distance(Vec3d(p[0], 0, p[1])), -1e-9) << t.tool->id << " at " << p.transpose();
    }
  }
}

TEST(ToolFile, AShankWiderThanTheHeadBeginsAboveIt) {
  const Tool drill =
      bur("shape = \"drill\"\nhead_diameter = 2\nhead_length = 10\npoint_angle = 120\nshank_diameter = 2.35\n"
          "shank_length = 5\n");
  EXPECT_NEAR(drill.body->bounds().min[2], 10, 1e-12);
  EXPECT_NEAR(drill.body->bounds().max[2], 15, 1e-12);
}

TEST(ToolFile, EveryShapeIsWrittenFromItsExamplesAndExplainedInTheReadme) {
  const std::string readme = contentOf(std::filesystem::path(kSourceFolder) / "assets/tools/README.md");
  for (const HeadShape& shape : headShapes()) {
    EXPECT_NE(readme.find(fmt::format("| `{}` |", shape.name)), readme.npos) << shape.name;
    if (shape.takes_profile) continue;
    for (const bool with_optional : {false, true}) {
      std::string keys = fmt::format("shape = \"{}\"\nhead_diameter = 1.6\n", shape.name);
      for (const HeadShape::Key& key : shape.keys) {
        const bool is_angle = std::string(key.name) == "point_angle";
        if (!key.unsaid || with_optional)
          keys += fmt::format("{} = {}\n", key.name, key.example * (is_angle ? 1 : 1.6));
      }
      const Tool tool = bur(keys);
      ASSERT_TRUE(tool.head) << keys;
      EXPECT_NEAR(tool.head->largestRadius(), 0.8, 1e-9) << shape.name;
      EXPECT_TRUE(tool.cut->isConvex()) << shape.name;  // the slopes bracket the sweep of a convex shape
      for (const double depth : {0.2, 0.9, 1.7, 2.9, 9.0})
        EXPECT_NEAR(plungeVolume(tool, depth) / plungedNumerically(tool, depth), 1, 2e-5) << shape.name << depth;
    }
  }
  for (const HeadKey& key : headKeys()) EXPECT_NE(readme.find(fmt::format("`{}`", key.name)), readme.npos) << key.name;
}

TEST(ToolFile, ArcsOfAFreeProfileAreArcs) {
  // A cylinder of radius 1 whose lower edge is rounded by 0.5, then a groove: a half circle of radius 0.25.
  const Tool tool =
      bur("shape = \"profile\"\nhead_diameter = 2\n"
          "profile = [[0, 1], [0.5, 2, 0.5], [1, 2], [1.5, 2, -0.25], [2, 2]]\n");
  ASSERT_TRUE(tool.head);
  EXPECT_NEAR(tool.cut->distance(Vec3d(0.5 + 0.5 * std::sqrt(0.5), 0, 0.5 - 0.5 * std::sqrt(0.5))), 0, 1e-12);
  EXPECT_NEAR(tool.cut->distance(Vec3d(0, 0.75, 1.25)), 0, 1e-12);
  EXPECT_NEAR(tool.cut->distance(Vec3d(1, 0, 1.25)), 0.25, 1e-12);     // in the groove, on its centre
  EXPECT_NEAR(tool.cut->distance(Vec3d(0.7, 0, 1.25)), -0.05, 1e-12);  // behind it
  EXPECT_FALSE(tool.cut->isConvex());
  for (const double depth : {0.2, 0.9, 1.3, 1.7, 3.0})
    EXPECT_NEAR(plungeVolume(tool, depth) / plungedNumerically(tool, depth), 1, 2e-5) << depth;
  expectClosedManifold(toolMesh(tool));
}

TEST(ToolFile, WhatDoesNotCutOnlyCollides) {
  const std::string keys = "shape = \"cylinder\"\nhead_diameter = 1\nhead_length = 4\nend_length = 0.4\n";
  const Tool end = bur(keys + "cuts = [\"end\"]\n"), side = bur(keys + "cuts = [\"side\"]\n");
  EXPECT_LT(end.cut->distance(Vec3d(0.4, 0, 0.2)), 0);
  EXPECT_NEAR(end.cut->distance(Vec3d(0, 0.5, 1.4)), 1, 1e-12);
  EXPECT_LT(end.body->distance(Vec3d(0.4, 0, 3)), 0);
  EXPECT_NEAR(plungeVolume(end, 2), kPi * 0.25 * 2, 1e-12);
  EXPECT_LT(side.cut->distance(Vec3d(0.4, 0, 3)), 0);
  EXPECT_GT(side.cut->distance(Vec3d(0, 0, 0.2)), 0);
  EXPECT_LT(side.body->distance(Vec3d(0, 0, 0.2)), 0);
  EXPECT_EQ(side.plunge_direction, Vec3d(-1, 0, 0));  // the tip blocks it
  EXPECT_NEAR(plungeVolume(side, 0.5), 3.6 * kPi * 0.25 / 2, 1e-9);
  EXPECT_NEAR(plungeVolume(side, 1.5), 3.6 * (kPi * 0.25 / 2 + 1), 1e-9);
  // A drill's end is its point and the land behind it, unless the file specifies another.
  const Tool drill =
      bur("shape = \"drill\"\nhead_diameter = 2\nhead_length = 10\npoint_angle = 90\ncuts = [\"end\"]\n");
  EXPECT_NEAR(drill.cutting->highest(), 1.5, 1e-12);
}

TEST(ToolFile, SidewaysPlungeOfABallIsItsDefinition) {
  const Tool ball = bur("shape = \"round\"\nhead_diameter = 2\n");
  Tool side = ball;
  side.cuts_end = false;
  for (const double depth : {0.1, 0.7, 1.0}) EXPECT_NEAR(plungeVolume(side, depth), plungeVolume(ball, depth), 1e-9);
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
  const std::string round = kBur + "shape = \"round\"\nhead_diameter = 1.4\n";
  const Case cases[] = {
      {"format = 3 4", "line 1", ""},
      {"", "key format", "missing"},
      {"format = \"kerf-case\"\n", "line 1, key format", "kerf-tool"},
      {"format = \"kerf-tool\"\nversion = 2\nid = \"a\"\nname = \"A\"\nkind = \"bur\"\n", "line 2, key version",
       "expected 1"},
      {"format = \"kerf-tool\"\nversion = 1\nid = \"b\"\nname = \"A\"\nkind = \"bur\"\nshape = "
       "\"round\"\nhead_diameter = 1\n",
       "line 3, key id", "\"a\""},
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
      {kBur + "shape = \"taper_ruond\"\n", "line 6, key shape", "Try: taper_round"},
      {kBur + "shape = \"round\"\nhead_diameter = \"1.6 mm\"\n", "line 7, key head_diameter",
       "Try: head_diameter = 1.6, without quotes"},
      {kBur + "shape = \"round\"\nhead_diameter = 1,6\n", "line 7, column", "Try: a decimal point: 1.6"},
      {kBur + "shape = \"round\"\nhead_diameter = 0.016\n", "line 7, key head_diameter", "mm, not cm or m"},
      {kBur + "shape = \"torpedo\"\nhead_diameter = 1.6\nhead_length = 8\n", "key point_length",
       "height of the pointed end"},
      {kBur + "shape = \"taper_round\"\nhead_diameter = 0.16\nhead_length = 8\ntip_diameter = 1\n"
              "iso6360 = \"806314198524016\"\n",
       "line 10, key iso6360", "016 means 1.6 mm"},
      {kBur + "shape = \"egg\"\n", "line 6, key shape", "Try: football"},
      {kBur + "shape = \"round\"\nradius = 0.7\n", "line 7, key radius", "twice the radius"},
      {kBur + "shape = \"round\"\nhead_diameter = 1.4\nunits = \"mm\"\n", "line 8, key units", "leave it out"},
      {kBur + "shape = \"round\"\nhead_diameter = 0.16\niso6360 = \"500314001001016\"\n", "line 8, key iso6360",
       "016 means 1.6 mm, not 0.16"},
      {kBur + "shape = \"round\"\nhead_diameter = 0.8\niso6360 = \"500314001001016\"\n", "line 8, key iso6360",
       "looks like a radius"},
      {kBur + "shape = \"round\"\nhead_diameter = 16\niso6360 = \"500314001001016\"\n", "line 8, key iso6360",
       "head_diameter = 1.6"},
      {kBur + "shape = \"round\"\nhead_diameter = 1.6\niso6360 = \"500 314 001001 016\"\n", "line 8, key iso6360",
       "\"500314001001016\", digits only"},
      {kBur + "shape = \"round\"\nhead_diameter = 1.6\nshank_diameter = 2.35\nshank_length = 17.4\n"
              "iso6360 = \"500314001001016\"\n",
       "line 10, key iso6360", "2.35 mm RA"},
      {kBur + "shape = \"round\"\nhead_diameter = 1.6\nshank_diameter = 1.6\nshank_length = 14.4\n"
              "iso6360 = \"500314001001016\"\n",
       "line 10, key iso6360", "3 mm longer"},
      {kBur + "shape = \"profile\"\nhead_diameter = 1\nprofile = [[0, 0.5], [2, 1]]\nhead_length = 2\n",
       "line 9, key head_length", "unknown"},
      {kBur + "shape = \"profile\"\nhead_diameter = 0.5\nprofile = [[0, 0.5], [2, 1]]\n", "line 7, key head_diameter",
       "never radii"},
      {kBur + "shape = \"profile\"\nhead_diameter = 1\nprofile = [[0, 0], [2, 1, 0.5]]\n", "line 8, key profile",
       "point 2: an arc radius of at least 1.031 mm"},
      {kBur + "shape = \"profile\"\nhead_diameter = 1\nprofile = [[0, 1], [1, 1, 4, 4]]\n", "line 8, key profile",
       "arc radius"},
      {kBur + "shape = \"cylinder\"\nhead_diameter = 1\nhead_length = 4\ncuts = [\"end\"]\n", "end_length", "missing"},
      {kBur + "shape = \"cylinder\"\nhead_diameter = 1\nhead_length = 4\ncuts = [\"tip\"]\n", "line 9, key cuts",
       "[\"end\"]"},
      {kBur + "shape = \"cylinder\"\nhead_diameter = 1\nhead_length = 4\ncuts = []\n", "line 9, key cuts",
       "nothing that cuts"},
      {kBur + "shape = \"cylinder\"\nhead_diameter = 1\nhead_length = 4\nend_length = 1\n", "line 9, key end_length",
       "beside it"},
      {kBur + "shape = \"cylinder\"\nhead_diameter = 1\nhead_length = 4\ncuts = [\"end\"]\nend_length = 4\n",
       "line 10, key end_length", "less than"},
      {kBur + "shape = \"flame\"\nhead_diameter = 4\nhead_length = 2\n", "line 8, key head_length", "longer head"},
      {kBur + "shape = \"torpedo\"\nhead_diameter = 2\nhead_length = 6\npoint_length = 0.5\n",
       "line 9, key point_length", "cylinder_round"},
      {kBur + "shape = \"taper_flat\"\nhead_diameter = 1\nhead_length = 6\ntip_diameter = 1.2\n",
       "line 9, key tip_diameter", "inverted_cone"},
      {saw, "tooth_pitch", "missing"},
      {kHead + "kind = \"blade\"\nmotion = \"oscillating\"\nthickness = 0.4\n", "line 6, key motion", "Try: sagittal"},
      {kHead + "kind = \"blade\"\nmotion = \"piezo\"\nthickness = 0.4\nwidth = 4\nlength = 8\nstroke = 100\n"
               "tooth_pitch = 1\n",
       "line 10, key stroke", "0.02 to 0.3 mm"},
      {kHead + "kind = \"blade\"\nmotion = \"sagittal\"\nthickness = 0.4\nwidth = 30\nlength = 10\nswing = 4\n"
               "tooth_pitch = 1\n",
       "line 8, key width", "sweeps"},
      {saw + "tooth_pitch = 1.41\nedge_depth = 6\n", "line 12, key edge_depth", "at most"},
      {saw + "tooth_pitch = 1.41\nset = 0.02\n", "line 12, key set", "unknown"},
      {round + "drive = 200000\n", "line 8, key drive", "[drive] on a line of its own"},
      {round + "[drive]\nrpm = 200000\n", "line 9, key drive.rpm", "Try: speed_rpm, in rpm"},
      {round + "[drive]\nspeed_krpm = 200\n", "line 9, key drive.speed_krpm", "Try: speed_rpm, in rpm"},
      {round + "[drive]\nspeed_rpm = \"fast\"\n", "line 9, key drive.speed_rpm", "1 to 1000000 rpm"},
      {round + "[drive]\nspeed_rpm = 0\n", "line 9, key drive.speed_rpm", "1 to 1000000 rpm"},
      {round + "[drive]\nspeed_rpm = nan\n", "line 9, key drive.speed_rpm", "1 to 1000000 rpm"},
      {round + "[drive]\ncycles_per_min = 9800\n", "line 9, key drive.cycles_per_min", "Try: speed_rpm"},
      {round + "[drive]\nfrequency_hz = 100\n", "line 9, key drive.frequency_hz", "60 times the frequency in Hz"},
      {round + "[drive]\nstall_torque_Ncm = 1\n", "line 9, key drive.stall_torque_Ncm", "10 times as many"},
      {round + "[drive]\nstall_force_N = 1\n", "line 9, key drive.stall_force_N", "Try: stall_torque_Nmm, in N mm"},
      {round + "[drive]\nstall_torque_Nmm = 1e6\n", "line 9, key drive.stall_torque_Nmm", "100000 N mm"},
      {round + "[drive]\ntime_constant_ms = 50\n", "line 9, key drive.time_constant_ms", "in seconds"},
      {round + "[drive]\ntime_constant_s = 0\n", "line 9, key drive.time_constant_s", "0.001 to 10 s"},
      {round + "[drive]\nenergy_factor = 0\n", "line 9, key drive.energy_factor", "0.01 to 100"},
      {round + "[drive]\ndrag_factor = -1\n", "line 9, key drive.drag_factor", "0.01 to 100"},
      {round + "[drive]\nhandpiece = \"turbin\"\n", "line 9, key drive.handpiece", "turbine, turbine-brake, electric"},
      {round + "[drive]\nhandpiece = 3\n", "line 9, key drive.handpiece", "one of turbine"},
      {saw + "tooth_pitch = 1.41\n[drive]\nhandpiece = \"turbine\"\n", "line 13, key drive.handpiece",
       "a saw's motion says"},
      {round + "[drive]\nhead_diameter = 2\n", "line 9, key drive.head_diameter", "unknown"},
      {saw + "tooth_pitch = 1.41\n[drive]\nspeed_rpm = 9800\n", "line 13, key drive.speed_rpm", "Try: cycles_per_min"},
      {saw + "tooth_pitch = 1.41\n[drive]\nstroke_mm = 3\n", "line 13, key drive.stroke_mm", "above [drive]"},
      {saw + "tooth_pitch = 1.41\n[drive]\ncycles_per_min = 5\n", "line 13, key drive.cycles_per_min",
       "10 to 100000 cycles/min"},
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
  const auto found = findToolFile("round-041", {std::filesystem::path(kSourceFolder) / "assets/tools"});
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message().find("Try: round-014"), std::string::npos) << found.error().message();
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

TEST(Iso6360, SaysWhatItsPartsMean) {
  const auto code = parseIso6360("806314198524016");
  ASSERT_TRUE(code);
  EXPECT_EQ(code->meaning(),
            "diamond; FG shank 1.6 mm, 19 mm long in all; taper, round; medium grit, 107 um; head 1.6 mm");
  const auto unknown = parseIso6360("999998997996995");
  ASSERT_TRUE(unknown);
  EXPECT_EQ(unknown->meaning(), "material 999; shank 998; shape 997; execution 996; head 99.5 mm");
  for (const char* wrong : {"", "80631419852401", "8063141985240160", "80631419852401x", "806 314 198524 016"})
    EXPECT_FALSE(parseIso6360(wrong)) << wrong;
}

TEST(Tool, SagittalBladeSweepsASectorOfItsKerf) {
  const TemporaryFile file("a.toml", kHead +
                                         "kind = \"blade\"\nmotion = \"sagittal\"\nthickness = 0.4\nset_per_side = "
                                         "0.05\nwidth = 10\nlength = 25\nswing = 4\ntooth_pitch = 1\n");
  const auto tool = readTool(file.path());
  ASSERT_TRUE(tool) << tool.error().message();
  const double half = 5 + 25 * std::sin(2 * kPi / 180);
  EXPECT_NEAR(tool->sweptWidth(), 2 * half, 1e-12);
  EXPECT_NEAR(tool->cut->bounds().max[0], half, 1e-12);
  EXPECT_TRUE(tool->cut->isConvex());
  double area = 0;  // columns of the part below z = 0 with the tip 2 mm deep
  const int n = 100000;
  for (int i = 0; i < n; ++i) {
    const double x = half * (2 * (i + 0.5) / n - 1);
    area += std::max(0.0, 2 - 25 + std::sqrt(625 - x * x)) * 2 * half / n;
  }
  EXPECT_NEAR(plungeVolume(*tool, 2) / (0.5 * area), 1, 1e-6);
  EXPECT_NEAR(tool->cut->distance(Vec3d(3, 0, 25 - std::sqrt(625 - 9))), 0, 1e-12);
  EXPECT_NEAR(tool->cut->distance(Vec3d(0, 0.35, 0.3)), 0.1, 1e-12);
  expectClosedManifold(toolMesh(*tool));
}

TEST(Tool, BladeCutsItsKerfOverTheWholeStroke) {
  const auto tool = readTool(std::filesystem::path(kSourceFolder) / "assets/tools/saw-reciprocating-25.toml");
  ASSERT_TRUE(tool) << tool.error().message();
  EXPECT_NEAR(tool->kerfWidth(), 0.44, 1e-12);
  EXPECT_NEAR(plungeVolume(*tool, 2), 0.44 * 28 * 2, 1e-12);
  EXPECT_NEAR(tool->cut->distance(Vec3d(0.25, 0.22, 26.4)), 0, 1e-12);
  EXPECT_NEAR(tool->body->distance(Vec3d(3, 0.2, 10)), 0, 1e-12);
}

TEST(Tool, MeshesForTheEyeAreClosedAndAsBigAsTheirFormulas) {
  for (const ToolListing& t : listTools({std::filesystem::path(kSourceFolder) / "assets/tools"})) {
    ASSERT_TRUE(t.tool);
    const Mesh mesh = toolMesh(*t.tool);
    expectClosedManifold(mesh);
    EXPECT_GT(signedVolume(mesh), 0);
    for (const Vec3d& p : mesh.vertices)
      EXPECT_LT(std::min(t.tool->cut->distance(p), t.tool->body->distance(p)), 1e-9) << t.tool->id;
  }
  const Tool ball = bur("shape = \"round\"\nhead_diameter = 1.4\n");
  EXPECT_NEAR(signedVolume(toolMesh(ball, 0.001)) / (kPi / 6 * 1.4 * 1.4 * 1.4), 1, 0.01);
}

}  // namespace
}  // namespace kerf::tool_file_test
