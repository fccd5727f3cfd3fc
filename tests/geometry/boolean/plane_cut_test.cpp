#include "geometry/boolean/plane_cut.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "geometry/mesh/crossing_pairs.h"
#include "geometry/mesh/mesh_check.h"
#include "tests/geometry/ball_mesh.h"

namespace kerf::plane_cut_test {
namespace {

constexpr double kRadius = 3.0;

void expectPrintable(const PostOpMesh& part) {
  const MeshReport report = checkMesh(part.mesh);
  EXPECT_TRUE(report.print_ready) << (report.reasons.empty() ? "" : report.reasons.front());
  EXPECT_TRUE(crossingPairs(part.mesh).empty());
  for (const Vec3d& p : part.mesh.vertices) ASSERT_EQ(p, Vec3d(p.cast<float>().cast<double>()));
}

// Triangles on one side, well away from the plane, in the order of the source.
void expectKept(const Mesh& source, const Plane& plane, double side, const PostOpMesh& part) {
  std::size_t at = 0, expected = 0;
  for (const Vec3d& p : source.vertices) {
    if (side * plane.height(p) < 1e-3) continue;
    ++expected;
    while (at < part.mesh.vertices.size() && part.mesh.vertices[at] != p) ++at;
    ASSERT_LT(at, part.mesh.vertices.size()) << "a vertex that is not cut is missing or out of order";
    EXPECT_TRUE(part.is_source[at]);
  }
  EXPECT_GT(expected, 100u);
}

TEST(PlaneCut, BothSidesAreClosedFlatAndKeepWhatIsNotCut) {
  const Mesh ball = ballMesh(Vec3d::Zero(), kRadius, 48);
  const Plane plane{{0.1, -0.2, 0.7}, Vec3d(0.3, 0.2, 1).normalized()};
  const auto cut = cutByPlanes(ball, {&plane, 1});
  ASSERT_TRUE(cut) << cut.error().message();
  expectPrintable(cut->above);
  expectPrintable(cut->rest);
  expectKept(ball, plane, 1, cut->above);
  expectKept(ball, plane, -1, cut->rest);
  EXPECT_LT(cut->flatness_mm, 1.5e-3);  // the clean-up moves new vertices by about a micrometre
  const double above = cut->above.report.result_volume_mm3, below = cut->rest.report.result_volume_mm3;
  EXPECT_NEAR(above + below, signedVolume(ball), 1e-4);

  // A cap of height h: pi h^2 (3 r - h) / 3. The ball's facets lose 0.3 %.
  const double h = kRadius - plane.normal.dot(plane.point);
  EXPECT_NEAR(above / (std::numbers::pi * h * h * (3 * kRadius - h) / 3), 1, 0.01);
}

TEST(PlaneCut, RandomPlanesOfAnyTiltAreAllCut) {
  const Mesh ball = ballMesh({12, -7, 31}, kRadius, 40);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int n = 0; n < 40; ++n) {
    const Plane plane{Vec3d(12, -7, 31) + 1.8 * Vec3d(any(random), any(random), any(random)),
                      Vec3d(any(random), any(random), any(random)).normalized()};
    const auto cut = cutByPlanes(ball, {&plane, 1});
    ASSERT_TRUE(cut) << n << ": " << cut.error().message();
    expectPrintable(cut->above);
    expectPrintable(cut->rest);
    EXPECT_NEAR(cut->above.report.result_volume_mm3 + cut->rest.report.result_volume_mm3, signedVolume(ball), 1e-3);
    EXPECT_LE(cut->shift_mm, 0.0006);
  }
}

TEST(PlaneCut, APlaneThroughVerticesAndEdgesIsCut) {
  const Mesh ball = ballMesh(Vec3d::Zero(), kRadius, 48);
  for (int axis = 0; axis < 3; ++axis) {
    const Plane plane{Vec3d::Zero(), Vec3d::Unit(axis)};
    const auto cut = cutByPlanes(ball, {&plane, 1});
    ASSERT_TRUE(cut) << axis << ": " << cut.error().message();
    expectPrintable(cut->above);
    expectPrintable(cut->rest);
    EXPECT_NEAR(cut->above.report.result_volume_mm3, 0.5 * signedVolume(ball), 0.02);
  }
}

TEST(PlaneCut, APlaneInAFaceOfABoxIsRefusedOrCutsNothingOff) {
  Mesh box;
  Box3 corners;
  corners.add(Vec3d::Zero());
  corners.add(Vec3d(4, 4, 4));
  for (int n = 0; n < 8; ++n) box.vertices.push_back(corners.corner(n));
  for (const auto& f : std::vector<std::array<std::uint32_t, 4>>{
           {0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}) {
    box.triangles.push_back({f[0], f[1], f[2]});
    box.triangles.push_back({f[0], f[2], f[3]});
  }
  const Plane base{Vec3d::Zero(), Vec3d::UnitZ()}, top{Vec3d(0, 0, 4), Vec3d::UnitZ()};
  for (const Plane& plane : {base, top}) {
    const auto cut = cutByPlanes(box, {&plane, 1});
    ASSERT_FALSE(cut);
    EXPECT_EQ(cut.error().code, Error::Code::kEmpty);
  }
  // A ball cut exactly along its middle.
  const Plane middle{Vec3d(0, 0, 2), Vec3d::UnitZ()};
  const auto halves = cutByPlanes(box, {&middle, 1});
  ASSERT_TRUE(halves) << halves.error().message();
  EXPECT_NEAR(halves->above.report.result_volume_mm3, 32, 1e-4);
  EXPECT_NEAR(halves->rest.report.result_volume_mm3, 32, 1e-4);
}

TEST(PlaneCut, WhatLiesNowhereNearIsRefusedWithTheHeights) {
  const Mesh ball = ballMesh(Vec3d::Zero(), kRadius, 24);
  const Plane high{{0, 0, 5}, Vec3d::UnitZ()}, low{{0, 0, -5}, Vec3d::UnitZ()};
  for (const Plane& plane : {high, low}) {
    const auto cut = cutByPlanes(ball, {&plane, 1});
    ASSERT_FALSE(cut);
    EXPECT_EQ(cut.error().code, Error::Code::kEmpty);
    EXPECT_NE(cut.error().expected.find("above plane 1"), std::string::npos) << cut.error().message();
  }
  const Plane none{Vec3d::Zero(), Vec3d::Zero()};
  EXPECT_EQ(cutByPlanes(ball, {&none, 1}).error().code, Error::Code::kBadValue);
  EXPECT_EQ(cutByPlanes(ball, {}).error().code, Error::Code::kBadValue);
  const std::array<Plane, 2> apart{Plane{{0, 0, 1}, Vec3d::UnitZ()}, Plane{{0, 0, -1}, -Vec3d::UnitZ()}};
  EXPECT_FALSE(cutByPlanes(ball, apart));
}

TEST(PlaneCut, TwoPlanesCutADieAndThePieceThatIsMeantAlone) {
  // Two teeth of an arch. The planes pass through both.
  Mesh arch = ballMesh(Vec3d::Zero(), kRadius, 40);
  append(arch, ballMesh({20, 0, 0}, kRadius, 40));
  const std::array<Plane, 2> planes{Plane{{0, -1, 0}, Vec3d::UnitY()}, Plane{{0, 1.5, 0}, -Vec3d::UnitY()}};

  const auto both = cutByPlanes(arch, planes);
  ASSERT_TRUE(both) << both.error().message();
  EXPECT_EQ(both->above.report.pieces, 2u);
  EXPECT_EQ(both->rest.report.pieces, 4u);

  const auto one = cutByPlanes(arch, planes, {.piece_at = Vec3d(19, 0, 0), .post_op = {}});
  ASSERT_TRUE(one) << one.error().message();
  EXPECT_EQ(one->above.report.pieces, 1u);
  EXPECT_EQ(one->rest.report.pieces, 3u);
  EXPECT_GT(bounds(one->above.mesh).min[0], 16);
  expectPrintable(one->above);
  expectPrintable(one->rest);
  EXPECT_NEAR(one->above.report.result_volume_mm3, 0.5 * both->above.report.result_volume_mm3, 1e-3);
  EXPECT_NEAR(one->above.report.result_volume_mm3 + one->rest.report.result_volume_mm3, signedVolume(arch), 1e-3);
}

TEST(PlaneCut, APieceIsMeantWithItsCavitiesAndWithoutWhatIsLooseInThem) {
  Mesh cavity = ballMesh(Vec3d::Zero(), 0.7 * kRadius, 24);
  for (Triangle& f : cavity.triangles) std::swap(f[1], f[2]);
  Mesh model = ballMesh(Vec3d::Zero(), kRadius, 40);
  append(model, cavity);
  append(model, ballMesh({20, 0, 0}, kRadius, 40));
  const std::array<Plane, 2> planes{Plane{{0, -1, 0}, Vec3d::UnitY()}, Plane{{0, 1.5, 0}, -Vec3d::UnitY()}};
  const PlaneCutOptions meant{.piece_at = Vec3d(0.65 * kRadius, 0, 0), .post_op = {}};  // nearest to the cavity's wall

  const auto one = cutByPlanes(model, planes, meant);
  ASSERT_TRUE(one) << one.error().message();
  EXPECT_EQ(one->above.report.pieces, 1u);
  EXPECT_LT(bounds(one->above.mesh).max[0], 10);

  append(model, ballMesh(Vec3d::Zero(), 0.3 * kRadius, 12));
  const auto loose = cutByPlanes(model, planes, {.piece_at = Vec3d(0.98 * kRadius, 0, 0), .post_op = {}});
  ASSERT_FALSE(loose) << "what is loose in the cavity would go with it";
  EXPECT_NE(loose.error().found.find("another piece"), std::string::npos);
}

TEST(PlaneCut, ColoursStayAndCutFacesHaveTheirOwn) {
  Mesh ball = ballMesh(Vec3d::Zero(), kRadius, 24);
  for (std::size_t t = 0; t < ball.triangles.size(); ++t)
    ball.face_colors.push_back({static_cast<std::uint8_t>(t % 200), 7, 9, 255});
  const Plane plane{{0, 0, 0.4}, Vec3d(0.1, 0, 1).normalized()};
  const auto cut = cutByPlanes(ball, {&plane, 1});
  ASSERT_TRUE(cut) << cut.error().message();
  for (const PostOpMesh* part : {&cut->above, &cut->rest}) {
    ASSERT_EQ(part->mesh.face_colors.size(), part->mesh.triangles.size());
    std::size_t cut_faces = 0;
    for (std::size_t t = 0; t < part->is_cut.size(); ++t) {
      cut_faces += part->is_cut[t] != 0;
      EXPECT_EQ(part->mesh.face_colors[t][1], part->is_cut[t] ? PostOpOptions{}.cut_color[1] : 7);
    }
    EXPECT_GT(cut_faces, 10u);
  }
}

TEST(RoundHole, IsAPrismInTheSolidAndBesideItNothing) {
  const Mesh ball = ballMesh({12, -7, 31}, kRadius, 40);
  const RoundHole hole{{12.1, -7.2, 27}, Vec3d(0.05, 0.02, 1).normalized(), 1.6, 4};
  const auto drilled = withHole(ball, hole);
  ASSERT_TRUE(drilled) << drilled.error().message();
  ASSERT_TRUE(*drilled);
  expectPrintable(**drilled);
  EXPECT_EQ((*drilled)->report.cavities, 0u);
  for (std::size_t v = 0; v < (*drilled)->mesh.vertices.size(); ++v)
    EXPECT_GT(hole.outside((*drilled)->mesh.vertices[v]), -2e-3);
  // About 3 mm of its length lie in the ball.
  const double gone = signedVolume(ball) - signedVolume((*drilled)->mesh);
  EXPECT_NEAR(gone, std::numbers::pi * 0.8 * 0.8 * 2.9, 0.3);

  const auto again = withHole(ball, hole);
  EXPECT_EQ((*again)->mesh.vertices, (*drilled)->mesh.vertices);
  const auto beside = withHole(ball, {{20, 0, 0}, Vec3d::UnitZ(), 2, 5});
  ASSERT_TRUE(beside);
  EXPECT_FALSE(*beside);
  const auto inner = withHole(ball, {{12, -7, 30}, Vec3d::UnitX(), 1, 1});
  ASSERT_TRUE(inner && *inner);
  EXPECT_EQ((**inner).report.cavities, 1u);
}

TEST(RoundHole, OutsideIsTheDistanceAndGrowsOutwards) {
  const RoundHole hole{{1, 2, 3}, Vec3d::UnitZ(), 2, 4};
  EXPECT_DOUBLE_EQ(hole.outside({1, 2, 5}), -1);
  EXPECT_DOUBLE_EQ(hole.outside({4, 2, 5}), 2);
  EXPECT_DOUBLE_EQ(hole.outside({1, 2, 9}), 2);
  EXPECT_DOUBLE_EQ(hole.outside({5, 2, 10}), std::hypot(3, 3));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-3, 3);
  for (int n = 0; n < 200; ++n) {
    const Vec3d p = Vec3d(1, 2, 5) + Vec3d(any(random), any(random), any(random));
    const double at = hole.outside(p), step = 1e-4;
    if (at > 0) continue;
    EXPECT_NEAR(hole.outside(p + step * hole.outwards(p)), at + step, 1e-9) << p.transpose();
  }
}

}  // namespace
}  // namespace kerf::plane_cut_test
