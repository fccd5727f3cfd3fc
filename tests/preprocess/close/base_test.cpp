#include <gtest/gtest.h>

#include <numbers>

#include "preprocess/close/occlusal_plane.h"
#include "tests/preprocess/solid_checks.h"

namespace kerf::base_test {
namespace {

/// An open arch: half a ring, its cross-section a U upside down, with round cusps on top; open below, normals out.
/// Mean radius 22 mm, 9 mm wide, 8 to 10 mm high; cusps reach z = 10.
Mesh arch(int along = 160, int across = 24) {
  Mesh m;
  for (int i = 0; i <= along; ++i) {
    const double a = std::numbers::pi * i / along;
    for (int j = 0; j <= across; ++j) {
      const double b = std::numbers::pi * j / across;
      const double r = 22 - 4.5 * std::cos(b);
      const double cusps = std::pow(std::sin(b), 8) * (1 + std::cos(28 * a));  // fourteen of them
      const double z = 8 * std::sin(b) + cusps;
      m.vertices.push_back(roundedToFloat(Vec3d(r * std::cos(a), r * std::sin(a), z)));
    }
  }
  const auto id = [&](int i, int j) { return static_cast<std::uint32_t>(i * (across + 1) + j); };
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < across; ++j) {
      m.triangles.push_back({id(i, j), id(i, j + 1), id(i + 1, j + 1)});
      m.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i + 1, j)});
    }
  return m;
}

Mesh turned(Mesh m, double angle, const Vec3d& axis, const Vec3d& shift = Vec3d::Zero()) {
  const Eigen::AngleAxisd r(angle, axis.normalized());
  for (Vec3d& p : m.vertices) p = roundedToFloat(Vec3d(r * p + shift));
  return m;
}

double degrees(const Vec3d& a, const Vec3d& b) {
  return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0)) * 180 / std::numbers::pi;
}

/// Distance of the base vertices from the plane {direction . x = level}, and their number.
struct Flatness {
  double worst = 0;
  std::size_t vertices = 0;
};
Flatness flatness(const Solid& s) {
  Flatness f;
  for (const Vec3d& p : s.mesh.vertices) {
    const double d = s.report.base_direction->dot(p) - s.report.base_level_mm;
    EXPECT_LT(d, 1e-4) << "nothing below the base";
    if (d > -0.05) {  // the lowest curve of the walls lies 0.1 mm above the base, or more
      f.worst = std::max(f.worst, std::abs(d));
      ++f.vertices;
    }
  }
  return f;
}

TEST(OcclusalPlane, IsFoundOnAnArchThatStandsAskew) {
  const Vec3d axis(1, 0.3, -0.2);
  const Mesh m = turned(arch(), 0.3, axis, {5, -40, 90});
  const Vec3d truth = Eigen::AngleAxisd(0.3, axis.normalized()) * Vec3d::UnitZ();
  const auto plane = findOcclusalPlane(m, Vec3d::UnitZ());  // 17 degrees off
  ASSERT_TRUE(plane) << plane.error().message();
  EXPECT_LT(degrees(plane->normal, truth), 1.0);
  EXPECT_GE(plane->tips, 12u);
  EXPECT_NEAR((plane->point - Vec3d(5, -40, 90)).dot(truth), 10, 0.3);
}

TEST(OcclusalPlane, ABallHasNone) {
  const auto plane = findOcclusalPlane(ball(40, 80, 5), Vec3d::UnitZ());
  ASSERT_FALSE(plane);
  EXPECT_EQ(plane.error().code, Error::Code::kGeometry);
  EXPECT_NE(plane.error().hint.find("--occlusal-plane"), std::string::npos);
}

TEST(Base, IsParallelToTheOcclusalPlaneFound) {
  const Vec3d axis(1, 0.3, -0.2);
  const Mesh m = turned(arch(), 0.3, axis, {5, -40, 90});
  const Solid s = closed(m, {.base_height_mm = 16, .find_occlusal_plane = true});
  expectSourceFirst(s, m);
  ASSERT_TRUE(s.report.occlusal_plane);
  EXPECT_LT(degrees(-*s.report.base_direction, s.report.occlusal_plane->normal), 1e-3);
  EXPECT_NEAR(s.report.base_level_mm - s.report.base_direction->dot(s.report.occlusal_plane->point), 16, 1e-4);
  const Flatness f = flatness(s);
  EXPECT_GT(f.vertices, 100u);
  EXPECT_LT(f.worst, 2e-5);  // half a float32 step of 90 mm, 3.8e-6, in each coordinate, and of the level
}

