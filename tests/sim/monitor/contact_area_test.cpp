#include "sim/monitor/contact_area.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/tool/tool_file.h"
#include "sim/monitor/tool_heat.h"
#include "tests/sim/block_scene.h"
#include "tests/support/allocation_guard.h"

namespace kerf::contact_area_test {
namespace {

using test::block;

constexpr int kSamples = 1600;

Tool toolOfRack(const char* id) {
  const auto file = findToolFile(id, defaultToolFolders());
  EXPECT_TRUE(file) << file.error().message();
  auto tool = readTool(*file);
  EXPECT_TRUE(tool) << tool.error().message();
  return *tool;
}
ContactArea areaOf(const ToolModel& tool, const Vec3d& flank = Vec3d::Zero()) {
  return ContactArea(tool, ToolSamples(tool.cut, kSamples), flank);
}
// The mean of a full turn.
double areaAt(ContactArea& area, const std::vector<CutObject>& objects, const Rigid3& pose, std::uint64_t touched = 1) {
  double sum = 0;
  for (int n = 0; n < ContactArea::kTurn; ++n) sum += area.read(objects, touched, pose).area;
  return sum / ContactArea::kTurn;
}
Rigid3 at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), Vec3d(x, y, z)}; }

// A block with a round groove for a ball of that radius: depth of its lowest point.
std::shared_ptr<const BakedObject> blockWithPrint(double radius, double depth, double voxel) {
  Box3 box;
  box.add(Vec3d(-3, -3, -3));
  box.add(Vec3d(3, 3, 0));
  const Vec3d center(0, 0, radius - depth);
  return test::bakedFrom(
      [=](const Vec3d& p) {
        const Vec3d q = (p - Vec3d(0, 0, -1.5)).cwiseAbs() - Vec3d(3, 3, 1.5);
        const double inside = q.cwiseMax(0).norm() + std::min(0.0, q.maxCoeff());
        return std::max(inside, radius - (p - center).norm());
      },
      box, voxel);
}

TEST(ContactArea, AreasOfTheSamplesSumToTheSurface) {
  for (const double radius : {0.25, 0.7, 1.1}) {
    const ContactArea ball = areaOf(practiceBall(radius, 1));
    EXPECT_NEAR(ball.whole() / (4 * std::numbers::pi * radius * radius), 1, 0.03) << radius;
  }
}

// The neck hides a part of the head; teeth have a front as wide as the kerf.
TEST(ContactArea, WhatTheBodyHidesAndFlanksDoNotCount) {
  const Tool bur = toolOfRack("round-014");
  const double head = 4 * std::numbers::pi * 0.49, hidden = std::numbers::pi * 0.16;
  EXPECT_NEAR(areaOf(makeToolModel(bur)).whole() / (head - hidden), 1, 0.05);

  const Tool saw = toolOfRack("saw-reciprocating-25");
  const double length = saw.blade_length_mm + saw.stroke_mm;
  const ContactArea teeth = areaOf(makeToolModel(saw), heatSource(saw).flank);
  EXPECT_NEAR(teeth.whole() / (saw.kerfWidth() * length), 1, 0.1);
}

// A ball in its own print: the zone below the surface, 2 pi r depth, plus an equal zone above it that is still close.
TEST(ContactArea, ABallInItsPrintTouchesTheZoneBelowTheSurface) {
  constexpr double kRadius = 0.8;
  for (const double voxel : {0.1, 0.05})
    for (const double depth : {0.3, 0.6, 0.8}) {
      std::vector<CutObject> objects;
      objects.emplace_back(blockWithPrint(kRadius, depth, voxel), 16);
      ContactArea area = areaOf(practiceBall(kRadius, 1));
      const double most = 2 * std::numbers::pi * kRadius * (depth + ContactArea::kClose);
      const double found = areaAt(area, objects, at(0, 0, -depth));
      EXPECT_GT(found, 0.9 * 2 * std::numbers::pi * kRadius * depth) << voxel << ", " << depth;
      EXPECT_LT(found, 1.05 * most) << voxel << ", " << depth;
    }
}

