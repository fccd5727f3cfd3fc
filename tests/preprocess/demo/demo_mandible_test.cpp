#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>

#include "geometry/mesh/mesh_check.h"
#include "preprocess/demo/demo_anatomy.h"
#include "preprocess/demo/demo_dimensions.h"
#include "tests/preprocess/mesh_rays.h"

namespace kerf::demo_mandible_test {
namespace {

using Vec2d = Eigen::Vector2d;
constexpr DemoMandibleDimensions kDimensions;

void expectWithin(const DemoRange& range, double value, const std::string& what, double tolerance = 0) {
  EXPECT_GE(value, range.least - tolerance) << what;
  EXPECT_LE(value, range.most + tolerance) << what;
}

class DemoMandible : public ::testing::Test {
 protected:
  static const DemoAnatomy& anatomy() {
    static const DemoAnatomy anatomy = *demoMandible(2);
    return anatomy;
  }
  static const Mesh& mesh(const char* name) { return anatomy().mesh(name); }
  static const Mesh& jaw() { return mesh("mandible.ply"); }

  /// The vertex of the left half furthest in a direction, among vertices that satisfy a condition.
  template <class Condition>
  static Vec3d furthest(const Mesh& m, const Vec3d& direction, Condition condition) {
    const Vec3d* found = nullptr;
    for (const Vec3d& p : m.vertices)
      if (p.x() > -1 && condition(p) && (!found || p.dot(direction) > found->dot(direction))) found = &p;
    EXPECT_NE(found, nullptr);
    return found ? *found : Vec3d(Vec3d::Zero());
  }
  /// Side view: along the hind border of the ramus upwards, along the lower border forwards.
  static Vec2d hindBorder() {
    const auto at = [](double z) {
      return furthest(jaw(), Vec3d::UnitY(), [&](const Vec3d& p) { return std::abs(p.z() - z) < 0.7; });
    };
    const Vec3d low = at(-16), high = at(0);
    return Vec2d(high.y() - low.y(), high.z() - low.z()).normalized();
  }
  static Vec3d chin() {
    return furthest(jaw(), -Vec3d::UnitY(), [](const Vec3d& p) { return p.x() < 3 && p.z() < -28; });
  }
  static Vec3d menton() {
    return furthest(jaw(), -Vec3d::UnitZ(), [](const Vec3d& p) { return p.y() < 15; });
  }
  static Vec3d gonion() {  // halfway round the angle
    const double half = 0.5 * kDimensions.gonial_angle_deg * std::numbers::pi / 180;
    const Vec2d up = hindBorder();
    const Vec2d out =
        -Vec2d(up.x() * std::cos(half) - up.y() * std::sin(half), up.x() * std::sin(half) + up.y() * std::cos(half));
    return furthest(jaw(), Vec3d(0, out.x(), out.y()), [](const Vec3d& p) { return p.z() < -10; });
  }

  void everyTissueIsASolidReadyToPrint() {
    SCOPED_TRACE("EveryTissueIsASolidReadyToPrint");
    ASSERT_EQ(anatomy().files.size(), 7u);
    for (const DemoAnatomy::File& file : anatomy().files) {
      const MeshReport report = checkMesh(file.mesh);
      EXPECT_TRUE(report.print_ready) << file.name << ": " << describe(report);
    }
    EXPECT_EQ(checkMesh(jaw()).pieces, 1u);
    EXPECT_EQ(checkMesh(mesh("nerve-canal.ply")).pieces, 2u);
  }

  void hasTheOverallSizeOfAMandible() {
    SCOPED_TRACE("HasTheOverallSizeOfAMandible");
    expectWithin(kDimensions.bicondylar, bounds(jaw()).size().x(), "bicondylar");
    const Vec3d corner = gonion();
    const auto near = [&](const Vec3d& p) { return (p - corner).tail<2>().norm() < 5; };
    expectWithin(kDimensions.bigonial, 2 * furthest(jaw(), Vec3d::UnitX(), near).x(), "bigonial");
    expectWithin(kDimensions.body_length, corner.y() - chin().y(), "body length");
    const double crest = furthest(mesh("pdl.ply"), Vec3d::UnitZ(), [](const Vec3d& p) { return p.x() < 4; }).z();
    expectWithin(kDimensions.symphysis_height, crest - menton().z(), "symphysis", 0.5);
  }

