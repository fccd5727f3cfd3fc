#include "preprocess/print/undercut.h"

#include <algorithm>

#include "tests/preprocess/print/print_shapes.h"

namespace kerf {
namespace {

using test::addArc;
using test::revolved;
using test::turned;
using test::turns;

constexpr double kVoxel = 0.1;

// A ball of radius 5 about the origin on a stick of radius 1 down to z = -15.
Mesh ballOnStick() {
  std::vector<Eigen::Vector2d> profile{{0, -15}};
  for (int n = 0; n < 10; ++n) profile.push_back({1, -15 + n});
  addArc(profile, 5, -std::acos(0.2), 0);
  addArc(profile, 5, 0.02, M_PI / 2);
  return revolved(profile, 128);
}

// Largest error too deep and too shallow, over the vertices for which `expected` has a value; vertices in the frame
// before the turn.
template <class Expected>
std::pair<double, double> errorsOf(const Mesh& mesh, const Eigen::Matrix3d& turn, const UndercutOptions& options,
                                   const Expected& expected) {
  const auto depths = undercutDepths(turned(mesh, turn), turn.col(2), options);
  EXPECT_TRUE(depths) << depths.error().message();
  if (!depths) return {1e9, 1e9};
  double over = 0, under = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (const std::optional<double> mm = expected(mesh.vertices[v])) {
      over = std::max(over, (*depths)[v] - *mm);
      under = std::max(under, *mm - (*depths)[v]);
    }
  return {over, under};
}

TEST(Undercut, BallOnAStickLiesBehindItsEquator) {
  for (const Eigen::Matrix3d& turn : turns()) {
    const auto [over, under] =
        errorsOf(ballOnStick(), turn, {.voxel_mm = kVoxel, .most_mm = 9},
                 [](const Vec3d& p) -> std::optional<double> { return p[2] >= -1e-9 ? 0 : 5 - p.head<2>().norm(); });
    EXPECT_LT(over, 0.003);
    EXPECT_LT(under, 0.002);  // the equator is a polygon
  }
}

TEST(Undercut, ConeHasOneOnlyWithItsTipDown) {
  for (const Eigen::Matrix3d& turn : turns()) {
    std::vector<Eigen::Vector2d> up, down;
    for (int n = 0; n <= 20; ++n) {
      down.push_back({4 * n / 20.0, 10 * n / 20.0});
      up.push_back({4 - 4 * n / 20.0, 10 * n / 20.0});
    }
    down.push_back({0, 10});
    const UndercutOptions options{.voxel_mm = kVoxel, .most_mm = 9};
    const auto [over, under] = errorsOf(revolved(down), turn, options, [](const Vec3d& p) -> std::optional<double> {
      return p[2] < 10 ? 4 - p.head<2>().norm() : 0;
    });
    EXPECT_LT(over, 0.003);
    EXPECT_LT(under, 0.002);
    EXPECT_LT(errorsOf(revolved(up), turn, options, [](const Vec3d&) -> std::optional<double> { return 0; }).first,
              1e-9);
  }
}

TEST(Undercut, LeaningCylinderIsReachedFromItsSides) {
  // Radius 3; the shadow of the part above reaches over the lower side as far as the sides.
  const double lean = 0.35;
  std::vector<Eigen::Vector2d> profile{{0, -30}};
  for (int n = 0; n <= 60; ++n) profile.push_back({3, -30.0 + n});
  profile.push_back({0, 30});
  const Mesh cylinder = turned(revolved(profile, 128), Eigen::AngleAxisd(lean, Vec3d::UnitY()).toRotationMatrix());
  for (const Eigen::Matrix3d& turn : turns()) {
    const auto [over, under] =
        errorsOf(cylinder, turn, {.voxel_mm = kVoxel}, [lean](const Vec3d& p) -> std::optional<double> {
          if (std::abs(p[2]) > 8) return {};
          const double x = p[0] - p[2] * std::tan(lean);
          return x > 1e-9 ? 3 - std::abs(p[1]) : 0;
        });
    EXPECT_LT(over, 0.003);
    EXPECT_LT(under, 0.002);
  }
}

TEST(Undercut, CountsOnlyAboveThePlaneAndUpToTheMost) {
  const Mesh mesh = ballOnStick();
  const auto depths = undercutDepths(mesh, Vec3d::UnitZ(), {.above = Plane{{0, 0, -10}, Vec3d::UnitZ()}, .most_mm = 3});
  ASSERT_TRUE(depths);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Vec3d& p = mesh.vertices[v];
    const double expected = p[2] <= -10 || p[2] >= -1e-9 ? 0 : std::min(3.0, 5 - p.head<2>().norm());
    EXPECT_NEAR((*depths)[v], expected, 0.02) << p.transpose();
  }
}

TEST(Undercut, BlockOutIsTheShadowWithoutTheSolid) {
  const double s = std::sqrt(24.0), ball = M_PI * (25 * s - s * s * s / 3);
  for (const Eigen::Matrix3d& turn : turns()) {
    const Mesh mesh = turned(ballOnStick(), turn);
    const auto all = undercutVolume(mesh, turn.col(2));
    ASSERT_TRUE(all) << all.error().message();
    EXPECT_NEAR(*all, 25 * M_PI * 15 - ball - M_PI * (15 - s), 0.003 * 25 * M_PI * 15);
    const auto part = undercutVolume(mesh, turn.col(2), {.above = Plane{-10 * turn.col(2), turn.col(2)}});
    ASSERT_TRUE(part);
    EXPECT_NEAR(*all - *part, 24 * M_PI * 5, 0.005 * 24 * M_PI * 5);
  }
}

double degreesBetween(const Vec3d& a, const Vec3d& b) { return std::acos(std::min(1.0, a.dot(b))) * 180 / M_PI; }

TEST(Undercut, FindsTheAxisOfALeaningCylinder) {
  const Mesh cylinder = revolved({{0, 0}, {3, 0}, {3, 12}, {0, 12}}, 128);
  for (const Eigen::Matrix3d& turn : turns()) {
    const Vec3d start = turn * Eigen::AngleAxisd(0.16, Vec3d(0.8, 0.6, 0)) * Vec3d::UnitZ();
    const auto found = findInsertionAxis(turned(cylinder, turn), start);
    ASSERT_TRUE(found) << found.error().message();
    EXPECT_LT(degreesBetween(found->axis, turn.col(2)), 1);
    EXPECT_LT(found->undercut_mm3, 0.12 * found->start_mm3);
  }
}

TEST(Undercut, KeepsTheStartWhereNoAxisIsBetter) {
  // A stump that tapers by 11 degrees has no undercut along any axis within them.
  const Mesh stump = revolved({{0, 0}, {5, 0}, {3, 10}, {0, 10}});
  const Vec3d start = Eigen::AngleAxisd(0.1, Vec3d::UnitX()) * Vec3d::UnitZ();
  const AxisOptions options{.undercut = {.above = Plane{{0, 0, 0.1}, Vec3d::UnitZ()}, .voxel_mm = 0.2}};
  const auto kept = findInsertionAxis(stump, start, options);
  ASSERT_TRUE(kept) << kept.error().message();
  EXPECT_EQ(kept->axis, start);
  EXPECT_LT(kept->undercut_mm3, 0.05);
  const Vec3d leaning = Eigen::AngleAxisd(0.32, Vec3d::UnitX()) * Vec3d::UnitZ();
  const auto better = findInsertionAxis(stump, leaning, options);
  ASSERT_TRUE(better);
  EXPECT_LT(degreesBetween(better->axis, Vec3d::UnitZ()), 12);
  EXPECT_GT(better->start_mm3, 5);
  EXPECT_LT(better->undercut_mm3, 0.2);
}

TEST(Undercut, RefusesWithPlaceAndRemedy) {
  Mesh open = box(0, 10);
  open.triangles.pop_back();
  EXPECT_TRUE(undercutDepths(open, Vec3d::UnitX()));
  const auto volume = undercutVolume(open, Vec3d::UnitX());
  ASSERT_FALSE(volume);
  EXPECT_NE(volume.error().message().find("an open surface"), std::string::npos);
  EXPECT_FALSE(findInsertionAxis(open, Vec3d::UnitX()));
  EXPECT_EQ(undercutDepths(box(0, 1), Vec3d(0, 0, 2)).error().place, "insertion axis");
  EXPECT_EQ(undercutDepths(box(0, 1), Vec3d::UnitX(), {.above = Plane{}}).error().place,
            "plane above which undercuts count");
  EXPECT_EQ(undercutDepths({}, Vec3d::UnitX()).error().code, Error::Code::kEmpty);
  EXPECT_EQ(findInsertionAxis(box(0, 1), Vec3d::UnitX(), {.cone_deg = 60}).error().place, "cone");
  for (const double until : {0.0, 0.3, 0.45}) {
    const Progress stop = [until](double at, std::string_view) { return at < until; };
    EXPECT_EQ(undercutDepths(ballOnStick(), Vec3d::UnitZ(), {}, stop).error().code, Error::Code::kCancelled) << until;
    EXPECT_EQ(findInsertionAxis(box(0, 1), Vec3d::UnitZ(), {}, stop).error().code, Error::Code::kCancelled) << until;
  }
}

}  // namespace
}  // namespace kerf
