#include "preprocess/print/drain.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "geometry/mesh/crossing_pairs.h"
#include "geometry/mesh/mesh_check.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/preprocess/solid_checks.h"

namespace kerf::drain_test {
namespace {

constexpr double kPi = std::numbers::pi;

Mesh hollowBox(const Vec3d& low, const Vec3d& high, double wall) {
  return both(box(low, high), flipped(box(low + Vec3d::Constant(wall), high - Vec3d::Constant(wall))));
}
Mesh hollowBall(const Vec3d& center, double r, double wall) {
  return both(ballMesh(center, r, 60), ballMesh(center, r - wall, 50, true));
}

std::vector<RoundHole> holesOf(const DrainPlan& plan) {
  std::vector<RoundHole> out;
  for (const Drain& d : plan.drains) out.push_back(d.hole);
  return out;
}

// Plans, drills, and checks what every drained model has to be.
Drained drainedOf(const Mesh& mesh, const DrainPlan& plan) {
  auto done = drained(mesh, holesOf(plan));
  EXPECT_TRUE(done) << done.error().message();
  if (!done) return {};
  const MeshReport report = checkMesh(done->mesh);
  EXPECT_TRUE(report.print_ready) << (report.reasons.empty() ? "" : report.reasons.front());
  EXPECT_TRUE(crossingPairs(done->mesh).empty());
  EXPECT_EQ(report.cavities, done->cavities_left);

  // Source vertices outside of all holes stay, in their order; no other is called one.
  std::size_t at = 0;
  for (const Vec3d& p : mesh.vertices) {
    double outside = 1e9;
    for (const Drain& d : plan.drains) outside = std::min(outside, d.hole.outside(p));
    if (outside < 1e-3) continue;
    while (at < done->mesh.vertices.size() && done->mesh.vertices[at] != p) ++at;
    EXPECT_LT(at, done->mesh.vertices.size()) << "an uncut vertex is missing or out of order";
    if (at >= done->mesh.vertices.size()) return {};
    EXPECT_TRUE(done->is_source[at]);
  }
  std::set<std::array<double, 3>> old;
  for (const Vec3d& p : mesh.vertices) old.insert({p[0], p[1], p[2]});
  for (std::size_t v = 0; v < done->mesh.vertices.size(); ++v) {
    const Vec3d& p = done->mesh.vertices[v];
    if (done->is_source[v]) {
      EXPECT_TRUE(old.contains({p[0], p[1], p[2]}));
    }
  }
  // Cut faces lie on the holes, the others in the plane of their source triangle.
  for (std::size_t t = 0; t < done->mesh.triangles.size(); ++t) {
    const Vec3d middle = (done->mesh.corner(t, 0) + done->mesh.corner(t, 1) + done->mesh.corner(t, 2)) / 3;
    EXPECT_EQ(done->is_cut[t] != 0, done->from_triangle[t] == kNoSource);
    if (done->is_cut[t]) {
      double off = 1e9;
      for (const Drain& d : plan.drains) off = std::min(off, std::abs(d.hole.outside(middle)));
      EXPECT_LT(off, 6e-3);
    } else {
      const Vec3d n = doubleAreaVector(mesh, done->from_triangle[t]).normalized();
      EXPECT_LT(std::abs(n.dot(middle - mesh.corner(done->from_triangle[t], 0))), 5e-3);
    }
  }
  return std::move(*done);
}

// Area of the prism of 64 sides that withHole() drills.
double areaOf(double diameter) { return 32 * std::sin(2 * kPi / 64) * diameter * diameter / 4; }

TEST(Drain, ABoxIsDrainedThroughItsBaseAtTwoFarCorners) {
  const Mesh mesh = hollowBox({-15, -10, 0}, {15, 10, 12}, 2);
  const auto plan = placeDrains(mesh, {});
  ASSERT_TRUE(plan) << plan.error().message();
  ASSERT_EQ(plan->cavities.size(), 1u);
  EXPECT_NEAR(plan->cavities[0].volume_mm3, 26 * 16 * 8, 1e-6);
  EXPECT_EQ(plan->cavities[0].lowest[2], 2);
  ASSERT_EQ(plan->drains.size(), 2u);
  for (const Drain& d : plan->drains) {
    EXPECT_TRUE(d.is_below);
    EXPECT_EQ(d.hole.axis, Vec3d::UnitZ());
    EXPECT_NEAR(d.wall_mm, 2, 1e-9);
    EXPECT_LT(d.hole.mouth[2], 0);
    EXPECT_LT(d.hole.mouth[2] + d.hole.depth, 3);
    // The whole circle lies over the cavity.
    EXPECT_LE(std::abs(d.hole.mouth[0]), 13 - 1.75);
    EXPECT_LE(std::abs(d.hole.mouth[1]), 8 - 1.75);
  }
  const Drained done = drainedOf(mesh, *plan);
  EXPECT_EQ(done.cavities_before, 1u);
  EXPECT_EQ(done.cavities_left, 0u);
  EXPECT_NEAR(done.removed_mm3, 2 * 2 * areaOf(3.5), 0.01);
}

TEST(Drain, AFarDrainIsFar) {
  // Finer triangles: places all over the floor.
  const Mesh mesh = hollowBall({0, 0, 0}, 10, 2);
  DrainOptions options;
  options.side = DrainSide::kNearestWall;
  const auto plan = placeDrains(mesh, options);
  ASSERT_TRUE(plan) << plan.error().message();
  ASSERT_EQ(plan->drains.size(), 2u);
  EXPECT_LT(plan->drains[0].hole.mouth[2], -9.9);
  EXPECT_GT(plan->drains[1].hole.mouth[2], 9) << "the other pole is the farthest place";
  for (const Drain& d : plan->drains) {
    EXPECT_FALSE(d.is_below);
    EXPECT_NEAR(d.hole.axis.dot(d.hole.mouth.normalized()), -1, 0.01);
  }
  const Drained done = drainedOf(mesh, *plan);
  EXPECT_EQ(done.cavities_left, 0u);
  EXPECT_NEAR(done.removed_mm3 / (2 * 2 * areaOf(3.5)), 1, 0.02);
}

TEST(Drain, FollowsThePrintingDirection) {
  const Mesh mesh = hollowBox({-15, -10, 0}, {15, 10, 12}, 2);
  for (const Vec3d& up : {Vec3d(0, 0, -2), Vec3d(1, 0, 0), Vec3d(0, -1, 0)}) {
    DrainOptions options;
    options.build_direction = up;
    const auto plan = placeDrains(mesh, options);
    ASSERT_TRUE(plan) << plan.error().message();
    for (const Drain& d : plan->drains) EXPECT_NEAR(d.hole.axis.dot(up.normalized()), 1, 1e-12);
    EXPECT_EQ(drainedOf(mesh, *plan).cavities_left, 0u);
  }
}

TEST(Drain, AModelThatStandsOnAnEdgeIsDrainedTheShortestWay) {
  const Mesh mesh = hollowBox({-15, -10, 0}, {15, 10, 12}, 2);
  DrainOptions options;
  options.build_direction = {1, 0, 1};
  const auto plan = placeDrains(mesh, options);
  ASSERT_TRUE(plan) << plan.error().message();
  for (const Drain& d : plan->drains) {
    EXPECT_FALSE(d.is_below);
    EXPECT_NEAR(d.wall_mm, 2, 1e-6);
  }
  EXPECT_EQ(drainedOf(mesh, *plan).cavities_left, 0u);
}

TEST(Drain, EveryCavityGetsOne) {
  Mesh mesh = both(hollowBall({0, 0, 0}, 7, 2), hollowBall({20, 0, 0}, 5, 2));
  append(mesh, flipped(ballMesh({40, 0, 0}, 1.2, 20)));
  append(mesh, ballMesh({40, 0, 0}, 3, 30));
  const auto plan = placeDrains(mesh, {});
  ASSERT_TRUE(plan) << plan.error().message();
  ASSERT_EQ(plan->cavities.size(), 3u);
  std::set<std::size_t> drained_cavities;
  for (const Drain& d : plan->drains) drained_cavities.insert(d.cavity);
  EXPECT_EQ(drained_cavities.size(), 3u);
  const Drained done = drainedOf(mesh, *plan);
  EXPECT_EQ(done.cavities_before, 3u);
  EXPECT_EQ(done.cavities_left, 0u);
}

TEST(Drain, ByHandItGoesWhereItIsAsked) {
  const Mesh mesh = hollowBox({-15, -10, 0}, {15, 10, 12}, 2);
  DrainOptions options;
  options.at = {{3, 4, -0.4}, {15.3, 1, 6}};
  const auto plan = placeDrains(mesh, options);
  ASSERT_TRUE(plan) << plan.error().message();
  ASSERT_EQ(plan->drains.size(), 2u);
  EXPECT_TRUE(plan->drains[0].is_below && plan->drains[0].is_by_hand);
  EXPECT_LT((plan->drains[0].hole.mouth.head<2>() - Eigen::Vector2d(3, 4)).norm(), 1e-9);
  EXPECT_NEAR(plan->drains[1].hole.axis[0], -1, 1e-9);
  EXPECT_EQ(drainedOf(mesh, *plan).cavities_left, 0u);

  options.at = {{40, 4, -1}};  // on the solid box
  const auto none = placeDrains(both(mesh, box({35, 0, 0}, {45, 10, 10})), options);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Error::Code::kGeometry);
  EXPECT_NE(none.error().place.find("40.0"), std::string::npos) << none.error().message();
}

TEST(Drain, RefusesModelsWithoutCavityAndBadOptions) {
  EXPECT_EQ(placeDrains(box(0, 10), {}).error().code, Error::Code::kEmpty);
  const Mesh mesh = hollowBox({0, 0, 0}, {20, 20, 20}, 2);
  DrainOptions options;
  options.diameter_mm = std::nan("");
  EXPECT_EQ(placeDrains(mesh, options).error().code, Error::Code::kBadValue);
  options = {};
  options.count = 0;
  EXPECT_EQ(placeDrains(mesh, options).error().code, Error::Code::kBadValue);
  options = {};
  options.build_direction.setZero();
  EXPECT_EQ(placeDrains(mesh, options).error().code, Error::Code::kBadValue);
  EXPECT_EQ(drained(mesh, {}).error().code, Error::Code::kBadValue);

  // A cavity wider than the model's wall allows: every hole of 6 mm would come out beside it.
  options = {};
  options.diameter_mm = 6;
  const auto none = placeDrains(both(box({0, 0, 0}, {6, 6, 40}), flipped(box({2, 2, 2}, {4, 4, 38}))), options);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().place, "cavity 1 of 1");
}