  void ramusHasItsHeightWidthAndAngle() {
    SCOPED_TRACE("RamusHasItsHeightWidthAndAngle");
    const Vec2d up = hindBorder(), front(-up.y(), up.x());
    const Vec3d corner = gonion();
    const auto inRamus = [&](const Vec3d& p) {
      return Vec2d((p - corner).tail<2>().dot(front), (p - corner).tail<2>().dot(up));
    };
    Box3 across, along;
    for (const Vec3d& p : jaw().vertices) {
      if (p.x() < 0) continue;
      const Vec2d q = inRamus(p);
      if (std::abs(q.y() - 22) < 1) across.add({q.x(), 0, 0});
      if (std::abs(q.x() - 14) < 1) along.add({q.y(), 0, 0});
    }
    EXPECT_NEAR(across.size().x(), kDimensions.ramus_width, 1.5);
    EXPECT_NEAR(along.size().x(), kDimensions.ramus_height, 2.0);
    const Vec3d hind = furthest(jaw(), -Vec3d::UnitZ(), [](const Vec3d& p) { return p.y() > 55 && p.y() < 68; });
    const Vec2d lower = (menton() - hind).tail<2>().normalized();
    EXPECT_NEAR(std::acos(lower.dot(up)) * 180 / std::numbers::pi, kDimensions.gonial_angle_deg, 4);
  }

  void lowerBorderIsThickInFrontAndThinAtTheAngle() {
    SCOPED_TRACE("LowerBorderIsThickInFrontAndThinAtTheAngle");
    const auto front = rayCrossings(jaw(), {0.2, -30, menton().z() + 5}, Vec3d::UnitY());
    ASSERT_EQ(front.size(), 2u);
    EXPECT_NEAR(front[1] - front[0], kDimensions.border_at_symphysis, 1.5);
    const Vec3d corner = gonion();
    const auto angle = rayCrossings(jaw(), {80, corner.y() - 4, corner.z() + 4}, -Vec3d::UnitX());
    ASSERT_EQ(angle.size(), 4u);  // both sides
    EXPECT_NEAR(angle[1] - angle[0], kDimensions.border_at_gonion, 1.0);
  }

  void cortexIsTwoToThreeMillimetresThickestAtTheBase() {
    SCOPED_TRACE("CortexIsTwoToThreeMillimetresThickestAtTheBase");
    const Mesh& spongy = mesh("cancellous.ply");
    const auto cortex = [&](const Vec3d& from, const Vec3d& direction) {
      const auto bone = rayCrossings(jaw(), from, direction), core = rayCrossings(spongy, from, direction);
      EXPECT_FALSE(bone.empty() || core.empty()) << from.transpose();
      return bone.empty() || core.empty() ? 0 : core[0] - bone[0];
    };
    const double base = cortex({26.3, 22.2, -60}, Vec3d::UnitZ()), high = cortex({-60, 30, -17}, Vec3d::UnitX());
    expectWithin(kDimensions.cortex, base, "base", 0.4);
    expectWithin(kDimensions.cortex, cortex({60, 30, -30}, -Vec3d::UnitX()), "lower buccal third", 0.4);
    expectWithin(kDimensions.cortex, cortex({0.2, 60, -30}, -Vec3d::UnitY()), "behind the symphysis", 0.4);
    EXPECT_GT(base, high);
  }

  void nerveCanalRunsInBoneFromForamenToForamen() {
    SCOPED_TRACE("NerveCanalRunsInBoneFromForamenToForamen");
    const Mesh& canal = mesh("nerve-canal.ply");
    const auto across = rayCrossings(canal, {27.0, 29, -60}, Vec3d::UnitZ());
    ASSERT_EQ(across.size(), 2u);
    EXPECT_NEAR(across[1] - across[0], kDimensions.canal_diameter, 0.2);
    // Its two ends protrude from the bone, on the inner side behind and on the outer side in front. The rest lies in
    // bone.
    int mental = 0, mandibular = 0;
    double mental_z = 0, lowest = 0;
    for (std::size_t v = 0; v < canal.vertices.size(); v += 7) {
      const Vec3d& p = canal.vertices[v];
      lowest = std::min(lowest, p.z());
      const bool in_bone = isInside(jaw(), p);
      if (p.y() > 24 && p.y() < 62) {
        ASSERT_TRUE(in_bone) << p.transpose();
        ASSERT_GT(distanceToVertices(jaw(), p), p.y() < 56 ? 0.7 : 0.3) << p.transpose();
      } else if (!in_bone) {
        ++(p.y() < 40 ? mental : mandibular);
        if (p.y() < 40) mental_z += p.z();
      }
    }
    ASSERT_GT(mental, 5);
    ASSERT_GT(mandibular, 5);
    const double axis = lowest + 0.5 * kDimensions.canal_diameter;
    expectWithin(kDimensions.canal_below_foramen, mental_z / mental - axis, "dip under the mental foramen", 0.5);
  }

