// Parts of a scan cut away before closing: whole triangles go, every other point stays.
#include "preprocess/close/scan_trim.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "preprocess/close/close.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/preprocess/solid_checks.h"

namespace kerf::scan_trim_test {
namespace {

// A sheet of 10 x 10 mm at z = 0, in squares of 1 mm of two triangles each.
Mesh sheet() {
  Mesh m;
  for (int y = 0; y <= 10; ++y)
    for (int x = 0; x <= 10; ++x) m.vertices.push_back({1.0 * x, 1.0 * y, 0});
  for (std::uint32_t y = 0; y < 10; ++y)
    for (std::uint32_t x = 0; x < 10; ++x) {
      const std::uint32_t a = 11 * y + x;
      m.triangles.push_back({a, a + 1, a + 12});
      m.triangles.push_back({a, a + 12, a + 11});
    }
  return m;
}

OutlineTrim square(double low, double high, double z = 0) {
  return {{{low, low, z}, {high, low, z}, {high, high, z}, {low, high, z}}, -Vec3d::UnitZ(), {}, false};
}

TrimmedScan trimmed(const Mesh& scan, std::vector<ScanTrim> trims, double scale = 1) {
  auto out = trimScan(scan, trims, scale);
  EXPECT_TRUE(out) << out.error().message();
  return out ? std::move(*out) : TrimmedScan{};
}

std::set<std::array<double, 3>> placesOf(const Mesh& mesh) {
  std::set<std::array<double, 3>> out;
  for (const Vec3d& p : mesh.vertices) out.insert({p[0], p[1], p[2]});
  return out;
}

TEST(ScanTrim, TrianglesInsideALassoGoAndAllOthersKeepTheirPlace) {
  const Mesh scan = sheet();
  const TrimmedScan out = trimmed(scan, {square(2.5, 6.5)});
  EXPECT_EQ(out.triangles_removed, 2u * 5 * 5) << "of the squares from 2 to 7";
  EXPECT_NEAR(out.removed_mm2, 0.5 * static_cast<double>(out.triangles_removed), 1e-12);
  EXPECT_EQ(out.mesh.triangles.size(), scan.triangles.size() - out.triangles_removed);
  EXPECT_EQ(out.vertices_removed, 4u * 4) << "the corners between 3 and 6";
  EXPECT_EQ(out.mesh.vertices.size(), scan.vertices.size() - out.vertices_removed);
  EXPECT_NEAR(surfaceArea(out.mesh) + out.removed_mm2, 100, 1e-12);
  for (std::size_t t = 0; t < out.mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) EXPECT_EQ(out.mesh.corner(t, k), scan.corner(out.source_triangle[t], k));
}

TEST(ScanTrim, ALassoCutsThroughTheWholeScanAlongTheView) {
  Mesh scan = sheet();
  Mesh below = sheet();
  for (Vec3d& p : below.vertices) p.z() = -20;
  append(scan, below);
  EXPECT_EQ(trimmed(scan, {square(2.5, 6.5, 50)}).triangles_removed, 100u) << "wherever the line lies along the view";
}

TEST(ScanTrim, InPerspectiveTheLineOfSightDecides) {
  Mesh scan = sheet();
  for (Vec3d& p : scan.vertices) p.z() = -10;
  OutlineTrim half = square(2.4, 3.1, 0);  // 10 mm before the eye; the sheet is twice as far
  half.eye = Vec3d(0, 0, 10);
  EXPECT_EQ(placesOf(trimmed(scan, {half}).mesh), placesOf(trimmed(scan, {square(4.8, 6.2)}).mesh));

  for (Vec3d& p : scan.vertices) p.z() = 30;  // behind the eye
  EXPECT_EQ(trimmed(scan, {half}).triangles_removed, 0u);
}

TEST(ScanTrim, ALassoWithinOneTriangleRemovesIt) {
  EXPECT_EQ(trimmed(sheet(), {OutlineTrim{{{4.6, 4.2, 0}, {4.7, 4.2, 0}, {4.7, 4.3, 0}}}}).triangles_removed, 1u);
}

TEST(ScanTrim, ALassoThatCrossesItselfHasNoIslands) {
  // A star of five points: its middle is encircled twice.
  OutlineTrim star;
  for (const int n : {0, 2, 4, 1, 3})
    star.outline.push_back(Vec3d(5 + 4 * std::sin(n * 0.4 * M_PI), 5 + 4 * std::cos(n * 0.4 * M_PI), 0));
  const std::set<std::array<double, 3>> left = placesOf(trimmed(sheet(), {star}).mesh);
  EXPECT_FALSE(left.contains({5, 5, 0}));
  EXPECT_TRUE(left.contains({0, 0, 0}));
}

TEST(ScanTrim, BothSidesOfACutTogetherAreTheScan) {
  const Mesh scan = sheet();
  const ScanTrim lasso = square(2.5, 6.5), plane = PlaneTrim{{3.5, 0, 0}, Vec3d::UnitX()};
  for (const auto& [trim, crossed] : {std::pair{lasso, 2u * (25 - 9)}, std::pair{plane, 2u * 10}}) {
    const TrimmedScan one = trimmed(scan, {trim}), other = trimmed(scan, {flipped(trim)});
    EXPECT_EQ(one.triangles_removed + other.triangles_removed, scan.triangles.size() + crossed);
  }
  EXPECT_NEAR(trimmed(scan, {plane}).removed_mm2, 70, 1e-12) << "all from 3 on";
}

TEST(ScanTrim, TheScaleOnlyConvertsTheUnit) {
  Mesh scan = sheet();
  for (Vec3d& p : scan.vertices) p /= 16;
  const TrimmedScan small = trimmed(scan, {square(2.5, 6.5)}, 16);
  EXPECT_EQ(small.triangles_removed, 50u);
  EXPECT_NEAR(small.removed_mm2, 25, 1e-12);
  EXPECT_EQ(placesOf(trimmed(scan, {scaledBy(square(2.5, 6.5), 1.0 / 16)}).mesh), placesOf(small.mesh));
}

TEST(ScanTrim, BadTrimsAreRefused) {
  const auto codeOf = [](const ScanTrim& trim) {
    const auto out = trimScan(sheet(), {&trim, 1});
    return out ? Error::Code::kCancelled : out.error().code;
  };
  EXPECT_EQ(codeOf(square(-1, 11)), Error::Code::kEmpty);
  EXPECT_EQ(codeOf(PlaneTrim{{0, 0, -1}, Vec3d::UnitZ()}), Error::Code::kEmpty);
  EXPECT_EQ(codeOf(PlaneTrim{{0, 0, -1}, Vec3d::Zero()}), Error::Code::kBadValue);
  EXPECT_EQ(codeOf(OutlineTrim{{{0, 0, 0}, {1, 0, 0}}}), Error::Code::kBadValue);
  OutlineTrim behind = square(2, 3);
  behind.eye = Vec3d(0, 0, -5);
  EXPECT_EQ(codeOf(behind), Error::Code::kBadValue);
}

// A bowl: the lower half of a ball, open above, cut down to a flatter one.
TEST(ScanTrim, ClosingReportsTheCutAndKeepsTheOtherPoints) {
  Mesh bowl = ballMesh({0, 0, 0}, 5, 40);
  std::erase_if(bowl.triangles, [&](const Triangle& f) {
    return std::any_of(f.begin(), f.end(), [&](std::uint32_t v) { return bowl.vertices[v].z() < 0; });
  });
  const ScanTrim trim = PlaneTrim{{0, 0, 1}, -Vec3d::UnitZ()};
  const TrimmedScan rest = trimmed(bowl, {trim});
  ASSERT_GT(rest.triangles_removed, 0u);

  CloseOptions options;
  options.trims = {trim};
  const auto solid = closeMesh(bowl, options);
  ASSERT_TRUE(solid) << solid.error().message();
  EXPECT_EQ(solid->report.triangles_cut_away, rest.triangles_removed);
  EXPECT_EQ(solid->report.vertices_cut_away, rest.vertices_removed);
  EXPECT_EQ(solid->report.cut_away_mm2, rest.removed_mm2);
  ASSERT_FALSE(solid->report.changes.empty());
  EXPECT_TRUE(solid->report.changes[0].starts_with("1 cut removed ")) << solid->report.changes[0];

  // The same solid as of the scan without that part.
  const auto of_rest = closeMesh(rest.mesh, {});
  ASSERT_TRUE(of_rest);
  EXPECT_EQ(solid->mesh.vertices, of_rest->mesh.vertices);
  EXPECT_EQ(solid->mesh.triangles, of_rest->mesh.triangles);
  for (std::size_t t = 0; t < solid->source_triangle.size(); ++t)
    if (of_rest->source_triangle[t] != kAdded)
      EXPECT_EQ(solid->source_triangle[t], rest.source_triangle[of_rest->source_triangle[t]]);
  EXPECT_NE(canonicalText(options), canonicalText({}));
}

}  // namespace
}  // namespace kerf::scan_trim_test