TEST(Base, TakesAGivenPlaneEitherWayRound) {
  const Mesh m = arch();
  const Vec3d normal(0.05, -0.1, 0.99);
  const Solid up = closed(m, {.occlusal_plane = GivenPlane{normal}});
  const Solid down = closed(m, {.occlusal_plane = GivenPlane{-3 * normal}});
  // The normals differ in their last bit. The walls may differ too, as sums of many terms place them.
  ASSERT_EQ(up.mesh.vertices.size(), down.mesh.vertices.size());
  for (std::size_t v = 0; v < up.mesh.vertices.size(); ++v)
    EXPECT_LT((up.mesh.vertices[v] - down.mesh.vertices[v]).norm(), 1e-4);
  EXPECT_LT(degrees(*up.report.base_direction, -normal), 1e-3);
  EXPECT_LT(flatness(up).worst, 2e-5);
}

TEST(Base, IsExactlyFlatWhereThePlaneIsSquareToAnAxis) {
  const Solid s = closed(arch(), {.occlusal_plane = GivenPlane{{0, 0, 2}, Vec3d(0, 0, 9)}});
  EXPECT_EQ(*s.report.base_direction, Vec3d(0, 0, -1));
  EXPECT_EQ(flatness(s).worst, 0);
}

TEST(Base, HeightCountsFromThePlaneOrTheHighestPoint) {
  EXPECT_EQ(closed(arch(), {.base_height_mm = 15}).report.base_level_mm, 5);  // the cusps reach z = 10
  const GivenPlane plane{{0, 0, 1}, Vec3d(0, 0, 9)};
  EXPECT_EQ(closed(arch(), {.base_height_mm = 15, .occlusal_plane = plane}).report.base_level_mm, 6);
}

TEST(Base, TooLowIsRefusedWithTheLeastHeight) {
  const auto s = closeMesh(arch(), {.mode = CloseMode::kBase, .base_height_mm = 8});
  ASSERT_FALSE(s);
  EXPECT_EQ(s.error().hint, "--base-height 10.5");
  EXPECT_NE(s.error().found.find("below the highest point"), std::string::npos) << s.error().found;
}

TEST(Base, PlaneAcrossTheUndersideIsRefused) {
  const auto s = closeMesh(arch(), {.mode = CloseMode::kBase, .occlusal_plane = GivenPlane{Vec3d(1, 0, 0.1)}});
  ASSERT_FALSE(s);
  EXPECT_NE(s.error().found.find("degrees to the underside"), std::string::npos) << s.error().message();
}

TEST(Base, FullStandsOnAPlateThatFloorsTheTonguesPlace) {
  const Mesh m = arch();
  const Solid horseshoe = closed(m, {.base_smoothing_mm = 0}), full = closed(m, {.base_style = BaseStyle::kFull});
  expectSourceFirst(full, m);
  EXPECT_EQ(full.report.triangles_kept, m.triangles.size());
  EXPECT_EQ(edgeConnectedPieces(full.mesh).count, 1u);
  EXPECT_EQ(full.report.base_level_mm, horseshoe.report.base_level_mm);
  // Half a disc of the outer radius, less half a ring: 1.8 mm of plate below the place of the tongue.
  const double tongue = 0.5 * std::numbers::pi * 17.5 * 17.5;
  EXPECT_NEAR(signedVolume(full.mesh) - signedVolume(horseshoe.mesh), 1.8 * tongue, 0.02 * 1.8 * tongue);
  EXPECT_EQ(flatness(full).worst, 0);
}

TEST(Base, FullWorksAskewAsWell) {
  const Mesh m = turned(arch(), 0.2, {1, 1, 0});
  const Solid s = closed(m, {.base_style = BaseStyle::kFull, .find_occlusal_plane = true});
  expectSourceFirst(s, m);
  EXPECT_LT(flatness(s).worst, 2e-5);
}

}  // namespace
}  // namespace kerf::base_test
