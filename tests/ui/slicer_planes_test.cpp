#include "ui/app/saw/slicer_planes.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/temporary_folder.h"

namespace kerf::slicer_planes_test {
namespace {

// As 3D Slicer 5.6 writes a plane: tilted about y, 40 x 30 mm. Its first axis is (0.8, 0, -0.6).
const std::string kFile = R"({
  "@schema": "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#",
  "markups": [
    {"type": "Plane", "coordinateSystem": "LPS", "coordinateUnits": "mm", "locked": false, "labelFormat": "%N-%d",
     "planeType": "pointNormal", "sizeMode": "auto", "autoScalingFactor": 1.0,
     "center": [3.0, -40.0, 12.0], "normal": [0.6, 0.0, 0.8],
     "objectToBase": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
     "baseToNode": [0.8, 0, 0.6, 3, 0, 1, 0, -40, -0.6, 0, 0.8, 12, 0, 0, 0, 1],
     "orientation": [0.8, 0.0, 0.6, 0.0, 1.0, 0.0, -0.6, 0.0, 0.8],
     "size": [40.0, 30.0, 0.0], "planeBounds": [-20, 20, -15, 15],
     "controlPoints": [{"id": "1", "label": "P-1", "position": [3.0, -40.0, 12.0], "positionStatus": "defined"}]}
  ]})";

class SlicerPlanesTest : public ::testing::Test {
 protected:
  TemporaryFolder folder_;

  Expected<SlicerPlanes> read(const std::string& text, const std::string& name = "midline.mrk.json") {
    return readSlicerPlanes(folder_.write(name, text));
  }
  // Of the file with one text replaced.
  Expected<SlicerPlanes> readWith(const std::string& from, const std::string& to) {
    std::string text = kFile;
    text.replace(text.find(from), from.size(), to);
    return read(text);
  }
};

TEST_F(SlicerPlanesTest, APlaneInLpsIsReadAsWritten) {
  const auto read = this->read(kFile);
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->planes.size(), 1u);
  const SawPlane& plane = read->planes[0];
  EXPECT_EQ(read->origin.frame, "LPS");
  EXPECT_FALSE(read->origin.isTurned());
  EXPECT_EQ(plane.name, "midline");
  EXPECT_LT((plane.normal - Vec3d(0.6, 0, 0.8)).norm(), 1e-12);
  EXPECT_LT((plane.fromPlane(0, 0.5 * plane.depth) - Vec3d(3, -40, 12)).norm(), 1e-12) << "the middle";
  EXPECT_LT((plane.approach - Vec3d(0.8, 0, -0.6)).norm(), 1e-12) << "the axis that points down";
  EXPECT_EQ(plane.depth, 40);
  EXPECT_EQ(plane.width, 30);
}

TEST_F(SlicerPlanesTest, APlaneInRasIsTurnedAboutZ) {
  const auto read = readWith("\"LPS\"", "\"RAS\"");
  ASSERT_TRUE(read) << read.error().message();
  const SawPlane& plane = read->planes[0];
  EXPECT_EQ(read->origin.frame, "RAS");
  EXPECT_TRUE(read->origin.isTurned());
  EXPECT_LT((plane.normal - Vec3d(-0.6, 0, 0.8)).norm(), 1e-12);
  EXPECT_LT((plane.fromPlane(0, 20) - Vec3d(-3, 40, 12)).norm(), 1e-12);
  EXPECT_LT((plane.approach - Vec3d(-0.8, 0, -0.6)).norm(), 1e-12);
}

TEST_F(SlicerPlanesTest, FramesUnitsAndDefaultsAreSaid) {
  EXPECT_EQ(readWith("\"coordinateSystem\": \"LPS\", ", "")->origin.frame, "LPS (not named)");
  EXPECT_NEAR(readWith("\"mm\"", "\"um\"")->planes[0].depth, SawPlan::kLeastSide, 1e-12) << "40 um";
  EXPECT_EQ(readWith("\"mm\"", R"(["mm", "UCUM", "millimeter"])")->planes[0].depth, 40);
  EXPECT_EQ(readWith("40.0, 30.0", "400.0, 30.0")->planes[0].depth, SawPlan::kMostSide);
}