TEST(Drain, AHoleThatIsNoDrainIsNamed) {
  const Mesh mesh = hollowBox({0, 0, 0}, {20, 20, 12}, 2);
  const RoundHole good{{6, 6, -0.3}, Vec3d::UnitZ(), 3.5, 2.6}, blind{{14, 14, -0.3}, Vec3d::UnitZ(), 3.5, 1.5},
      through{{14, 14, -0.3}, Vec3d::UnitZ(), 3.5, 14}, beside{{40, 0, 0}, Vec3d::UnitZ(), 3.5, 5};
  for (const RoundHole& bad : {blind, through, beside}) {
    const std::array<RoundHole, 2> holes{good, bad};
    const auto done = drained(mesh, holes);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, Error::Code::kGeometry);
    EXPECT_NE(done.error().place.find("drain 2"), std::string::npos) << done.error().message();
  }
}

TEST(Drain, ColoursStayAndCancelling) {
  Mesh mesh = hollowBox({0, 0, 0}, {20, 20, 12}, 2);
  const RoundHole hole{{6, 6, -0.3}, Vec3d::UnitZ(), 3.5, 2.6};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    mesh.face_colors.push_back({static_cast<std::uint8_t>(t), 9, 7, 255});
  const auto done = drained(mesh, {&hole, 1});
  ASSERT_TRUE(done) << done.error().message();
  ASSERT_EQ(done->mesh.face_colors.size(), done->mesh.triangles.size());
  for (std::size_t t = 0; t < done->mesh.triangles.size(); ++t)
    EXPECT_EQ(done->mesh.face_colors[t],
              done->is_cut[t] ? PostOpOptions{}.cut_color : mesh.face_colors[done->from_triangle[t]]);
  const auto stop = [](double, std::string_view) { return false; };
  EXPECT_EQ(drained(mesh, {&hole, 1}, stop).error().code, Error::Code::kCancelled);
  EXPECT_EQ(placeDrains(mesh, {}, stop).error().code, Error::Code::kCancelled);
}

}  // namespace
}  // namespace kerf::drain_test
