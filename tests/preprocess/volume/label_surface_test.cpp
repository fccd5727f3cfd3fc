#include "preprocess/volume/label_surface.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstdlib>
#include <map>
#include <random>

#include "preprocess/close/close.h"
#include "tests/support/places.h"

namespace kerf::label_surface_test {
namespace {

// A volume of 0.5 mm voxels about the origin, with the labels at the voxel centres.
template <class LabelOf>
LabelVolume digitise(int side, LabelOf&& label_of, const Vec3d& spacing = Vec3d::Constant(0.5)) {
  LabelVolume v;
  v.size = {side, side, side};
  v.spacing = spacing;
  v.origin = -0.5 * (side - 1) * spacing;
  for (int k = 0; k < side; ++k) {
    std::vector<std::uint16_t> slice;
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i) slice.push_back(static_cast<std::uint16_t>(label_of(v.toWorld(Vec3d(i, j, k)))));
    v.addSlice(slice);
  }
  return v;
}

SmoothLabels smoothed(const LabelVolume& v, std::vector<std::uint16_t> labels, const SmoothLabelOptions& o = {}) {
  auto s = SmoothLabels::create(v, labels, o);
  if (!s) throw std::runtime_error(s.error().message());
  return std::move(*s);
}

Mesh surfaceOf(const SmoothLabels& s) {
  auto m = s.surface();
  if (!m) throw std::runtime_error(m.error().message());
  return std::move(*m);
}

void expectClosedManifold(const Mesh& m) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
  for (const Triangle& t : m.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++directed[{t[k], t[(k + 1) % 3]}];
  for (const auto& [edge, count] : directed) {
    ASSERT_EQ(count, 1);
    ASSERT_TRUE(directed.count({edge.second, edge.first}));
  }
  EXPECT_GT(signedVolume(m), 0);
}

// Area-weighted root mean squares: distance of the triangles' centres to the true surface, mm, and angle to its normal.
struct Deviation {
  double distance = 0, angle = 0;
};
template <class Distance, class Normal, class Counts>
Deviation deviation(const Mesh& m, Distance&& distance, Normal&& normal, Counts&& counts) {
  Deviation d;
  double area = 0;
  for (std::size_t t = 0; t < m.triangles.size(); ++t) {
    const Vec3d c = (m.corner(t, 0) + m.corner(t, 1) + m.corner(t, 2)) / 3, n = doubleAreaVector(m, t);
    if (!counts(c)) continue;
    const double a = n.norm(), angle = std::acos(std::clamp(n.normalized().dot(normal(c)), -1.0, 1.0));
    d.distance += a * std::pow(distance(c), 2);
    d.angle += a * angle * angle;
    area += a;
  }
  return {std::sqrt(d.distance / area), std::sqrt(d.angle / area)};
}

SmoothLabelOptions unsmoothed() {
  SmoothLabelOptions o;
  o.smoothing_voxels = 0;  // walls half-way between voxels: marching cubes' own staircase
  return o;
}

// A digitised wall is known to h / sqrt(12) = 0.144 mm at h = 0.5 mm; averaging over the blur's footprint of some
// 4 pi sigma^2 = 8 voxels of wall leaves 0.144 / sqrt(8) = 0.05 mm. The staircase's normals are off by about 0.3 rad.
TEST(SmoothLabels, SphereIsSmoothToAFractionOfAVoxel) {
  const double r = 5.13;
  const LabelVolume v = digitise(32, [&](const Vec3d& p) { return (p - Vec3d(0.11, 0.07, 0.03)).norm() < r; });
  const auto measure = [&](const SmoothLabelOptions& o) {
    const Mesh m = surfaceOf(smoothed(v, {1}, o));
    expectClosedManifold(m);
    const Vec3d c(0.11, 0.07, 0.03);
    return deviation(
        m, [&](const Vec3d& p) { return (p - c).norm() - r; }, [&](const Vec3d& p) { return (p - c).normalized(); },
        [](const Vec3d&) { return true; });
  };
  const Deviation stairs = measure(unsmoothed()), smooth = measure({});
  fmt::print("sphere: distance {:.4f} -> {:.4f} mm, normal {:.3f} -> {:.3f} rad\n", stairs.distance, smooth.distance,
             stairs.angle, smooth.angle);
  EXPECT_LT(smooth.distance, 0.05);
  EXPECT_LT(smooth.angle, 0.15);
  EXPECT_LT(1.5 * smooth.distance, stairs.distance);
  EXPECT_LT(2 * smooth.angle, stairs.angle);
}

TEST(SmoothLabels, TiltedPlaneIsSmoothToAFractionOfAVoxel) {
  const Vec3d n = Vec3d(0.31, 0.17, 1).normalized();
  const LabelVolume v = digitise(32, [&](const Vec3d& p) { return n.dot(p) < 0.123; });
  const auto measure = [&](const SmoothLabelOptions& o) {
    const Mesh m = surfaceOf(smoothed(v, {1}, o));
    expectClosedManifold(m);  // the half-space ends at the border of the volume
    return deviation(
        m, [&](const Vec3d& p) { return n.dot(p) - 0.123; }, [&](const Vec3d&) { return n; },
        [](const Vec3d& p) { return p.cwiseAbs().maxCoeff() < 5; });
  };
  const Deviation stairs = measure(unsmoothed()), smooth = measure({});
  fmt::print("plane: distance {:.4f} -> {:.4f} mm, normal {:.3f} -> {:.3f} rad\n", stairs.distance, smooth.distance,
             stairs.angle, smooth.angle);
  EXPECT_LT(smooth.distance, 0.05);
  EXPECT_LT(smooth.angle, 0.15);
  EXPECT_LT(1.5 * smooth.distance, stairs.distance);
  EXPECT_LT(2 * smooth.angle, stairs.angle);
}

// Two tissues in contact and a canal of 1.2 mm through one of them.
int jaw(const Vec3d& p) {
  if ((p - Vec3d(0, 0, 4)).norm() < 3) return 3;
  if (std::hypot(p.y(), p.z() + 2) < 0.6 && std::abs(p.x()) < 6) return 5;
  return std::abs(p.x()) < 6 && std::abs(p.y()) < 4 && std::abs(p.z()) < 4 ? 2 : 0;
}

TEST(SmoothLabels, EveryLabelKeepsItsVolume) {
  const SmoothLabels s = smoothed(digitise(40, jaw), {2, 3, 5});
  ASSERT_EQ(s.reports().size(), 3u);
  double sum = 0;
  for (const LabelVolumeReport& r : s.reports()) {
    // The canal has 96 voxels: half a voxel of length at either end is 4 %.
    EXPECT_NEAR(r.smoothed_mm3, r.counted_mm3, (r.label == 5 ? 0.05 : 0.005) * r.counted_mm3) << r.label;
    EXPECT_EQ(r.pieces, 1u) << r.label;
    EXPECT_EQ(r.pieces_now, 1u) << r.label;
    sum += r.counted_mm3;
  }
  const Mesh m = surfaceOf(s);
  expectClosedManifold(m);
  EXPECT_NEAR(signedVolume(m), sum, 0.01 * sum);
}

TEST(SmoothLabels, LabelAtTellsTissueAndRest) {
  const SmoothLabels s = smoothed(digitise(40, jaw), {2, 3, 5});
  EXPECT_EQ(s.labelAt({0, 0, 5}), 3);
  EXPECT_EQ(s.labelAt({1, 0, -2}), 5);
  EXPECT_EQ(s.labelAt({4, 2, 0}), 2);
  EXPECT_EQ(s.labelAt({5.8, 0, 0}), 2);
  EXPECT_EQ(s.labelAt({6.2, 0, 0}), 0) << "just outside, where the blur still reaches";
  EXPECT_EQ(s.labelAt({9, 9, 9}), 0);
  EXPECT_EQ(s.labelAt({1e9, 0, 0}), 0);
  EXPECT_EQ(s.labelAt(Vec3d::Constant(std::nan(""))), 0);
  const SmoothLabels without = smoothed(digitise(40, jaw), {2, 3});
  EXPECT_EQ(without.labelAt({1, 0, -2}), 0) << "the canal was not asked for";
  EXPECT_EQ(without.labelAt({1, 0, -0.9}), 2);
}

TEST(SmoothLabels, OneVoxelWallsAndCanalsSurvive) {
  const LabelVolume v = digitise(32, [](const Vec3d& p) {
    const bool inside = p.cwiseAbs().maxCoeff() < 6;
    if (inside && std::abs(p.x() - 0.25) < 0.2) return 1;                                  // a sheet
    if (inside && std::abs(p.y() - 0.25) < 0.2 && std::abs(p.z() - 0.25) < 0.2) return 2;  // a line through it
    return inside && p.x() > 3 ? 1 : 0;
  });
  const SmoothLabels s = smoothed(v, {1, 2});
  for (const LabelVolumeReport& r : s.reports()) {
    EXPECT_EQ(r.pieces_now, r.pieces) << r.label;
    EXPECT_NEAR(r.smoothed_mm3, r.counted_mm3, 0.01 * r.counted_mm3) << r.label;
  }
  EXPECT_EQ(s.labelAt({0.25, 3.25, 3.25}), 1);
  EXPECT_EQ(s.labelAt({-3.25, 0.25, 0.25}), 2);
}

TEST(SmoothLabels, WhatIsThinKeepsItsVolumeInTheMeshToo) {
  // Threads of a voxel in all directions: chords remove a part of each.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-8, 8), turn(-1, 1);
  std::vector<std::pair<Vec3d, Vec3d>> threads;
  for (int n = 0; n < 60; ++n)
    threads.emplace_back(Vec3d(place(random), place(random), place(random)),
                         Vec3d(turn(random), turn(random), turn(random)).normalized());
  const LabelVolume v = digitise(40, [&](const Vec3d& p) {
    for (const auto& [through, along] : threads)
      if (p.norm() < 8 && (p - through).cross(along).norm() < 0.35) return 1;
    return 0;
  });
  const SmoothLabels s = smoothed(v, {1});
  const double counted = s.reports()[0].counted_mm3;
  fmt::print("threads: mesh {:.1f} mm3 of {:.1f}\n", signedVolume(surfaceOf(s)), counted);
  EXPECT_NEAR(signedVolume(surfaceOf(s)), counted, 0.005 * counted);
}

TEST(SmoothLabels, SurfaceTurnsWithTheVolumeAndStaysOutwardWhenMirrored) {
  LabelVolume v = digitise(40, jaw);
  const Mesh plain = surfaceOf(smoothed(v, {2, 3, 5}));
  for (const double sign : {1.0, -1.0}) {
    Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()).toRotationMatrix();
    turn.col(0) *= sign;
    LabelVolume turned = v;
    turned.direction = turn;
    turned.origin = turn * v.origin + Vec3d(10, 20, 30);
    const Mesh m = surfaceOf(smoothed(turned, {2, 3, 5}));
    ASSERT_EQ(m.vertices.size(), plain.vertices.size());
    for (std::size_t i = 0; i < m.vertices.size(); ++i)  // float32 at 40 mm: 2e-6 mm
      ASSERT_LT((turn * plain.vertices[i] + Vec3d(10, 20, 30) - m.vertices[i]).norm(), 1e-5);
    EXPECT_NEAR(signedVolume(m), signedVolume(plain), 1e-3);
    EXPECT_EQ(smoothed(turned, {2, 3, 5}).labelAt(turn * Vec3d(0, 0, 5) + Vec3d(10, 20, 30)), 3);
  }
}

