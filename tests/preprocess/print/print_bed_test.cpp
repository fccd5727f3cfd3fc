// The base a model stands on, and its place on a printer's bed.
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/mesh/mesh_check.h"
#include "geometry/mesh/solids.h"
#include "preprocess/print/base_face.h"
#include "preprocess/print/print_bed.h"
#include "tests/preprocess/print/print_shapes.h"

namespace kerf::print_bed_test {
namespace {

using test::revolved;
using test::turned;
using test::turns;

// A cylinder with a dome on it: the flat face has radius r and stands at z = 0.
Mesh dome(double r, double height) {
  std::vector<Eigen::Vector2d> profile{{0, 0}, {r, 0}, {r, height}};
  for (int i = 1; i <= 20; ++i) profile.push_back({r * std::cos(M_PI / 40 * i), height + r * std::sin(M_PI / 40 * i)});
  profile.back()[0] = 0;
  return revolved(profile);
}

Mesh rounded(Mesh mesh) {
  for (Vec3d& p : mesh.vertices) p = p.cast<float>().cast<double>();
  return mesh;
}

TEST(BaseFace, TheFlatEndOfADomeIsFoundAtAnyAttitude) {
  for (const Eigen::Matrix3d& turn : turns()) {
    const auto base = findBase(rounded(turned(dome(6, 4), turn, {120, -80, 40})));
    ASSERT_TRUE(base);
    EXPECT_NEAR(base->plane.normal.dot(turn * -Vec3d::UnitZ()), 1, 1e-6);
    EXPECT_NEAR(base->area_mm2, M_PI * 36, 0.1);
    EXPECT_NEAR((base->plane.point - (turn * Vec3d(0, 0, 0) + Vec3d(120, -80, 40))).norm(), 0, 1e-3);
  }
}

TEST(BaseFace, ABallAndASmallFlatFaceAreNone) {
  std::vector<Eigen::Vector2d> ball;
  test::addArc(ball, 8, -M_PI / 2, M_PI / 2);
  EXPECT_FALSE(findBase(revolved(ball)));
  EXPECT_FALSE(findBase(dome(1.5, 1))) << "7 mm2";
  EXPECT_FALSE(findBase(Mesh{}));
}

TEST(BaseFace, AFlatFaceInADentIsNoBase) {
  // A ring foot of 1 mm around a recess: the foot carries, not the larger face above it.
  const auto base = findBase(revolved({{0, 2}, {7, 2}, {7, 0}, {8, 0}, {8, 10}, {0, 10}}));
  ASSERT_TRUE(base);
  EXPECT_NEAR(base->plane.normal[2], 1, 1e-9) << "the closed top is the largest face that carries the whole";
  EXPECT_NEAR(base->area_mm2, M_PI * 64, 0.2);
}

TEST(BaseFace, AFaceTowardsTheGivenDirectionComesFirst) {
  const Mesh cone = revolved({{0, 0}, {6, 0}, {5, 9}, {0, 9}});
  EXPECT_NEAR(findBase(cone)->plane.normal[2], -1, 1e-9) << "the larger end";
  EXPECT_NEAR(findBase(cone, {0.2, 0, 1})->plane.normal[2], 1, 1e-9);
  EXPECT_NEAR(findBase(cone, Vec3d::UnitX())->plane.normal[2], -1, 1e-9) << "no face there";
}

TEST(PrintBed, APieceLiesOnItsBaseExactlyFlat) {
  const PrintBed bed{"test", {100, 80, 50}};
  for (const Eigen::Matrix3d& turn : turns()) {
    const Mesh mesh = rounded(turned(dome(6, 4), turn, {300, 20, -7}));
    const auto laid = laidOnBed(mesh, turn * Vec3d::UnitZ(), bed);
    ASSERT_TRUE(laid) << laid.error().message();
    ASSERT_EQ(laid->pieces.size(), 1u);
    EXPECT_TRUE(laid->pieces[0].is_on_base);
    const Box3 box = bounds(laid->mesh);
    EXPECT_EQ(box.min[2], 0);
    EXPECT_NEAR(box.max[2], 10, 1e-4);
    EXPECT_NEAR(box.center()[0], 50, 1e-3);
    EXPECT_NEAR(box.center()[1], 40, 1e-3);
    std::size_t flat = 0;
    for (const Vec3d& p : laid->mesh.vertices) flat += p[2] == 0;
    EXPECT_EQ(flat, 257u) << "the rim and the middle";
    EXPECT_TRUE(checkMesh(laid->mesh).print_ready);
    EXPECT_NEAR(signedVolume(laid->mesh), signedVolume(mesh), 1e-3);
    // The reported motion is the motion.
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
      ASSERT_NEAR((laid->pieces[0].T_bed_scan * mesh.vertices[v] - laid->mesh.vertices[v]).norm(), 0, 2e-4);
  }
}

TEST(PrintBed, PiecesStandSideBySideAndKeepTheirOrder) {
  Mesh mesh = dome(6, 4);
  for (int n = 1; n < 7; ++n)
    append(mesh, turned(dome(4 + 0.5 * n, 3), turns()[static_cast<std::size_t>(n % 5)], {1.0 * n, 2.0, 50.0 * n}));
  mesh = rounded(std::move(mesh));
  const auto laid = laidOnBed(mesh, Vec3d::UnitZ(), {"test", {60, 60, 30}});
  ASSERT_TRUE(laid) << laid.error().message();
  EXPECT_EQ(laid->pieces.size(), 7u);
  EXPECT_EQ(laid->mesh.triangles, mesh.triangles);
  EXPECT_TRUE(checkMesh(laid->mesh).print_ready);
  const std::vector<Mesh> pieces = separated(laid->mesh, solidsOf(laid->mesh));
  for (std::size_t a = 0; a < pieces.size(); ++a) {
    const Box3 one = bounds(pieces[a]);
    EXPECT_EQ(one.min[2], 0);
    EXPECT_TRUE((one.min.array() >= 0).all() && one.max[0] <= 60 && one.max[1] <= 60);
    for (std::size_t b = 0; b < a; ++b) {
      const Box3 other = bounds(pieces[b]);
      const double apart =
          std::max((one.min - other.max).head<2>().maxCoeff(), (other.min - one.max).head<2>().maxCoeff());
      EXPECT_GE(apart, 3 - 1e-3);
    }
  }
}

TEST(PrintBed, ACavityStaysInItsPieceAndAPieceWithoutABaseStandsUpright) {
  std::vector<Eigen::Vector2d> outer, inner;
  test::addArc(outer, 8, -M_PI / 2, M_PI / 2);
  test::addArc(inner, 5, -M_PI / 2, M_PI / 2);
  Mesh mesh = revolved(outer), hollow = revolved(inner);
  for (Triangle& t : hollow.triangles) std::swap(t[1], t[2]);
  append(mesh, hollow);
  const auto laid = laidOnBed(rounded(std::move(mesh)), Vec3d::UnitX(), {"test", {20, 20, 20}});
  ASSERT_TRUE(laid) << laid.error().message();
  ASSERT_EQ(laid->pieces.size(), 1u);
  EXPECT_FALSE(laid->pieces[0].is_on_base);
  EXPECT_NEAR((laid->pieces[0].T_bed_scan.rotation * Vec3d::UnitX())[2], 1, 1e-9);
  EXPECT_TRUE(checkMesh(laid->mesh).print_ready);
}

TEST(PrintBed, ALongPieceLiesAlongALongBedHoweverItWasScanned) {
  for (const Vec3d& size : {Vec3d(110, 20, 12), Vec3d(20, 110, 12)})
    for (const Vec3d& bed : {Vec3d(119, 67, 75), Vec3d(67, 119, 75)}) {
      const auto laid = laidOnBed(box({0, 0, 0}, size), Vec3d::UnitZ(), {"test", bed});
      ASSERT_TRUE(laid) << laid.error().message();
      EXPECT_TRUE((bounds(laid->mesh).max.array() <= bed.array()).all());
    }
}

TEST(PrintBed, AGivenDirectionIsKept) {
  const auto laid =
      laidOnBed(box({0, 0, 0}, {20, 20, 20}), Vec3d(1, 1, 1).normalized(), {"test", {60, 60, 60}}, {}, true);
  ASSERT_TRUE(laid) << laid.error().message();
  EXPECT_FALSE(laid->pieces[0].is_on_base);
  EXPECT_NEAR(bounds(laid->mesh).size()[2], 20 * std::sqrt(3), 1e-3) << "it stands on its corner";
}

TEST(PrintBed, APieceTooLargeIsRefusedWithItsSize) {
  const auto laid = laidOnBed(dome(6, 4), Vec3d::UnitZ(), {"small", {11, 30, 30}});
  ASSERT_FALSE(laid);
  EXPECT_EQ(laid.error().code, Error::Code::kBadValue);
  EXPECT_NE(laid.error().found.find("12.0 x 12.0 x 10.0 mm"), std::string::npos) << laid.error().message();
}

TEST(PrintBed, PrintersAreFoundByNameAndBySize) {
  const auto beds = printBeds();
  ASSERT_TRUE(beds) << beds.error().message();
  for (const PrintBed& bed : *beds) {
    const auto found = printBedOf(bed.name);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->size_mm, bed.size_mm);
    EXPECT_GT(bed.size_mm.minCoeff(), 10);
  }
  EXPECT_EQ(printBedOf("form 3")->name, "Form 3");
  EXPECT_EQ(printBedOf("145.5x100x90")->size_mm, Vec3d(145.5, 100, 90));
  for (const char* wrong :
       {"", "Form", "145x145", "145x145x", "145x145x185x1", "1x1x1", "nanx1x1", "1e9x100x100", "145 x 145 x 185"})
    EXPECT_FALSE(printBedOf(wrong)) << wrong;
}

}  // namespace
}  // namespace kerf::print_bed_test
