// Every known scan defect, applied to a synthetic arch: the result is a solid, the report names the repairs, and
// vertices that need no change are kept bit for bit.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "preprocess/close/made_crumbs.h"
#include "preprocess/unit/source_triangle.h"
#include "tests/preprocess/solid_checks.h"

namespace kerf::defects_test {
namespace {

/// An open arch: half a ring of mean radius 22 mm, 9 mm wide and 8 mm high, open below, normals out.
Mesh arch(int along = 120, int across = 20) {
  Mesh m;
  for (int i = 0; i <= along; ++i)
    for (int j = 0; j <= across; ++j) {
      const double a = std::numbers::pi * i / along, b = std::numbers::pi * j / across;
      const double r = 22 - 4.5 * std::cos(b), z = 8 * std::sin(b) + 0.5 * std::pow(std::sin(b), 8) * std::cos(28 * a);
      m.vertices.push_back(roundedToFloat(Vec3d(r * std::cos(a), r * std::sin(a), z)));
    }
  const auto id = [&](int i, int j) { return static_cast<std::uint32_t>(i * (across + 1) + j); };
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < across; ++j) {
      m.triangles.push_back({id(i, j), id(i, j + 1), id(i + 1, j + 1)});
      m.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i + 1, j)});
    }
  return m;
}

/// Removes the triangles that `drop` picks by number and corners.
template <class F>
Mesh without(const Mesh& m, F&& drop) {
  std::vector<char> keep;
  for (std::size_t t = 0; t < m.triangles.size(); ++t) keep.push_back(!drop(t));
  return subset(m, keep);
}
Vec3d middle(const Mesh& m, std::size_t t) { return (m.corner(t, 0) + m.corner(t, 1) + m.corner(t, 2)) / 3; }

/// Number of vertices of `m` missing from the solid, bit for bit.
std::size_t lost(const Solid& s, const Mesh& m) {
  std::set<std::array<double, 3>> places;
  for (const Vec3d& p : s.mesh.vertices) places.insert({p.x(), p.y(), p.z()});
  std::size_t n = 0;
  for (const Vec3d& p : m.vertices) n += !places.count({p.x(), p.y(), p.z()});
  return n;
}