TEST(SmoothLabels, AnisotropicVoxelsKeepTheirVolume) {
  const LabelVolume v = digitise(
      48, [](const Vec3d& p) { return p.norm() < 4; }, Vec3d(0.25, 0.3, 1));
  SmoothLabelOptions o;
  o.smoothing_mm = 0.6;
  for (const SmoothLabelOptions& options : {SmoothLabelOptions{}, o}) {
    const Mesh m = surfaceOf(smoothed(v, {1}, options));
    expectClosedManifold(m);
    EXPECT_NEAR(signedVolume(m), 4.0 / 3 * std::acos(-1.0) * 64, 0.02 * 268);
  }
}

TEST(SmoothLabels, SurfacePassesClosingUntouched) {
  const Mesh m = surfaceOf(smoothed(digitise(40, jaw), {2, 3, 5}));
  const auto closed = closeMesh(m);
  ASSERT_TRUE(closed) << closed.error().message();
  EXPECT_EQ(closed->report.triangles_kept, m.triangles.size());
  EXPECT_EQ(closed->mesh.triangles.size(), m.triangles.size());
  EXPECT_EQ(closed->report.vertices_rounded, 0u);
  EXPECT_EQ(closed->report.crossings_resolved, 0u);
}

TEST(SmoothLabels, NoiseGivesAClosedManifoldThatDoesNotCrossItself) {
  std::uint32_t state = 20261121;
  const LabelVolume v = digitise(20, [&](const Vec3d&) { return (state = state * 1664525u + 1013904223u) >> 30; });
  const Mesh m = surfaceOf(smoothed(v, {1, 2}));
  expectClosedManifold(m);
  CloseOptions keep_all;
  keep_all.crumb_fraction = keep_all.debris_fraction = 0;
  const auto closed = closeMesh(m, keep_all);
  ASSERT_TRUE(closed) << closed.error().message();
  EXPECT_EQ(closed->report.crossings_resolved, 0u);
}

