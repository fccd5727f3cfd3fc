#include "preprocess/print/thickness.h"

#include <algorithm>

#include "tests/preprocess/print/print_shapes.h"

namespace kerf {
namespace {

using test::addArc;
using test::revolved;
using test::turned;
using test::turns;

// Checks each vertex in turned frames. @param expected  of a vertex before the turn.
template <class F>
void expectThickness(const Mesh& mesh, double tolerance, const F& expected, const ThicknessOptions& options = {}) {
  for (const Eigen::Matrix3d& turn : turns()) {
    const auto found = wallThickness(turned(mesh, turn, Vec3d(3, 5, 7)), options);
    ASSERT_TRUE(found) << found.error().message();
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
      ASSERT_NEAR((*found)[v], expected(mesh.vertices[v]), tolerance) << mesh.vertices[v].transpose();
  }
}

TEST(Thickness, PlateIsAsThickAtItsCornersAsInItsMiddle) {
  expectThickness(box(Vec3d::Zero(), Vec3d(30, 20, 2)), 5e-4, [](const Vec3d&) { return 2; });
  expectThickness(revolved({{0, 0}, {5, 0}, {12, 0}, {12, 1.5}, {5, 1.5}, {0, 1.5}}), 5e-4,
                  [](const Vec3d&) { return 1.5; });
  expectThickness(box(0, 30), 5e-4, [](const Vec3d&) { return 10; });
  expectThickness(box(0, 30), 5e-4, [](const Vec3d&) { return 30; }, {.most_mm = 80});
}

TEST(Thickness, TubeAndHollowBallHaveTheirWall) {
  const Mesh tube = revolved({{5, -20}, {8, -20}, {8, -7}, {8, 9}, {8, 20}, {5, 20}, {5, 11}, {5, -6}});
  expectThickness(tube, 0.002, [](const Vec3d&) { return 3; });  // chords of circles
  const Mesh hollow = both(ball(32, 64, 9), flipped(ball(32, 64, 7)));
  expectThickness(hollow, 0.03, [](const Vec3d&) { return 2; });
  expectThickness(ball(24, 48, 4), 0.04, [](const Vec3d&) { return 8; });
}

TEST(Thickness, WedgeTapersToNothing) {
  // Faces 20 degrees apart, which meet in the edge x = z = 0; vertices 1 mm apart along them.
  const double half = 10 * M_PI / 180;
  constexpr std::uint32_t kSteps = 20;
  Mesh mesh;
  for (std::uint32_t i = 0; i <= kSteps; ++i)
    for (const double up : {half, -half})
      for (const double y : {0.0, 30.0}) mesh.vertices.push_back({i * std::cos(up), y, i * std::sin(up)});
  const auto quad = [&mesh](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  // Vertices 4 i + 0 and 1 above, + 2 and 3 below; those of i = 0 coincide in pairs.
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const std::uint32_t n = 4 * i, m = n + 4;
    quad(n, m, m + 1, n + 1);
    quad(n + 2, n + 3, m + 3, m + 2);
    quad(n, n + 2, m + 2, m);
    quad(n + 1, m + 1, m + 3, n + 3);
  }
  quad(4 * kSteps, 4 * kSteps + 2, 4 * kSteps + 3, 4 * kSteps + 1);
  ASSERT_GT(signedVolume(mesh), 0);
  expectThickness(mesh, 5e-4, [half](const Vec3d& p) {
    const double along = Vec3d(p[0], 0, p[2]).norm();
    return std::min(10.0, 2 * along * std::tan(half));
  });
}

TEST(Thickness, RefusesWithPlaceAndRemedy) {
  EXPECT_EQ(wallThickness({}).error().code, Error::Code::kEmpty);
  EXPECT_EQ(wallThickness(flipped(box(0, 1))).error().code, Error::Code::kGeometry);
  EXPECT_EQ(wallThickness(box(0, 1), {.most_mm = 0}).error().place, "most thickness");
  EXPECT_EQ(wallThickness(box(0, 1), {.opposing_deg = 90}).error().place, "angle of opposing surfaces");
  EXPECT_EQ(wallThickness(box(0, 1), {}, [](double, std::string_view) { return false; }).error().code,
            Error::Code::kCancelled);
}

}  // namespace
}  // namespace kerf