testing::AssertionResult says(const Solid& s, const std::string& what) {
  for (const std::string& change : s.report.changes)
    if (change.find(what) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "no change says \"" << what
                                     << "\" but: " << fmt::format("{}", fmt::join(s.report.changes, "; "));
}

TEST(Defects, NoneButTheMissingUnderside) {
  const Mesh m = arch();
  const Solid s = closed(m);
  EXPECT_EQ(lost(s, m), 0u);
  EXPECT_EQ(s.report.changes.size(), 1u);
  EXPECT_TRUE(says(s, "a rim"));
}

TEST(Defects, RaggedRim) {
  std::mt19937 random(7);
  const Mesh whole = arch();
  const Mesh m = without(whole, [&](std::size_t t) { return middle(whole, t).z() < 1.5 && random() % 2 == 0; });
  const Solid s = closed(m);
  // Islands cause most losses: 44 with straight walls. Bridges fold over a few teeth of 1 mm: 55. On real scans, with
  // smaller triangles, they save more than they cost (CloseLosses).
  EXPECT_LT(lost(s, m), m.vertices.size() / 40);
  EXPECT_LT(lost(closed(m, {.base_smoothing_mm = 0}), m), m.vertices.size() / 50);
  EXPECT_TRUE(says(s, "rim"));
}

TEST(Defects, FloatingIslands) {
  Mesh m = arch();
  const Mesh arch_only = m;
  for (int k = 0; k < 3; ++k) {
    Mesh island;
    const double x = 4.0 * k;
    island.vertices = {{x, 2, 9}, {x + 0.5, 2, 9}, {x, 2.5, 9}, {x + 0.5, 2.5, 9.2}};
    island.triangles = {{0, 1, 2}, {1, 3, 2}};
    append(m, island);
  }
  const Solid s = closed(m);
  EXPECT_EQ(s.report.crumbs_dropped, 3u);
  EXPECT_TRUE(says(s, "open crumbs were dropped"));
  EXPECT_EQ(lost(s, arch_only), 0u);
}

TEST(Defects, SpikesAndFins) {
  Mesh m = arch();
  const Mesh arch_only = m;
  // A spike: one vertex pulled through the opposite wall. A fin: a triangle standing on an inner edge.
  const std::uint32_t spike = 60 * 21 + 6;
  m.vertices[spike] = roundedToFloat(Vec3d(m.vertices[spike] + Vec3d(0, 12, 0)));
  m.vertices.push_back({0, 22, 10.5});
  const Triangle f = m.triangles[2 * (30 * 20 + 10)];
  m.triangles.push_back({f[0], f[1], static_cast<std::uint32_t>(m.vertices.size() - 1)});
  const Solid s = closed(m);
  EXPECT_TRUE(says(s, "crossed or touched"));
  EXPECT_LT(lost(s, arch_only), 10u);
}

TEST(Defects, BowTies) {
  const Mesh whole = arch();
  // Two holes that meet in one vertex.
  const std::uint32_t v = 60 * 21 + 10;
  std::size_t seen = 0;
  const Mesh m = without(whole, [&](std::size_t t) {
    const Triangle& f = whole.triangles[t];
    const bool at = f[0] == v || f[1] == v || f[2] == v;
    return at && (seen++ % 3 == 0);
  });
  ASSERT_LT(m.triangles.size(), whole.triangles.size() - 1);
  const Solid s = closed(m);
  EXPECT_EQ(lost(s, m), 0u);
  EXPECT_GE(s.report.holes_filled, 2u);
  EXPECT_TRUE(says(s, "filled"));
}

TEST(Defects, DoubleLayer) {
  const Mesh whole = arch();
  Mesh m = whole;
  Mesh patch = without(whole, [&](std::size_t t) { return middle(whole, t).z() < 4; });
  for (Vec3d& p : patch.vertices) p = roundedToFloat(Vec3d(p + Vec3d(0.01, 0.02, -0.05)));
  append(m, patch);
  const Solid s = closed(m);
  EXPECT_EQ(edgeConnectedPieces(s.mesh).count, 1u);
  EXPECT_NEAR(signedVolume(s.mesh), signedVolume(closed(whole).mesh),
              60);  // of about 3000 mm3: the layer may close itself below
}

TEST(Defects, FlippedPatch) {
  Mesh m = arch();
  for (std::size_t t = 0; t < m.triangles.size(); ++t)
    if ((middle(m, t) - Vec3d(0, 22, 8)).norm() < 4) std::swap(m.triangles[t][1], m.triangles[t][2]);
  const Solid s = closed(m);
  EXPECT_GT(s.report.triangles_flipped, 20u);
  EXPECT_TRUE(says(s, "turned to agree"));
  EXPECT_EQ(lost(s, m), 0u);
}

TEST(Defects, TwentyEightPinHoles) {
  const Mesh whole = arch();
  const Mesh m = without(whole, [&](std::size_t t) { return t % 170 == 85; });
  ASSERT_EQ(whole.triangles.size() - m.triangles.size(), 28u);
  const Solid s = closed(m);
  EXPECT_EQ(s.report.holes_filled, 28u);
  EXPECT_TRUE(says(s, "28 holes were filled"));
  EXPECT_EQ(lost(s, m), 0u);
  EXPECT_EQ(s.report.triangles_kept, m.triangles.size());
}

TEST(Defects, Unwelded) {
  const Mesh whole = arch();
  Mesh m;
  for (const Triangle& f : whole.triangles) {
    const auto n = static_cast<std::uint32_t>(m.vertices.size());
    for (const std::uint32_t v : f) m.vertices.push_back(whole.vertices[v]);
    m.triangles.push_back({n, n + 1, n + 2});
  }
  const Solid s = closed(m);
  EXPECT_TRUE(says(s, "welded"));
  EXPECT_EQ(s.report.vertices_welded, m.vertices.size() - whole.vertices.size());
  EXPECT_EQ(lost(s, m), 0u);
  EXPECT_EQ(signedVolume(s.mesh), signedVolume(closed(whole).mesh));
}

TEST(Defects, SixteenPiecesThroughEachOther) {
  Mesh m;
  for (int k = 0; k < 16; ++k) {
    Mesh crown = ball(14, 28, 4);
    const double a = std::numbers::pi * k / 15;
    for (Vec3d& p : crown.vertices)
      p = roundedToFloat(Vec3d(p + Vec3d(30 * std::cos(a), 30 * std::sin(a), 0.3 * (k % 3))));
    append(m, crown);
  }
  const Solid s = closed(m);
  EXPECT_EQ(edgeConnectedPieces(s.mesh).count, 1u);
  EXPECT_GT(s.report.crossings_resolved, 100u);
  EXPECT_TRUE(says(s, "crossed or touched"));
}

// From voxels of a CT. Closing moves them apart by less than a micrometre, which must not remove them as splinters.
TEST(Defects, SmallPiecesThatTouchStay) {
  Mesh m = box(0, 60);
  for (int k = 0; k < 20; ++k) {
    const Vec3d at(70, 4.0 * k, 0);
    append(m, box(at, at + Vec3d::Constant(1.5)));
    append(m, box(at + Vec3d(1.5, 1.5, 0), at + Vec3d(3, 3, 1.5)));  // along an edge
  }
  const Solid s = closed(m);
  EXPECT_TRUE(says(s, "were moved apart"));
  EXPECT_FALSE(says(s, "splinter"));
  EXPECT_EQ(edgeConnectedPieces(s.mesh).count, 41u);
  EXPECT_NEAR(signedVolume(s.mesh), 60 * 60 * 60 + 40 * 1.5 * 1.5 * 1.5, 0.1);
}

constexpr double kCrumb = 1.0 / 128;  // mm, a float32 number

// A cube of 4 mm with two more vertices on an edge.
Mesh cubeWithShortEdge() {
  Mesh m = box(0, 4);
  m.vertices.push_back({2, 4, 4});
  m.vertices.push_back({2 + kCrumb, 4, 4});
  m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 9}, {5, 9, 8}, {5, 8, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 8}, {3, 8, 9}, {3, 9, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return m;
}

// A tetrahedron of 8e-8 mm3 on that edge, or above it.
Mesh crumb(double above) {
  const Vec3d up(0, 0, above);
  Mesh m;
  m.vertices = {Vec3d(2, 4, 4) + up, Vec3d(2 + kCrumb, 4, 4) + up, Vec3d(2, 4 + kCrumb, 4) + up,
                Vec3d(2, 4, 4 + kCrumb) + up};
  m.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return m;
}

// In a scan it is one piece with the cube, as they share an edge. Closing separates it.
TEST(Defects, ACrumbThatClosingSeparatesIsDropped) {
  const Mesh cube = cubeWithShortEdge();
  const Solid s = closed(both(cube, crumb(0)));
  EXPECT_EQ(edgeConnectedPieces(s.mesh).count, 1u);
  EXPECT_TRUE(says(s, "1 crumb of "));
  EXPECT_TRUE(says(s, " mm3 that closing made was dropped"));
  EXPECT_EQ(lost(s, cube), 0u);
  EXPECT_EQ(s.mesh.triangles.size(), s.source_triangle.size());
  EXPECT_NEAR(signedVolume(s.mesh), 64, 1e-4);
}

TEST(Defects, ACrumbOfTheScansOwnStays) {
  const Mesh m = both(cubeWithShortEdge(), crumb(1));
  const Solid s = closed(m);
  EXPECT_EQ(edgeConnectedPieces(s.mesh).count, 2u);
  EXPECT_FALSE(says(s, "crumb"));
  EXPECT_EQ(lost(s, m), 0u);

  // In a file without shared vertices, and beside defects that need a cut.
  Mesh loose;
  for (const Triangle& f : m.triangles) {
    const auto n = static_cast<std::uint32_t>(loose.vertices.size());
    for (const std::uint32_t v : f) loose.vertices.push_back(m.vertices[v]);
    loose.triangles.push_back({n, n + 1, n + 2});
  }
  const Solid cut = closed(both(loose, box(3, 6)));
  EXPECT_EQ(edgeConnectedPieces(cut.mesh).count, 2u);
  EXPECT_FALSE(says(cut, "crumb"));
}

TEST(MadeCrumbs, AreThosePiecesThatTheScanDoesNotHold) {
  const Mesh cube = cubeWithShortEdge(), solid = both(cube, crumb(1));
  const auto triangles = static_cast<std::uint32_t>(cube.triangles.size());
  std::vector<std::uint32_t> source(solid.triangles.size(), kAdded);
  const auto found = [&](const Mesh& scan, double most_mm3) {
    return internal::findMadeCrumbs(scan, solid, source, most_mm3).count;
  };
  EXPECT_EQ(found(cube, 1e-6), 1u) << "all of it was added";
  EXPECT_EQ(found(cube, 1e-9), 0u) << "it is larger";
  EXPECT_EQ(found(cube, 1e3), 1u) << "never the largest";
  const internal::MadeCrumbs crumbs = internal::findMadeCrumbs(cube, solid, source, 1e-6);
  EXPECT_EQ(subset(solid, crumbs.keep).vertices, cube.vertices);
  EXPECT_NEAR(crumbs.volume_mm3, std::pow(kCrumb, 3) / 6, 1e-12);

  for (std::uint32_t t = triangles; t < source.size(); ++t) source[t] = t;
  EXPECT_EQ(found(solid, 1e-6), 0u) << "the scan's own";
  for (std::uint32_t t = triangles; t < source.size(); ++t) source[t] = t - triangles;
  EXPECT_EQ(found(cube, 1e-6), 1u) << "cut off a piece of the scan";
}

// A shell around the crumb contains it. Without the shell the crumb would lie in the wrong material.
TEST(MadeCrumbs, AShellAroundAPieceThatStaysStays) {
  Mesh scan = crumb(1), shell = scan;
  for (Vec3d& p : shell.vertices) p = Vec3d(2.002, 4.002, 5.002) + 3 * (p - Vec3d(2.002, 4.002, 5.002));
  const Mesh solid = both(cubeWithShortEdge(), both(scan, shell));
  std::vector<std::uint32_t> source(solid.triangles.size(), kAdded);
  EXPECT_EQ(internal::findMadeCrumbs(scan, solid, source, 1e-4).count, 2u);
  for (std::uint32_t t = 0; t < 4; ++t) source[source.size() - 8 + t] = t;
  EXPECT_EQ(internal::findMadeCrumbs(scan, solid, source, 1e-4).count, 0u);
}

TEST(Defects, SeamMeshedDifferentlyOnEitherSideIsStitched) {
  // A ball in two halves without shared vertices. The lower one has twice as many sectors and is 0.0004 mm off.
  const auto half = [](int sectors, bool upper) {
    const Mesh whole = ball(20, sectors, 5);
    return without(whole, [&](std::size_t t) { return (middle(whole, t).z() > 0) != upper; });
  };
  Mesh m = half(40, true), lower = half(80, false);

  // Moves the equator of the finer half onto the chords of the coarser half.
  for (Vec3d& p : lower.vertices) {
    if (std::abs(p.z()) > 1e-6) continue;
    const double step = 2 * std::numbers::pi / 40, a = std::atan2(p.y(), p.x()), n = std::floor(a / step + 1e-3);
    const double s = a / step - n;
    if (s > 0.1)
      p = 0.5 *
          (Vec3d(std::cos(n * step), std::sin(n * step), 0) +
           Vec3d(std::cos((n + 1) * step), std::sin((n + 1) * step), 0)) *
          5;
    p = roundedToFloat(Vec3d(p + Vec3d(0, 0, -4e-4)));
  }
  append(m, lower);

  const Solid s = closed(m, {.mode = CloseMode::kRepair});
  EXPECT_TRUE(says(s, "seams were stitched"));
  EXPECT_EQ(s.report.seam_vertices, 80u);
  EXPECT_EQ(s.report.holes_filled, 0u);
  EXPECT_GT(s.report.largest_move_mm, 3e-4);
  EXPECT_LT(s.report.largest_move_mm, 1e-3);
  EXPECT_EQ(lost(s, m), 40u);  // vertices of the finer half joined with the coarser half's
  const auto apart = closeMesh(m, {.mode = CloseMode::kRepair, .stitch_mm = 0});
  ASSERT_TRUE(!apart || apart->report.holes_filled > 0) << "without stitching it is two bowls";
}

TEST(Steps, ExactlyThoseAskedForAreDone) {
  const Mesh whole = arch();
  const Mesh m = without(whole, [&](std::size_t t) { return t % 170 == 85; });
  using S = CloseStep;
  const Solid s = closed(m, {.only = {S::kFill, S::kBase}});
  EXPECT_EQ(s.report.holes_filled, 28u);
  EXPECT_EQ(s.mesh.vertices, closed(m).mesh.vertices);
}

TEST(Steps, OneThatIsMissingIsNamed) {
  using S = CloseStep;
  const auto hintFor = [](const Mesh& m, std::set<S> only) {
    const auto s = closeMesh(m, {.only = std::move(only)});
    EXPECT_FALSE(s);
    return s ? std::string() : s.error().hint;
  };
  const Mesh whole = arch();
  EXPECT_EQ(hintFor(whole, {S::kFill}), "--close fill,base");
  EXPECT_EQ(hintFor(without(whole, [](std::size_t t) { return t == 2400; }), {S::kBase}), "--close fill,base");
  Mesh turned = ball(12, 24, 5);
  std::swap(turned.triangles[40][1], turned.triangles[40][2]);
  EXPECT_EQ(hintFor(turned, {S::kWeld}), "--close weld,orient");
  EXPECT_EQ(hintFor(flipped(ball(12, 24, 5)), {S::kWeld}), "--close weld,orient");
  EXPECT_EQ(hintFor(both(box(0, 2), box(1, 3)), {S::kWeld}), "--close weld,union");
  Mesh twice = box(0, 2);
  twice.vertices.push_back(twice.vertices[7]);
  twice.triangles[11][1] = 8;
  ASSERT_EQ(twice.vertices[8], Vec3d(2, 2, 2));
  EXPECT_EQ(hintFor(twice, {S::kUnite}), "--close weld,union");
}

TEST(Steps, HolesAreFilledUpToALimit) {
  const Mesh whole = ball(20, 40, 5);
  const Mesh m = without(whole, [&](std::size_t t) { return middle(whole, t).z() > 4; });
  const auto s = closeMesh(m, {.mode = CloseMode::kRepair, .fill_up_to_mm = 10});
  ASSERT_FALSE(s);
  EXPECT_NE(s.error().hint.find("--fill-holes-up-to"), std::string::npos);
  EXPECT_EQ(closed(m, {.mode = CloseMode::kRepair, .fill_up_to_mm = 40}).report.holes_filled, 1u);
}

}  // namespace
}  // namespace kerf::defects_test
