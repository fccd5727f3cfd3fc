#include "preprocess/print/hollow.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstdlib>
#include <numbers>

#include "geometry/formats/mesh_io.h"
#include "geometry/mesh/crossing_pairs.h"
#include "geometry/mesh/mesh_check.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/preprocess/solid_checks.h"
#include "tests/support/places.h"

namespace kerf::hollow_test {
namespace {

double ballVolume(double r) { return 4.0 / 3 * std::numbers::pi * r * r * r; }

// Everything that hollow() guarantees, found again without its own numbers.
void expectHollow(const Mesh& solid, const HollowOptions& options, const Hollowed& h) {
  ASSERT_EQ(h.is_inner.size(), h.mesh.triangles.size());
  ASSERT_GE(h.mesh.triangles.size(), solid.triangles.size());
  for (std::size_t v = 0; v < solid.vertices.size(); ++v) ASSERT_EQ(h.mesh.vertices[v], solid.vertices[v]);
  for (std::size_t t = 0; t < h.mesh.triangles.size(); ++t) {
    ASSERT_EQ(h.is_inner[t] != 0, t >= solid.triangles.size());
    if (!h.is_inner[t]) {
      ASSERT_EQ(h.mesh.triangles[t], solid.triangles[t]);
    }
  }
  for (const Vec3d& p : h.mesh.vertices) ASSERT_EQ(p, roundedToFloat(p));
  const MeshReport report = checkMesh(h.mesh);
  EXPECT_TRUE(report.print_ready) << (report.reasons.empty() ? "" : report.reasons.front());
  EXPECT_TRUE(crossingPairs(h.mesh).empty());
  EXPECT_GE(h.wall.least_mm, options.wall_mm - 0.5 * h.voxel_mm);
  EXPECT_GE(h.wall.share_within, 0.95);
  EXPECT_LE(h.wall.p05_mm, h.wall.mean_mm);
  EXPECT_LE(h.voxel_mm, options.wall_mm / 12 + 1e-12);
  EXPECT_NEAR(h.resin_mm3, signedVolume(h.mesh), 1e-9 * h.solid_mm3);
}

Hollowed hollowOf(const Mesh& solid, const HollowOptions& options = {}) {
  auto h = hollow(solid, options);
  EXPECT_TRUE(h) << h.error().message();
  if (!h) return {};
  expectHollow(solid, options, *h);
  return std::move(*h);
}

TEST(Hollow, ABallGetsAConcentricBall) {
  for (const Vec3d& center : {Vec3d(0.03, -0.02, 0.01), Vec3d(301.3, -287.7, 311.1)}) {
    const Hollowed h = hollowOf(ballMesh(center, 8, 60));
    EXPECT_EQ(h.cavities, 1u);
    EXPECT_EQ(h.cavities_dropped, 0u);
    EXPECT_NEAR((h.solid_mm3 - h.resin_mm3) / ballVolume(6), 1, 0.005);
    for (std::size_t t = 0; t < h.mesh.triangles.size(); ++t)
      if (h.is_inner[t]) {
        // The facets of the outer ball are up to 8 (1 - cos(pi / 120)) mm below it.
        ASSERT_NEAR((h.mesh.corner(t, 0) - center).norm(), 6, 0.006);
      }
    EXPECT_NEAR(h.wall.mean_mm, 2, 0.002);
    EXPECT_GT(h.wall.share_within, 0.9999);
  }
}

TEST(Hollow, ABoxGetsARoundedBox) {
  const double side = 16, wall = 2;
  HollowOptions options;
  for (const double r : {0.25, 1.0}) {
    options.rounding_mm = r;
    auto h = hollow(box(-8, 8), options);
    ASSERT_TRUE(h) << h.error().message();
    // A cube of side a with edges and corners rounded by r, by Steiner's formula for the inner cube of side b.
    const double b = side - 2 * wall - 2 * r;
    const double cavity = b * b * b + 6 * b * b * r + 3 * std::numbers::pi * b * r * r + ballVolume(r);
    EXPECT_NEAR((h->solid_mm3 - h->resin_mm3) / cavity, 1, 0.005) << r;
    EXPECT_NEAR(h->wall.least_mm, wall, 1e-4);
    // No place of a rounded corner is farther than (sqrt 3 - 1) r from the sharp one.
    for (std::size_t t = 0; t < h->mesh.triangles.size(); ++t)
      if (h->is_inner[t]) {
        const Vec3d p = h->mesh.corner(t, 0);
        ASSERT_LT(p.cwiseAbs().maxCoeff(), side / 2 - wall + 1e-4);
        ASSERT_LT(p.norm(), std::sqrt(3.0) * (side / 2 - wall) - 0.5 * (std::sqrt(3.0) - 1) * r);
      }
  }
}

TEST(Hollow, TwoPiecesInOneMeshGetACavityEach) {
  const Hollowed h = hollowOf(both(ballMesh({0, 0, 0}, 7, 60), ballMesh({15, 1, 0}, 6, 60)));
  EXPECT_EQ(h.cavities, 2u);
  EXPECT_NEAR((h.solid_mm3 - h.resin_mm3) / (ballVolume(5) + ballVolume(4)), 1, 0.008);
}

TEST(Hollow, AWallLiesAroundACavityOfTheSourceToo) {
  // The source's cavity touches the middle of the wall of a long box: the new cavity goes around it, and is open to one
  // side.
  Mesh solid = box({0, 0, 0}, {24, 12, 10});
  append(solid, ballMesh({12.1, 2, 5.1}, 1, 24, true));
  const Hollowed h = hollowOf(solid);
  EXPECT_EQ(h.cavities, 1u);
  EXPECT_EQ(h.shells_swallowed, 0u);
  for (std::size_t t = 0; t < h.mesh.triangles.size(); ++t)
    if (h.is_inner[t]) {
      ASSERT_GE((h.mesh.corner(t, 0) - Vec3d(12.1, 2, 5.1)).norm(), 1 + 2 - 0.03);
    }
}

TEST(Hollow, ACavityOfTheSourceInTheMiddleIsSwallowed) {
  // Its wall would float in the new cavity.
  Mesh solid = ballMesh({0, 0, 0}, 10, 60);
  append(solid, ballMesh({0, 0, 0}, 3, 30, true));
  const HollowOptions options;
  const auto h = hollow(solid, options);
  ASSERT_TRUE(h) << h.error().message();
  EXPECT_EQ(h->shells_swallowed, 1u);
  EXPECT_EQ(h->cavities, 1u);
  EXPECT_NEAR(h->resin_mm3 / (ballVolume(10) - ballVolume(8)), 1, 0.01);
  const MeshReport report = checkMesh(h->mesh);
  EXPECT_TRUE(report.print_ready);
  EXPECT_EQ(report.pieces, 1u);
  EXPECT_EQ(report.cavities, 1u);
}

TEST(Hollow, SmallCavitiesAreDroppedAndCounted) {
  HollowOptions options;
  options.least_cavity_mm3 = 60;  // a ball of radius 2.43
  const auto h = hollow(both(ballMesh({0, 0, 0}, 6, 60), ballMesh({15, 0, 0}, 4, 60)), options);
  ASSERT_TRUE(h) << h.error().message();
  EXPECT_EQ(h->cavities, 1u);
  EXPECT_EQ(h->cavities_dropped, 1u);
  EXPECT_NEAR(h->dropped_mm3, ballVolume(2), 1);
}

TEST(Hollow, ASolidThatIsTooThinIsRefusedWithAWallThatFits) {
  const Mesh thin = ballMesh({5, 6, 7}, 3.5, 30);
  HollowOptions options;
  const auto h = hollow(thin, options);
  ASSERT_FALSE(h);
  EXPECT_EQ(h.error().code, Error::Code::kEmpty);
  const auto at = h.error().hint.find("a wall of ");
  ASSERT_NE(at, std::string::npos) << h.error().message();
  options.wall_mm = std::atof(h.error().hint.c_str() + at + 10);
  const auto fits = hollow(thin, options);
  EXPECT_TRUE(fits) << options.wall_mm << " mm: " << fits.error().message();
  EXPECT_GT(options.wall_mm, 1);

  options.wall_mm = 2;
  const auto plate = hollow(box({0, 0, 0}, {12, 12, 2.2}), options);
  ASSERT_FALSE(plate);
  EXPECT_EQ(plate.error().code, Error::Code::kEmpty);
  EXPECT_EQ(plate.error().hint, "print it solid");
  EXPECT_NE(plate.error().found.find(" mm below the surface"), std::string::npos) << plate.error().message();
}

TEST(Hollow, BadSolidsAndOptionsAreRefused) {
  const Mesh ball = ballMesh({0, 0, 0}, 6, 30);
  const auto codeOf = [&](const Mesh& mesh, auto change) {
    HollowOptions options;
    change(options);
    const auto h = hollow(mesh, options);
    EXPECT_FALSE(h);
    return h ? Error::Code::kNotFound : h.error().code;
  };
  const auto same = [](HollowOptions&) {};
  Mesh open = ball;
  open.triangles.pop_back();
  EXPECT_EQ(codeOf(open, same), Error::Code::kGeometry);
  EXPECT_EQ(codeOf({}, same), Error::Code::kGeometry);
  EXPECT_EQ(codeOf(flipped(ball), same), Error::Code::kGeometry);
  EXPECT_EQ(codeOf(both(ball, ballMesh({7, 0, 0}, 6, 30)), same), Error::Code::kGeometry) << "two that cross";
  for (const double bad : {std::nan(""), -1.0, 1e9}) {
    EXPECT_EQ(codeOf(ball, [&](HollowOptions& o) { o.wall_mm = bad; }), Error::Code::kBadValue);
    EXPECT_EQ(codeOf(ball, [&](HollowOptions& o) { o.rounding_mm = bad; }), Error::Code::kBadValue);
    EXPECT_EQ(codeOf(ball, [&](HollowOptions& o) { o.voxel_mm = bad; }), Error::Code::kBadValue);
  }
  EXPECT_EQ(codeOf(ball, [](HollowOptions& o) { o.voxel_mm = 0.7; }), Error::Code::kBadValue) << "a third of the wall";
}

TEST(Hollow, TooLittleMemoryIsToldWithAVoxelThatFits) {
  const Mesh ball = ballMesh({0, 0, 0}, 6, 40);
  HollowOptions options;
  options.voxel_mm = 0.08;
  options.max_bytes = estimateHollowBytes(ball, options) / 3;
  const auto h = hollow(ball, options);
  ASSERT_FALSE(h);
  EXPECT_EQ(h.error().code, Error::Code::kBadValue);
  const auto at = h.error().hint.find("a voxel of ");
  ASSERT_NE(at, std::string::npos) << h.error().message();
  options.voxel_mm = std::atof(h.error().hint.c_str() + at + 11);
  EXPECT_GT(options.voxel_mm, 0.08);
  EXPECT_TRUE(hollow(ball, options));
}

TEST(Hollow, TheSameOnOneThreadAndOnTwo) {
  const Mesh solid = both(ballMesh({0, 0, 0}, 7, 60), box({9, 0, 0}, {20, 12, 11}));
  std::vector<Mesh> made;
  for (const std::size_t threads : {1u, 2u, 2u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto h = hollow(solid, {});
    ASSERT_TRUE(h) << h.error().message();
    made.push_back(h->mesh);
  }
  for (const Mesh& m : made) {
    EXPECT_EQ(m.vertices, made.front().vertices);
    EXPECT_EQ(m.triangles, made.front().triangles);
  }
}

TEST(Hollow, IsCancelledAtEveryStep) {
  const Mesh ball = ballMesh({0, 0, 0}, 6, 30);
  std::size_t steps = 0;
  ASSERT_TRUE(hollow(ball, {}, [&](double, std::string_view) { return ++steps > 0; }));
  EXPECT_GE(steps, 5u);
  for (std::size_t stop = 1; stop <= 5; ++stop) {
    std::size_t n = 0;
    const auto h = hollow(ball, {}, [&](double, std::string_view) { return ++n < stop; });
    ASSERT_FALSE(h) << stop;
    EXPECT_EQ(h.error().code, Error::Code::kCancelled);
  }
}

TEST(Hollow, ColoursOfTheSourceStay) {
  Mesh ball = ballMesh({0, 0, 0}, 6, 30);
  ball.face_colors.assign(ball.triangles.size(), Rgba8{1, 2, 3, 255});
  const Hollowed h = hollowOf(ball);
  ASSERT_EQ(h.mesh.face_colors.size(), h.mesh.triangles.size());
  EXPECT_EQ(h.mesh.face_colors.front(), ball.face_colors.front());
  EXPECT_EQ(h.mesh.face_colors.back(), HollowOptions{}.inner_color);
}

TEST(Hollow, ARealToothOfTheDataIsHollowed) {
  const char* given = std::getenv("KERF_DATA");
  const auto path =
      (given ? std::filesystem::path(given) : std::filesystem::path(kSourceFolder) / ".." / "shared" / "data") /
      "tooth-19-molar-crown-root.stl";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no data: " << path << " (set KERF_DATA)";
  const auto file = readMesh(path);
  ASSERT_TRUE(file) << file.error().message();
  const Hollowed h = hollowOf(file->mesh);
  EXPECT_EQ(h.cavities, 1u);
  EXPECT_LT(h.resin_mm3, 0.9 * h.solid_mm3);
}

}  // namespace
}  // namespace kerf::hollow_test