TEST_F(SlicerPlanesTest, SeveralMarkupsAndOlderFiles) {
  // Older: three points in place of centre and normal. A point that was not placed does not count.
  const auto read = this->read(R"({"markups": [
    {"type": "Fiducial", "controlPoints": []},
    {"type": "Plane", "name": "left", "coordinateSystem": "RAS", "controlPoints": [{"position": [1, 0, 0]},
     {"position": [1, 5, 0]}, {"position": null}, {"position": [1, 0, 5]}]},
    {"type": "Plane", "name": "right", "coordinateSystem": "LPS", "center": [4, 0, 0], "normal": [0, 2, 0]},
    {"type": "Plane", "name": "right", "coordinateSystem": "LPS", "center": [5, 0, 0], "normal": [0, 2, 0]}]})");
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->planes.size(), 3u);
  EXPECT_EQ(read->origin.others, 1u);
  EXPECT_EQ(read->origin.frame, "LPS and RAS");
  EXPECT_LT((read->planes[0].normal - Vec3d(-1, 0, 0)).norm(), 1e-12);
  EXPECT_NEAR(read->planes[0].point[0], -1, 1e-12);
  EXPECT_EQ(read->planes[1].normal, Vec3d::UnitY());

  SawPlan plan;
  ASSERT_TRUE(plan.load(folder_.path() / "midline.mrk.json"));
  ASSERT_EQ(plan.planes().size(), 3u);
  EXPECT_EQ(plan.planes()[0].name, "left");
  EXPECT_EQ(plan.planes()[2].name, "plane 1") << "names are unique";
}

TEST_F(SlicerPlanesTest, ErrorsNameMarkupKeyAndWhatIsExpected) {
  const std::pair<std::pair<const char*, const char*>, std::vector<const char*>> cases[] = {
      {{"\"LPS\"", "\"IJK\""}, {"markups[0].coordinateSystem", "IJK", "LPS or RAS"}},
      {{"\"LPS\"", "3"}, {"markups[0].coordinateSystem", "number", "a text"}},
      {{"\"mm\"", "\"inch\""}, {"markups[0].coordinateUnits", "inch", "mm or um"}},
      {{"[3.0, -40.0, 12.0], \"normal\"", "[3.0, \"x\", 12.0], \"normal\""}, {"markups[0].center", "3 numbers"}},
      {{"\"center\": [3.0", "\"center\": [3e9"}, {"markups[0].center", "3000000000", "10 m"}},
      {{"[0.6, 0.0, 0.8]", "[0, 0, 0]"}, {"markups[0].normal", "length 0", "a direction"}},
      {{"[0.6, 0.0, 0.8]", "[0.8, 0.0, 0.6]"}, {"markups[0].orientation", "not the normal"}},
      {{"\"normal\"", "\"other\""}, {"markups[0]", "1 placed points", "three points"}},
      {{"\"type\": \"Plane\"", "\"type\": \"Line\""}, {"only markups of type Line", "Plane"}},
      {{"\"markups\"", "\"marks\""}, {"no list \"markups\""}},
      {{"{\"type\"", "\"type\""}, {"no valid JSON"}}};
  for (const auto& [change, words] : cases) {
    const auto read = readWith(change.first, change.second);
    ASSERT_FALSE(read) << change.second;
    const std::string message = read.error().message();
    EXPECT_NE(message.find("midline.mrk.json"), std::string::npos) << message;
    for (const char* const word : words) EXPECT_NE(message.find(word), std::string::npos) << message;
  }
  EXPECT_FALSE(readSlicerPlanes(folder_.path() / "missing.mrk.json"));
  EXPECT_FALSE(read(R"({"markups": [{"type": "Plane", "controlPoints": [{"position": [0, 0, 0]},
    {"position": [1, 0, 0]}, {"position": [2, 0, 0]}]}]})"));
}

TEST_F(SlicerPlanesTest, DamagedFilesAreReadOrRefused) {
  std::mt19937 random(42);
  std::size_t refused = 0;
  constexpr std::size_t kFiles = 800;
  for (std::size_t n = 0; n < kFiles; ++n) {
    std::string text = kFile;
    for (int change = 0; change < 3; ++change) {
      const std::size_t at = random() % text.size();
      if (random() % 4 == 0)
        text.erase(at, random() % 20);
      else
        text[at] = static_cast<char>(random() % 256);
    }
    const auto read = this->read(text);
    if (!read) {
      ++refused;
      EXPECT_FALSE(read.error().message().empty());
      continue;
    }
    for (const SawPlane& plane : read->planes) {
      EXPECT_NEAR(plane.normal.norm(), 1, 1e-9);
      EXPECT_NEAR(plane.normal.dot(plane.approach), 0, 1e-9);
      EXPECT_TRUE(plane.point.allFinite());
    }
  }
  EXPECT_GT(refused, kFiles / 10);
  EXPECT_LT(refused, kFiles);
}

}  // namespace
}  // namespace kerf::slicer_planes_test