  void canalKeepsItsDistancesAtTheSecondMolar() {
    SCOPED_TRACE("CanalKeepsItsDistancesAtTheSecondMolar");
    const Mesh& canal = mesh("nerve-canal.ply");
    const Box3 here = boundsBetween(canal, 1, 36.5, 38.5);
    const double x = here.max.x() - 0.5 * kDimensions.canal_diameter, y = 37.5, z = here.center().z();
    const auto below = rayCrossings(jaw(), {x, y, z}, -Vec3d::UnitZ()),
               buccal = rayCrossings(jaw(), {x, y, z}, Vec3d::UnitX());
    ASSERT_FALSE(below.empty() || buccal.empty());
    const double radius = 0.5 * kDimensions.canal_diameter;
    EXPECT_NEAR(below[0] - radius, kDimensions.canal_to_border, 3.4);  // one standard deviation each
    EXPECT_NEAR(buccal[0] - radius, kDimensions.canal_to_buccal, 1.26);
    double to_root = 1e9;
    for (const Vec3d& p : mesh("teeth.ply").vertices)
      if (p.x() > 0 && p.y() > 33 && p.z() < -16) to_root = std::min(to_root, distanceToVertices(canal, p));
    EXPECT_NEAR(to_root, kDimensions.canal_to_root, 1.86);
  }

  void rootsStandInTheirSocketsAndPulpInTheTeeth() {
    SCOPED_TRACE("RootsStandInTheirSocketsAndPulpInTheTeeth");
    const Mesh& teeth = mesh("teeth.ply");
    int roots = 0;
    for (std::size_t v = 0; v < teeth.vertices.size(); v += 40) {
      const Vec3d& p = teeth.vertices[v];
      if (p.z() > -14) continue;
      ++roots;
      ASSERT_TRUE(isInside(mesh("pdl.ply"), p)) << p.transpose();
      ASSERT_TRUE(isInside(jaw(), p)) << p.transpose();
      ASSERT_FALSE(isInside(mesh("cancellous.ply"), p)) << p.transpose();
    }
    EXPECT_GT(roots, 50);
    const Mesh& pulp = mesh("pulp.ply");
    for (std::size_t v = 0; v < pulp.vertices.size(); v += 200)
      ASSERT_TRUE(isInside(teeth, pulp.vertices[v])) << pulp.vertices[v].transpose();
    EXPECT_EQ(edgeConnectedPieces(pulp).count, 14u);  // one in every tooth
  }
};

// One test, because each test is a separate process and would make the mandible again.
TEST_F(DemoMandible, IsMadeOfSolidsThatMeasureWhatTheTableSays) {
  everyTissueIsASolidReadyToPrint();
  hasTheOverallSizeOfAMandible();
  ramusHasItsHeightWidthAndAngle();
  lowerBorderIsThickInFrontAndThinAtTheAngle();
  cortexIsTwoToThreeMillimetresThickestAtTheBase();
  nerveCanalRunsInBoneFromForamenToForamen();
  canalKeepsItsDistancesAtTheSecondMolar();
  rootsStandInTheirSocketsAndPulpInTheTeeth();
}

TEST_F(DemoMandible, StopsWhenCancelled) {
  int steps = 0;
  const auto stopped = demoMandible(2, [&](double, std::string_view) { return ++steps < 2; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, Error::Code::kCancelled);
  EXPECT_EQ(steps, 2);
}

}  // namespace
}  // namespace kerf::demo_mandible_test
