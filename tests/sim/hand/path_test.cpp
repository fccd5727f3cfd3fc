#include "sim/hand/path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/places.h"
#include "tests/support/temporary_file.h"

namespace kerf::path_test {
namespace {

const std::string kCsv = "t,x,y,z,qw,qx,qy,qz\n";
const std::string kStrokes =
    "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\n[start]\nposition = [1, 0, 5]\naxis = [0, 0, 1]\n";

Expected<CutPath> read(const std::string& name, const std::string& text) {
  return readPath(TemporaryFile(name, text).path());
}

TEST(Path, FilesThatComeWithKerfAreRead) {
  for (const char* name : {"demo-cavity.toml", "demo-poses.csv"}) {
    const auto path = readPath(std::filesystem::path(kSourceFolder) / "assets/paths" / name);
    ASSERT_TRUE(path) << path.error().message();
    ASSERT_EQ(path->cuts.size() + 1, path->poses.size());
    for (std::size_t n = 0; n + 1 < path->poses.size(); ++n) EXPECT_LT(path->poses[n].t, path->poses[n + 1].t);
  }
}

TEST(Path, BadFilesAreRefusedWithLineAndColumnOrKey) {
  struct Case {
    const char* name;
    std::string text;
    const char *place, *what;
  };
  const std::string row = "0,0,0,0,1,0,0,0\n";
  const Case cases[] = {
      {"a.csv", "", "line 1", "no header"},
      {"a.csv", "x,y,z\n", "line 1", "header"},
      {"a.csv", kCsv + row, "", "1 poses"},
      {"a.csv", kCsv + row + "1,2,3\n", "line 3", "3 columns"},
      {"a.csv", kCsv + row + "1,0,0,0,1,0,0,0,9\n", "line 3", "9 columns"},
      {"a.csv", kCsv + row + "1,0,abc,0,1,0,0,0\n", "line 3, column 3 (y)", "abc"},
      {"a.csv", kCsv + row + "1,0,0,nan,1,0,0,0\n", "line 3, column 4 (z)", "nan"},
      {"a.csv", kCsv + row + "1,inf,0,0,1,0,0,0\n", "line 3, column 2 (x)", "inf"},
      {"a.csv", kCsv + "# note\n" + row + "0,1,0,0,1,0,0,0\n", "line 4, column 1 (t)", "after 0"},
      {"a.csv", kCsv + row + "1,1,0,0,1,0.1,0,0\n", "line 3, column 5 (qw)", "length"},
      {"a.csv", kCsv + row + "1,1,0,0,0,1,0,0\n", "line 3, column 5 (qw)", "180 degrees"},
      {"a.csv", kCsv + row + "1,1e6,0,0,1,0,0,0\n", "line 3, column 2 (x)", "within 1000"},
      {"a.txt", kCsv, "", "extension"},
      {"a.toml", "format = \"kerf-path\n", "line 1", ""},
      {"a.toml", kStrokes, "stroke", "missing"},
      {"a.toml", "speed = 3\n" + kStrokes + "[[stroke]]\nkind = \"retract\"\nheight = 1\n", "line 1, key speed",
       "unknown"},
      {"a.toml", kStrokes + "[[stroke]]\nkind = \"dig\"\n", "line 8, key stroke[1].kind", "plunge, line"},
      {"a.toml", kStrokes + "[[stroke]]\nkind = \"plunge\"\n", "stroke[1].depth", "missing"},
      {"a.toml", kStrokes + "[[stroke]]\nkind = \"plunge\"\ndepht = 2\n", "line 9, key stroke[1].depht", "Try: depth"},
      {"a.toml", kStrokes + "[[stroke]]\nkind = \"plunge\"\ndepth = -2\n", "line 9, key stroke[1].depth", "-2"},
      {"a.toml", kStrokes + "[[stroke]]\nkind = \"line\"\nto = [1, 2]\n", "line 9, key stroke[1].to",
       "3 finite numbers"},
      {"a.toml", kStrokes + "[[stroke]]\nkind = \"line\"\nto = [1, 0, 5]\n", "line 9, key stroke[1].to",
       "without length"},
      {"a.toml", kStrokes + "[[stroke]]\nkind = \"line\"\n", "stroke[1].to", "neither"},
      {"a.toml", kStrokes + "[[stroke]]\nkind = \"arc\"\ncenter = [0, 0, 5]\naxis = [0, 0, 0]\nangle_deg = 9\n",
       "line 10, key stroke[1].axis", "without length"},
      {"a.toml", kStrokes + "[[stroke]]\nkind = \"arc\"\ncenter = [1, 0, 5]\naxis = [0, 0, 1]\nangle_deg = 9\n",
       "line 9, key stroke[1].center", "on the axis"},
  };
  for (const Case& c : cases) {
    const auto path = read(c.name, c.text);
    ASSERT_FALSE(path) << c.text;
    EXPECT_NE(path.error().place.find(c.place), std::string::npos) << path.error().message();
    EXPECT_NE(path.error().message().find(c.what), std::string::npos) << path.error().message();
  }
}

TEST(Path, ArcKeepsTheToolUprightAndTheTipWithinAMicrometreOfTheCircle) {
  const auto path =
      read("a.toml",
           kStrokes + "[[stroke]]\nkind = \"arc\"\ncenter = [0, 0, 5]\naxis = [0, 0, 1]\nangle_deg = 90\nfeed = 0.5\n");
  ASSERT_TRUE(path) << path.error().message();
  for (std::size_t n = 0; n + 1 < path->poses.size(); ++n) {
    const Vec3d middle =
        0.5 * (path->poses[n].T_object_tool.translation + path->poses[n + 1].T_object_tool.translation);
    EXPECT_NEAR((middle - Vec3d(0, 0, 5)).norm(), 1, 1.0001e-3);
    EXPECT_LT(path->poses[n].T_object_tool.rotation.angularDistance(Eigen::Quaterniond::Identity()), 1e-12);
  }
  EXPECT_LT((path->poses.back().T_object_tool.translation - Vec3d(0, 1, 5)).norm(), 1e-12);
  EXPECT_NEAR(path->poses.back().t, std::numbers::pi, 1e-9);  // a quarter of 2 pi mm at 0.5 mm/s
}

TEST(Path, SweepTurnsTheToolAboutThePivotInStepsOfTwoDegreesAtMost) {
  const auto path =
      read("a.toml", kStrokes + "[[stroke]]\nkind = \"sweep\"\npivot = [0, 0, 5]\naxis = [0, 1, 0]\nangle_deg = 90\n");
  ASSERT_TRUE(path) << path.error().message();
  for (std::size_t n = 0; n + 1 < path->poses.size(); ++n)
    EXPECT_LE(path->poses[n].T_object_tool.rotation.angularDistance(path->poses[n + 1].T_object_tool.rotation),
              2.0001 * std::numbers::pi / 180);
  const Rigid3& end = path->poses.back().T_object_tool;
  EXPECT_LT((end.translation - Vec3d(0, 0, 4)).norm(), 1e-12);
  EXPECT_LT((end.rotation * Vec3d::UnitZ() - Vec3d::UnitX()).norm(), 1e-12);
}

TEST(Path, ToolFrameStrokesFollowTheToolAndAirMovesDoNotCut) {
  const std::string head =
      "format = \"kerf-path\"\nversion = 1\nframe = \"tool\"\n[start]\nposition = [0, 0, 5]\naxis = [0, 1, 0]\nedge = "
      "[0, 0, 1]\n";
  const auto path =
      read("a.toml", head +
                         "[[stroke]]\nkind = \"line\"\nby = [-2, 0, 0]\n[[stroke]]\nkind = \"plunge\"\ndepth = 3\n"
                         "[[stroke]]\nkind = \"retract\"\nheight = 1\n[[stroke]]\nkind = \"move\"\nto = [0, 0, 1]\n");
  ASSERT_TRUE(path) << path.error().message();
  ASSERT_EQ(path->poses.size(), 5u);
  EXPECT_LT((path->poses[1].T_object_tool.translation - Vec3d(0, 0, 3)).norm(), 1e-12);
  EXPECT_LT((path->poses[2].T_object_tool.translation - Vec3d(0, -3, 3)).norm(), 1e-12);
  EXPECT_LT((path->poses[4].T_object_tool.translation - Vec3d(0, -1, 3)).norm(), 1e-12);
  EXPECT_EQ(path->cuts, (std::vector<char>{1, 1, 0, 0}));
  EXPECT_NEAR(path->poses[1].t, 1, 1e-12);  // 2 mm at the default 2 mm/s
}

}  // namespace
}  // namespace kerf::path_test
