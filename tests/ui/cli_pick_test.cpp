// kerf pick: coordinates of a place, against shapes with known coordinates.
#include <nlohmann/json.hpp>

#include "tests/ui/cli_runner.h"

namespace kerf::cli_pick_test {
namespace {

using nlohmann::json;

class CliPick : public Cli {
 protected:
  json pick(std::vector<std::string> words) {
    words.insert(words.begin(), "pick");
    words.push_back("--json");
    const Outcome o = runKerf(words);
    EXPECT_EQ(o.exit_code, 0) << o.err;
    const json j = json::parse(o.out, nullptr, false);
    EXPECT_FALSE(j.is_discarded()) << o.out;
    return j;
  }
  static void expectNear(const json& point, const std::array<double, 3>& expected, double tolerance = 1e-6) {
    ASSERT_EQ(point.size(), 3u) << point;
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(point[k].get<double>(), expected[k], tolerance) << point;
  }
  // 2 x 4 x 6 mm, its corner at (10, 20, 30).
  void writeBlock() {
    folder_.write("block.off",
                  "OFF\n8 12 0\n10 20 30\n12 20 30\n10 24 30\n12 24 30\n10 20 36\n12 20 36\n10 24 36\n12 24 36\n"
                  "3 0 2 1\n3 1 2 3\n3 4 5 6\n3 5 7 6\n3 0 1 4\n3 1 5 4\n3 2 6 3\n3 3 6 7\n3 0 4 2\n3 2 4 6\n3 1 3 5\n"
                  "3 3 7 5\n");
  }
};

TEST_F(CliPick, PointNormalAndThicknessFromEachSide) {
  writeBlock();
  struct Row {
    std::string view, at;
    std::array<double, 3> point, normal;
    double thickness;
  };
  // Right and up in the view, from the origin: x, y from the top; x, z from the front; y, z from the right.
  for (const Row& row : {Row{"top", "10.5,21", {10.5, 21, 36}, {0, 0, 1}, 6},
                         {"bottom", "10.5,-21", {10.5, 21, 30}, {0, 0, -1}, 6},
                         {"front", "11,33", {11, 20, 33}, {0, -1, 0}, 4},
                         {"back", "-11,33", {11, 24, 33}, {0, 1, 0}, 4},
                         {"right", "22,33", {12, 22, 33}, {1, 0, 0}, 2},
                         {"left", "-22,33", {10, 22, 33}, {-1, 0, 0}, 2}}) {
    const json found = pick({at("block.off"), "--unit", "mm", "--view", row.view, "--at", row.at})["points"][0];
    expectNear(found["point_mm"], row.point);
    expectNear(found["normal"], row.normal);
    EXPECT_NEAR(found["thickness_mm"].get<double>(), row.thickness, 1e-6) << row.view;
    EXPECT_FALSE(found["is_seen_from_behind"].get<bool>());
  }
}

TEST_F(CliPick, PixelsAreThoseOfThePictureAndPlacesMayBeMany) {
  writeBlock();
  const json j = pick({at("block.off"), "--unit", "mm", "--pixel", "600,450", "--at", "11,22", "--at", "11.5,23",
                       "--size", "1200x900"});
  ASSERT_EQ(j["points"].size(), 3u);
  // The middle of the picture is the middle of the block; --at takes precedence.
  expectNear(j["points"][2]["point_mm"], {11, 22, 36});
  expectNear(j["points"][1]["point_mm"], {11.5, 23, 36});
  EXPECT_EQ(j["points"][0]["path_row"],
            "0,11.000000,22.000000,36.000000,1.000000000,0.000000000,0.000000000,0.000000000");

  const Outcome text = runKerf({"pick", at("block.off"), "--unit", "mm", "--at", "11,22"});
  EXPECT_EQ(text.out, "11.000, 22.000, 36.000 mm; normal 0.000, 0.000, 1.000; 6.00 mm thick along the view\n");
}

TEST_F(CliPick, InchesAreToldInMillimetresAndSaid) {
  writeBlock();
  const json j = pick({at("block.off"), "--unit", "inch", "--at", "279.4,558.8"});
  expectNear(j["points"][0]["point_mm"], {279.4, 558.8, 914.4}, 1e-4);
  EXPECT_NE(j["note"].get<std::string>().find("inch"), std::string::npos) << j;
}

TEST_F(CliPick, OfARunIsWhatIsLeft) {
  makeRun();
  // The groove runs along y = 0.3, half a millimetre deep.
  const json j = pick({at("box.run"), "--at", "0,0.3", "--at", "-1,0.3", "--at", "2.5,2"});
  expectNear(j["points"][0]["point_mm"], {0, 0.3, -0.5}, 0.02);
  expectNear(j["points"][1]["point_mm"], {-1, 0.3, -0.5}, 0.02);
  expectNear(j["points"][2]["point_mm"], {2.5, 2, 0});
  EXPECT_NEAR(j["points"][0]["thickness_mm"].get<double>(), 3.5, 0.02);
}

// A scan stored with its teeth towards -y and open towards +y is viewed from its teeth.
TEST_F(CliPick, AnOpenScanStandsUpright) {
  folder_.write("open.off",
                "OFF\n8 10 0\n10 20 30\n12 20 30\n10 24 30\n12 24 30\n10 20 36\n12 20 36\n10 24 36\n12 24 36\n"
                "3 0 2 1\n3 1 2 3\n3 4 5 6\n3 5 7 6\n3 0 1 4\n3 1 5 4\n3 0 4 2\n3 2 4 6\n3 1 3 5\n3 3 7 5\n");
  const json top = pick({at("open.off"), "--unit", "mm", "--at", "11,33"});
  EXPECT_EQ(top["up"], "-y");
  expectNear(top["points"][0]["point_mm"], {11, 20, 33});
  EXPECT_FALSE(top["points"][0]["is_seen_from_behind"].get<bool>());
  EXPECT_TRUE(top["points"][0]["thickness_mm"].is_null()) << "it is open";
  const Outcome text = runKerf({"pick", at("open.off"), "--unit", "mm", "--at", "11,33"});
  EXPECT_NE(text.out.find("seen with -y up"), std::string::npos) << text.out;
  const json bottom = pick({at("open.off"), "--unit", "mm", "--view", "bottom", "--at", "11,-33"});
  EXPECT_TRUE(bottom["points"][0]["is_seen_from_behind"].get<bool>());

  const json stored = pick({at("open.off"), "--unit", "mm", "--at", "11,22", "--up", "+z"});
  expectNear(stored["points"][0]["point_mm"], {11, 22, 36});
}

TEST_F(CliPick, WhatIsBesideOrNoPlaceIsRefused) {
  writeBlock();
  const std::string block = at("block.off");
  refuses({"pick", block, "--unit", "mm", "--at", "11,22", "--at", "0,0"}, {"nothing", "10.00 to 12.00 mm"});
  refuses({"pick", block}, {"--at X,Y"}, 2);
  for (const char* wrong : {"1", "a,b", "1,nan", "1,2,3", "1,1e999"})
    refuses({"pick", block, "--at", wrong}, {"--at"}, 2);
  refuses({"pick", block, "--pixel", "1,1", "--size", "0x0"}, {"--size"}, 2);
  refuses({"pick", block, "--at", "1,1", "--view", "sky"}, {"--view"}, 2);
  refuses({"pick", block, "--at", "1,1", "--up", "sideways"}, {"--up", "+x"}, 2);
  refuses({"pick", at("none.stl"), "--at", "1,1"}, {"none.stl"});
}

}  // namespace
}  // namespace kerf::cli_pick_test