TEST(SmoothLabels, NumberOfThreadsChangesNothing) {
  const LabelVolume v = digitise(40, jaw);
  const Mesh many = surfaceOf(smoothed(v, {2, 3, 5}));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Mesh single = surfaceOf(smoothed(v, {2, 3, 5}));
  EXPECT_EQ(many.vertices, single.vertices);
  EXPECT_EQ(many.triangles, single.triangles);
}

TEST(SmoothLabels, WrongCallsAreRefused) {
  const LabelVolume v = digitise(20, [](const Vec3d& p) { return p.norm() < 3; });
  const auto refused = [&](std::vector<std::uint16_t> labels, SmoothLabelOptions o, const std::string& words) {
    const auto s = SmoothLabels::create(v, labels, o);
    ASSERT_FALSE(s);
    EXPECT_NE(s.error().message().find(words), std::string::npos) << s.error().message();
  };
  refused({}, {}, "0 tissue labels");
  refused({0}, {}, "label 0");
  refused({1, 1}, {}, "label 1 twice");
  refused({7}, {}, "no voxel of label 7; expected labels that are in the volume: 0, 1");
  SmoothLabelOptions o;
  o.smoothing_voxels = std::nan("");
  refused({1}, o, "0 to 4 voxels");
  o.smoothing_mm = 9;
  refused({1}, o, "9 mm, 18.00 voxels");
  o = {};
  o.max_bytes = 1000;
  refused({1}, o, "ask for fewer labels");
  const auto cancelled =
      SmoothLabels::create(v, std::vector<std::uint16_t>{1}, {}, [](double f, std::string_view) { return f < 0.4; });
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().code, Error::Code::kCancelled);
}

