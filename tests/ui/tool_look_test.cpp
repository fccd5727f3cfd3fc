// Tool data for pictures: rows of the rack, the table for tint and shadow; limits of readings.
#include "ui/app/tool/tool_look.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/tool/tool_file.h"
#include "ui/app/import/import_guides.h"
#include "ui/app/tool/tool_icon.h"
#include "ui/app/view/heat_readings.h"

namespace kerf::tool_look_test {
namespace {

Tool toolOf(const std::string& id) {
  const auto file = findToolFile(id, defaultToolFolders());
  EXPECT_TRUE(file);
  auto tool = readTool(*file);
  EXPECT_TRUE(tool);
  return *tool;
}

TEST(ToolTable, HoldsTheDistancesOfTheToolInItsApproachFrame) {
  for (const char* const id : {"round-014", "856-016", "disc-22", "saw-reciprocating-25"}) {
    const Tool tool = toolOf(id);
    const ToolLook look = lookOf(tool);
    const ToolTable table = toolTable(look);
    ASSERT_EQ(table.distances.size(), 32u * 32 * 32);
    EXPECT_NEAR((table.approach_from_tool * tool.plunge_direction).dot(-Vec3d::UnitZ()), 1, 1e-9) << id;

    const Vec3d cell = table.box.size() / ToolTable::kSide;
    for (const Vec3i& at : {Vec3i(0, 0, 0), Vec3i(16, 16, 16), Vec3i(31, 3, 20)}) {
      const Vec3d middle = table.box.min + cell.cwiseProduct(at.cast<double>() + Vec3d::Constant(0.5));
      const Vec3d in_tool = table.approach_from_tool.transpose() * middle;
      const auto n = static_cast<std::size_t>((at[2] * 32 + at[1]) * 32 + at[0]);
      EXPECT_NEAR(static_cast<double>(table.distances[n]), tool.cut->distance(in_tool), 1e-4) << id;
    }
  }
  EXPECT_TRUE(toolTable(lookOf(toolOf("round-014"))).is_round);
  EXPECT_FALSE(toolTable(lookOf(toolOf("saw-reciprocating-25"))).is_round);
}

// Without a distance, a box's distance replaces it: negative inside, round about its corners.
TEST(ToolTable, WithoutADistanceIsThatOfTheBoxThatCuts) {
  ToolLook look;
  look.mesh.vertices = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 9}};
  look.mesh.triangles = {{0, 1, 2}};
  look.cutting = {{-1, -1, 0}, {1, 1, 2}};
  const ToolTable table = toolTable(look);
  const Vec3d cell = table.box.size() / ToolTable::kSide;
  const Vec3d corner = table.box.min + 0.5 * cell;
  EXPECT_NEAR(table.distances.front(), (corner - table.cutting.min).norm(), 1e-5);
  EXPECT_NEAR(*std::min_element(table.distances.begin(), table.distances.end()), -1, 0.1);
}

TEST(ToolIcon, ShowsWhatCutsWithinThePictureAndTheShankOutOfIt) {
  for (const char* const id : {"round-014", "856-016", "disc-22", "saw-reciprocating-25"}) {
    const std::vector<IconTriangle> icon = toolIcon(toolOf(id));
    float left = 1, right = 0, low = 0, high = 1;
    bool is_plain_seen = false;
    for (const IconTriangle& t : icon) {
      EXPECT_GE(t.shade, 0);
      EXPECT_LE(t.shade, 1 + 1e-5f);
      is_plain_seen |= !t.is_cutting;
      for (const auto& corner : t.corners) {
        if (!t.is_cutting) continue;
        left = std::min(left, corner[0]);
        right = std::max(right, corner[0]);
        high = std::min(high, corner[1]);
        low = std::max(low, corner[1]);
      }
    }
    EXPECT_TRUE(is_plain_seen) << id;
    EXPECT_GT(left, 0) << id;
    EXPECT_LT(right, 1) << id;
    EXPECT_GT(std::max(right - left, low - high), 0.6f) << id << ": it fills the picture";
  }
}

TEST(HeatReadings, WarnAtTheLimitOfWhatIsWarmed) {
  HeatReport heat;
  heat.surface = kBodyCelsius + kBoneLimitRise;
  EXPECT_TRUE(heatOfSurface(heat, Material::kCortical).is_warning);
  EXPECT_TRUE(heatOfSurface(heat, Material::kCancellous).is_warning);
  EXPECT_FALSE(heatOfSurface(heat, Material::kEnamel).is_warning) << "a tooth bears more";
  heat.surface = kBodyCelsius + HeatSettings{}.boiling_rise;
  EXPECT_TRUE(heatOfSurface(heat, Material::kEnamel).is_warning);
  EXPECT_EQ(heatOfSurface(heat, Material::kEnamel).celsius, heat.surface);

  heat.pulp_rise = heat.nerve_rise = kPulpLimitRise;
  EXPECT_TRUE(heatOfKept(heat, Material::kPulp).is_warning);
  EXPECT_FALSE(heatOfKept(heat, Material::kNerveCanal).is_warning);
  heat.nerve_rise = kBoneLimitRise;
  EXPECT_TRUE(heatOfKept(heat, Material::kNerveCanal).is_warning);
  EXPECT_DOUBLE_EQ(heatOfKept(heat, Material::kNerveCanal).celsius, kBodyCelsius + kBoneLimitRise);
}

TEST(ImportGuides, ARectangleOfAPlaneIsAsWideAsTheBox) {
  const Box3 box{{-3, -2, 0}, {5, 4, 7}};
  for (const Vec3d& normal : {Vec3d(0, 0, 2), Vec3d(1, 0, 0), Vec3d(0.3, -0.5, 0.8)}) {
    const Plane plane{{1, 1, 6}, normal};
    const auto corners = rectangleOf(plane, box);
    const Vec3d n = normal.normalized();
    const Vec3d u = (corners[0] - corners[1]).normalized(), v = (corners[1] - corners[2]).normalized();
    EXPECT_NEAR(u.dot(v), 0, 1e-9);
    for (const Vec3d& corner : corners) EXPECT_NEAR(n.dot(corner - plane.point), 0, 1e-9);
    double most_u = 0, most_v = 0;
    for (int k = 0; k < 8; ++k) {
      most_u = std::max(most_u, std::abs(u.dot(box.corner(k) - box.center())));
      most_v = std::max(most_v, std::abs(v.dot(box.corner(k) - box.center())));
    }
    EXPECT_NEAR((corners[0] - corners[1]).norm(), 2 * most_u, 1e-9);
    EXPECT_NEAR((corners[1] - corners[2]).norm(), 2 * most_v, 1e-9);
  }
}

}  // namespace
}  // namespace kerf::tool_look_test