// A penalty lets the tool overlap; a constraint does not.
TEST(ContactArea, OverlapChangesItLittle) {
  constexpr double kRadius = 0.8, kDepth = 0.6;
  std::vector<CutObject> objects;
  objects.emplace_back(blockWithPrint(kRadius, kDepth, 0.1), 16);
  ContactArea area = areaOf(practiceBall(kRadius, 1));
  const double by_constraint = areaAt(area, objects, at(0, 0, -kDepth - 0.005));
  const double by_penalty = areaAt(area, objects, at(0, 0, -kDepth - 0.06));
  EXPECT_NEAR(by_penalty / by_constraint, 1, 0.1);
}

// At the start, a print is as shallow as the overlap. Without the overlap the tool stands equally high with any
// response.
TEST(ContactArea, HeatEntersThroughTheSameAreaWhateverTheResponseOverlaps) {
  for (const double radius : {0.25, 0.4, 1.15})
    for (const double depth : {0.05, 0.2}) {
      std::vector<CutObject> objects;
      objects.emplace_back(blockWithPrint(radius, depth, 0.05), 16);
      const ToolModel ball = practiceBall(radius, 1);
      const auto areaWith = [&](double overlap) {
        HeatingTool tool(ball, ToolSamples(ball.cut, kSamples));
        ToolHeat heat;
        StepOutput output;
        output.touching = 1;
        output.objects_touched = 1;
        output.T_world_tool = at(0, 0, -depth - overlap);
        output.deepest = overlap;
        output.contact.force = Vec3d(0, 0, 1.5);
        double sum = 0;
        for (int n = 0; n < ContactArea::kTurn; ++n) {
          heat.tick(tool, {}, output, objects);
          sum += heat.area();
        }
        return sum / ContactArea::kTurn;
      };
      const double by_constraint = areaWith(0.0055);
      for (const double overlap : {0.06, 0.14})  // of 1 N and 5 N by penalty
        EXPECT_NEAR(areaWith(overlap) / by_constraint, 1, 0.1) << radius << ", " << depth << ", " << overlap;
    }
}

TEST(ContactArea, InAirThereIsNoneAndOnlyWhatIsTouchedIsLookedAt) {
  std::vector<CutObject> objects;
  objects.emplace_back(block({4, 4, 2}, 0.1), 16);
  objects.emplace_back(block({4, 4, 2}, 0.1), 16);
  objects[1].moveTo(at(20, 0, 0));
  ContactArea area = areaOf(practiceBall(0.8, 1));
  EXPECT_EQ(areaAt(area, objects, at(0, 0, 0.2), 3), 0);
  EXPECT_EQ(areaAt(area, objects, at(1000, 0, 0.2), 3), 0);
  EXPECT_EQ(areaAt(area, objects, at(0, 0, -0.3), 0), 0);
  EXPECT_EQ(areaAt(area, objects, at(0, 0, -0.3), 2), 0);
  EXPECT_GT(areaAt(area, objects, at(0, 0, -0.3), 1), 1);
  EXPECT_NEAR(areaAt(area, objects, at(20, 0, -0.3), 2), areaAt(area, objects, at(0, 0, -0.3), 1), 1e-3);

  ContactArea::Reading reading;
  const AllocationGuard guard;
  for (int n = 0; n < ContactArea::kTurn; ++n) reading = area.read(objects, 3, at(0, 0, -0.3));
  EXPECT_LT(reading.middle[2], 0.3) << "below its equator";
}

TEST(ContactArea, DistanceInIsTheFieldsOwn) {
  std::vector<CutObject> objects;
  objects.emplace_back(block({4, 4, 2}, 0.1), 16);
  for (int n = 0; n < 5000; ++n) {
    const Vec3d p(1.9 * std::sin(0.37 * n), 1.9 * std::cos(0.23 * n), 0.35 * std::sin(1.7 * n));
    EXPECT_NEAR(distanceIn(objects[0], p), objects[0].baked().phi0().sample(p), 1e-5) << p.transpose();
  }
  EXPECT_GT(distanceIn(objects[0], Vec3d::Constant(std::nan(""))), 0);
}

}  // namespace
}  // namespace kerf::contact_area_test