TEST(SmoothLabels, RealJawsKeepTheVolumeOfEveryLabel) {
  const char* given = std::getenv("KERF_DATA");
  const auto folder =
      given ? std::filesystem::path(given) : std::filesystem::path(kSourceFolder) / ".." / "shared" / "data";
  const auto path = folder / "cbct-jaws-teeth-labels.nii.gz";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no data: " << path << " (set KERF_DATA)";
  const auto v = readLabelVolume(path);
  ASSERT_TRUE(v) << v.error().message();
  const SmoothLabels s = smoothed(*v, {1, 2, 3, 4, 5});
  double sum = 0;
  for (const LabelVolumeReport& r : s.reports()) {
    fmt::print("label {}: {:.1f} mm3 -> {:.1f} mm3, pieces {} -> {}\n", r.label, r.counted_mm3, r.smoothed_mm3,
               r.pieces, r.pieces_now);
    EXPECT_NEAR(r.smoothed_mm3, r.counted_mm3, 0.01 * r.counted_mm3) << r.label;
    EXPECT_GE(r.pieces_now, r.pieces) << "nothing vanished";
    sum += r.counted_mm3;
  }
  const Mesh m = surfaceOf(s);
  EXPECT_NEAR(signedVolume(m), sum, 0.01 * sum);
}

}  // namespace
}  // namespace kerf::label_surface_test
