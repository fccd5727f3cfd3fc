#include "preprocess/close/close.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <set>

#include "tests/preprocess/solid_checks.h"

namespace kerf::close_test {
namespace {

TEST(Close, CleanSolidIsLeftAlone) {
  const Mesh m = ball(12, 24, 5);
  const Solid s = closed(m);
  EXPECT_EQ(s.mesh.vertices, m.vertices);
  EXPECT_EQ(s.mesh.triangles, m.triangles);
  EXPECT_TRUE(s.report.changes.empty());
  for (std::uint32_t t = 0; t < s.source_triangle.size(); ++t) EXPECT_EQ(s.source_triangle[t], t);
}

/// Walls with a volume by formula.
const CloseOptions kStraight{.base_smoothing_mm = 0};

TEST(Close, OpenBoxGetsABaseOfTheRightVolume) {
  Mesh m = box({0, 0, 0}, {4, 3, 2});
  m.triangles.erase(m.triangles.begin(), m.triangles.begin() + 2);  // the floor
  const Solid s = closed(m, kStraight);
  expectSourceFirst(s, m);
  EXPECT_EQ(s.report.rims_extruded, 1u);
  EXPECT_EQ(s.report.base_direction, Vec3d(0, 0, -1));
  EXPECT_DOUBLE_EQ(signedVolume(s.mesh), 4 * 3 * (2 + 2.0));
  EXPECT_EQ(s.report.triangles_kept, 10u);
}

TEST(Close, InsideOutScanIsTurned) {
  Mesh m = box({0, 0, 0}, {4, 3, 2});
  m.triangles.erase(m.triangles.begin(), m.triangles.begin() + 2);
  const Solid s = closed(flipped(m), kStraight);
  EXPECT_EQ(s.report.base_direction, Vec3d(0, 0, -1));
  EXPECT_DOUBLE_EQ(signedVolume(s.mesh), 48);
}

TEST(Close, BaseDirectionCanBeGiven) {
  Mesh m = box({0, 0, 0}, {4, 3, 2});
  m.triangles.erase(m.triangles.begin() + 2, m.triangles.begin() + 4);  // the ceiling
  const Solid s = closed(
      m, {.mode = CloseMode::kBase, .base_margin_mm = 1, .base_smoothing_mm = 0, .base_direction = Vec3d(0.1, 0, 0.9)});
  EXPECT_DOUBLE_EQ(signedVolume(s.mesh), 4 * 3 * 3.0);
}

TEST(Close, ABaseDirectionAwayFromTheOpeningIsRefusedWithTheOneFound) {
  Mesh m = box({0, 0, 0}, {4, 3, 2});
  m.triangles.erase(m.triangles.begin(), m.triangles.begin() + 2);  // the floor
  for (const Mesh& mesh : {m, flipped(m)}) {
    EXPECT_DOUBLE_EQ(signedVolume(closed(mesh, {.base_smoothing_mm = 0, .base_direction = -Vec3d::UnitZ()}).mesh), 48);
    for (const Vec3d& away : {Vec3d(0, 0, 1), Vec3d(1, 0, 0), Vec3d(0, -1, 0)}) {
      const auto s = closeMesh(mesh, {.base_direction = away});
      ASSERT_FALSE(s);
      EXPECT_NE(s.error().found.find("open towards -z"), std::string::npos) << s.error().message();
      EXPECT_NE(s.error().hint.find("--base-direction -z"), std::string::npos) << s.error().message();
    }
  }
}

TEST(Close, ABaseThatWasAskedForAndNotMadeIsNoted) {
  for (const CloseOptions& o : {CloseOptions{.base_style = BaseStyle::kFull}, CloseOptions{.base_is_asked = true},
                                CloseOptions{.base_height_mm = 20}, CloseOptions{.find_occlusal_plane = true}}) {
    const Solid s = closed(box(0, 4), o);
    ASSERT_EQ(s.report.changes.size(), 1u);
    EXPECT_NE(s.report.changes[0].find("no base was made: the mesh is closed"), std::string::npos);
  }
  EXPECT_TRUE(closed(box(0, 4)).report.changes.empty());
}

TEST(Close, RepairRefusesAMissingUnderside) {
  Mesh m = ball(24, 48, 5);
  std::erase_if(m.triangles, [&](const Triangle& f) {
    return std::any_of(f.begin(), f.end(), [&](std::uint32_t v) { return m.vertices[v].z() < -0.1; });
  });
  const auto s = closeMesh(m, {.mode = CloseMode::kRepair});
  ASSERT_FALSE(s);
  EXPECT_EQ(s.error().code, Error::Code::kGeometry);
  EXPECT_NE(s.error().hint.find("base"), std::string::npos);
}

// A prism of n sides without its lid, as a tray.
Mesh tray(int n, double r, double height) {
  Mesh m;
  for (int k = 0; k < n; ++k)
    for (const double z : {0.0, height})
      m.vertices.push_back(roundedToFloat(Vec3d(r * std::cos(2 * M_PI * k / n), r * std::sin(2 * M_PI * k / n), z)));
  m.vertices.push_back(Vec3d::Zero());
  const auto middle = static_cast<std::uint32_t>(2 * n);
  for (int k = 0; k < n; ++k) {
    const auto a = static_cast<std::uint32_t>(2 * k), b = static_cast<std::uint32_t>(2 * ((k + 1) % n));
    m.triangles.insert(m.triangles.end(), {{a, b, b + 1}, {a, b + 1, a + 1}, {middle, b, a}});
  }
  return m;
}

// A few long edges around it: a missing triangle or corner is no missing underside.
TEST(Close, WhereATriangleOfACoarseSolidIsMissingItIsFilled) {
  const Mesh whole = box({0, 0, 0}, {3, 4, 5});
  for (std::size_t n = 0; n < 12; ++n)
    for (const CloseMode mode : {CloseMode::kAuto, CloseMode::kRepair}) {
      Mesh m = whole;
      m.triangles.erase(m.triangles.begin() + static_cast<std::ptrdiff_t>(n));
      const Solid s = closed(m, {.mode = mode});
      EXPECT_DOUBLE_EQ(signedVolume(s.mesh), 60) << n;
      EXPECT_EQ(s.report.holes_filled, 1u);
      EXPECT_EQ(s.report.rims_extruded, 0u);
    }
  // Two triangles with an edge between faces: four edges around a corner.
  Mesh m = whole;
  m.triangles.erase(m.triangles.begin() + 4);
  m.triangles.erase(m.triangles.begin());
  EXPECT_EQ(closed(m).report.rims_extruded, 0u);
  // Beside a true rim it remains a hole.
  Mesh open = ball(24, 48, 30);
  std::erase_if(open.triangles, [&](const Triangle& f) {
    return std::any_of(f.begin(), f.end(), [&](std::uint32_t v) { return open.vertices[v].z() < -0.1; });
  });
  Mesh block = box({40, 0, 0}, {50, 4, 4});
  block.triangles.pop_back();
  const Solid both_kinds = closed(both(open, block), kStraight);
  EXPECT_EQ(both_kinds.report.rims_extruded, 1u);
  EXPECT_EQ(both_kinds.report.holes_filled, 1u);
}

TEST(Close, RepairFillsAMissingFaceOfACoarseSolidAndTheBaseInItsPlaceIsTold) {
  Mesh block = box({0, 0, 0}, {4, 3, 2});
  block.triangles.erase(block.triangles.begin(), block.triangles.begin() + 2);
  for (const Mesh& m : {block, tray(12, 30, 8)}) {
    const Solid filled = closed(m, {.mode = CloseMode::kRepair});
    const double floor_mm3 = m.vertices.size() == 8 ? 24 : 12 * 0.5 * 30 * 30 * std::sin(M_PI / 6) * 8;
    EXPECT_NEAR(signedVolume(filled.mesh), floor_mm3, 1e-5 * floor_mm3);
    const auto& said = closed(m).report.changes;
    EXPECT_TRUE(std::any_of(said.begin(), said.end(), [](const std::string& change) {
      return change.find("if a face of a solid is missing, --close repair fills it") != std::string::npos;
    })) << fmt::format("{}", fmt::join(said, "; "));
  }
}

TEST(Close, HoleInABallIsFilled) {
  Mesh m = ball(20, 40, 5);
  const double whole = signedVolume(m);
  m.triangles.erase(m.triangles.begin() + 200, m.triangles.begin() + 202);
  m.triangles.erase(m.triangles.begin() + 500);
  const Solid s = closed(m, {.mode = CloseMode::kRepair});
  expectSourceFirst(s, m);
  EXPECT_EQ(s.report.holes_filled, 2u);
  EXPECT_NEAR(signedVolume(s.mesh), whole, 0.05);
  EXPECT_EQ(s.report.triangles_kept, m.triangles.size());
}

TEST(Close, OverlappingCubesUnite) {
  const Mesh m = both(box(0, 2), box(1, 3));
  const Solid s = closed(m);
  EXPECT_DOUBLE_EQ(signedVolume(s.mesh), 8 + 8 - 1);
  EXPECT_EQ(edgeConnectedPieces(s.mesh).count, 1u);
  EXPECT_GT(s.report.crossings_resolved, 0u);
}

TEST(Close, ObliqueBallsUniteWithinRounding) {
  Mesh b = ball(16, 32, 5);
  Mesh c = b;
  for (Vec3d& p : c.vertices) p = roundedToFloat(Vec3d(p + Vec3d(3.3, 1.7, -2.2)));
  const Solid s = closed(both(b, c));
  // Union + intersection = sum; the lens by the formula for balls, about 1 % too large for these polyhedra.
  const double d = Vec3d(3.3, 1.7, -2.2).norm(), lens = M_PI * (10 - d) * (10 - d) * (d * d + 20 * d) / (12 * d);
  EXPECT_NEAR(signedVolume(s.mesh), 2 * signedVolume(b) - lens, 0.03 * lens);
  // Every ball vertex outside the other ball survives.
  std::set<std::array<double, 3>> places;
  for (const Vec3d& p : s.mesh.vertices) places.insert({p.x(), p.y(), p.z()});
  for (const Vec3d& p : b.vertices)
    if ((p - Vec3d(3.3, 1.7, -2.2)).norm() > 5.01) {
      EXPECT_TRUE(places.count({p.x(), p.y(), p.z()}));
    }
}

TEST(Close, DuplicatedCubeCountsOnce) { EXPECT_DOUBLE_EQ(signedVolume(closed(both(box(0, 2), box(0, 2))).mesh), 8); }

TEST(Close, SolidInsideASolidVanishes) {
  const Solid s = closed(both(box(0, 4), box(1, 2)));
  EXPECT_DOUBLE_EQ(signedVolume(s.mesh), 64);
  EXPECT_EQ(s.mesh.triangles.size(), 12u);
}

TEST(Close, CavityStays) {
  const Solid s = closed(both(box(0, 4), flipped(box(1, 2))));
  EXPECT_DOUBLE_EQ(signedVolume(s.mesh), 63);
  EXPECT_EQ(s.mesh.triangles.size(), 24u);
  EXPECT_TRUE(s.report.changes.empty());
}

TEST(Close, InsideOutPieceOnItsOwnIsTurned) {
  const Solid s = closed(both(box(0, 2), flipped(box(5, 6))));
  EXPECT_DOUBLE_EQ(signedVolume(s.mesh), 9);
}

// Quads of `step` mm on a box, so that vertices lie on the lines of a neighbour.
Mesh gridBox(const Vec3d& lo, const Vec3d& hi, double step) {
  Mesh m;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool is_up : {false, true}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      for (double a = lo[u]; a < hi[u]; a += step)
        for (double b = lo[v]; b < hi[v]; b += step) {
          const auto at = [&](double du, double dv) {
            Vec3d p;
            p[axis] = is_up ? hi[axis] : lo[axis];
            p[u] = a + du;
            p[v] = b + dv;
            m.vertices.push_back(p);
            return static_cast<std::uint32_t>(m.vertices.size() - 1);
          };
          const std::array<std::uint32_t, 4> q{at(0, 0), at(step, 0), at(step, step), at(0, step)};
          if (is_up)
            m.triangles.insert(m.triangles.end(), {{q[0], q[1], q[2]}, {q[0], q[2], q[3]}});
          else
            m.triangles.insert(m.triangles.end(), {{q[0], q[2], q[1]}, {q[0], q[3], q[2]}});
        }
    }
  return m;
}

// Mirrored objects are inside out. Pieces that touch or cross others are united, not subtracted.
TEST(Close, APieceInsideOutThatTouchesOrCrossesOthersIsUnited) {
  const auto side = [](double x) { return box({x, 0, 0}, {x + 10, 10, 10}); };
  for (std::size_t wrong = 0; wrong < 3; ++wrong) {
    Mesh wall_to_wall;
    for (std::size_t k = 0; k < 3; ++k) {
      const Mesh one = side(10.0 * static_cast<double>(k));
      append(wall_to_wall, k == wrong ? flipped(one) : one);
    }
    for (const CloseMode mode : {CloseMode::kAuto, CloseMode::kRepair}) {
      const Solid s = closed(wall_to_wall, {.mode = mode});
      EXPECT_DOUBLE_EQ(signedVolume(s.mesh), 3000) << wrong;
      EXPECT_TRUE(s.report.warnings.empty()) << s.report.warnings.front();
    }
  }

  // Crossing, with vertices in, on and beside the other's lines; sharing faces, an edge of the overlap, a corner.
  struct Pair {
    Vec3d lo;
    double volume;
  };
  for (const Pair& pair : {Pair{{4, 4, 4}, 960}, Pair{{4, 0, 0}, 768}, Pair{{4, 4, 0}, 896}, Pair{{0, 4, 2}, 832}})
    for (const double step : {8.0, 4.0, 2.0})
      for (const bool is_second : {true, false}) {
        const Mesh a = gridBox({0, 0, 0}, {8, 8, 8}, step), b = gridBox(pair.lo, pair.lo + Vec3d::Constant(8), step);
        const Solid s = closed(is_second ? both(a, flipped(b)) : both(flipped(a), b));
        EXPECT_DOUBLE_EQ(signedVolume(s.mesh), pair.volume) << pair.lo.transpose() << ", " << step;
        EXPECT_TRUE(s.report.warnings.empty()) << s.report.warnings.front();
      }
}

TEST(Close, OfAHollowSolidThatIsInsideOutTheCavityStays) {
  const Mesh hollow = both(box(0, 10), flipped(box(3, 6)));
  EXPECT_DOUBLE_EQ(signedVolume(closed(flipped(hollow)).mesh), 973);
  // Beside a correct one, with a solid in the cavity.
  const Mesh three = both(hollow, box(4, 5));
  EXPECT_DOUBLE_EQ(signedVolume(closed(three).mesh), 974);
  EXPECT_DOUBLE_EQ(signedVolume(closed(flipped(three)).mesh), 974);
  Mesh beside = flipped(three);
  for (Vec3d& p : beside.vertices) p.x() += 20;
  EXPECT_DOUBLE_EQ(signedVolume(closed(both(three, beside)).mesh), 2 * 974);
}

// A piece inside an open piece may be its cavity, and a folded triangle elsewhere does not affect that.
TEST(Close, TheCavityOfAnOpenPieceStaysBesideAFoldedTriangle) {
  Mesh m = both(box(0, 10), flipped(box(3, 6)));
  m.triangles.erase(m.triangles.begin(), m.triangles.begin() + 2);  // the floor
  EXPECT_DOUBLE_EQ(signedVolume(closed(m, kStraight).mesh), 1200 - 27);
  const auto first = static_cast<std::uint32_t>(m.vertices.size());
  for (const Vec3d& p : {Vec3d(20, 0, 5), Vec3d(21, 0, 5), Vec3d(20, 1, 5)}) m.vertices.push_back(p);
  m.triangles.push_back({first, first + 1, first + 2});
  m.triangles.push_back({first, first + 2, first + 1});
  EXPECT_DOUBLE_EQ(signedVolume(closed(m, kStraight).mesh), 1200 - 27);
}

// The wall of a hollow that faces the wrong way is a solid within a solid.
TEST(Close, APieceThatGoesWithinAnotherIsSaidAloud) {
  const Solid s = closed(both(box(0, 10), box(3, 6)));
  EXPECT_DOUBLE_EQ(signedVolume(s.mesh), 1000);
  ASSERT_EQ(s.report.warnings.size(), 1u);
  EXPECT_NE(s.report.warnings[0].find("MUCH OF THE SCAN IS LOST"), std::string::npos) << s.report.warnings[0];
}

TEST(Close, FlippedPatchIsTurned) {
  Mesh m = ball(12, 24, 5);
  const double volume = signedVolume(m);
  for (std::size_t t = 100; t < 130; ++t) std::swap(m.triangles[t][1], m.triangles[t][2]);
  const Solid s = closed(m);
  EXPECT_EQ(s.report.triangles_flipped, 30u);
  EXPECT_DOUBLE_EQ(signedVolume(s.mesh), volume);
  expectSourceFirst(s, m);
}

TEST(Close, CubesGluedFaceToFaceBecomeOne) {
  const Solid s = closed(both(box({0, 0, 0}, {2, 2, 2}), box({2, 0, 0}, {4, 2, 2})));
  EXPECT_DOUBLE_EQ(signedVolume(s.mesh), 16);
  // The same where the common wall is part of the larger face only.
  EXPECT_DOUBLE_EQ(signedVolume(closed(both(box(0, 2), box({2, 0.5, 0.5}, {3, 1, 1.5}))).mesh), 8.5);
}

TEST(Close, CubesTouchingInAnEdgeOrACornerAreMovedApart) {
  const Solid edge = closed(both(box(0, 2), box({2, 2, 0}, {4, 4, 2})));
  EXPECT_NEAR(signedVolume(edge.mesh), 16, 0.01);
  EXPECT_GT(edge.report.vertices_moved, 0u);
  EXPECT_LE(edge.report.largest_move_mm, 5e-4);
  const Solid corner = closed(both(box(0, 2), box(2, 4)));
  EXPECT_NEAR(signedVolume(corner.mesh), 16, 0.01);
  EXPECT_EQ(corner.report.vertices_moved, 1u);
}

TEST(Close, EdgeTouchingItsOwnSolidIsMovedApart) {
  // Two bricks on a plate meet in one edge: the material is connected, the edge ends at the plate.
  const Solid s =
      closed(both(both(box({0, 0, 0}, {4, 4, 1}), box({0, 0, 0.5}, {2, 2, 3})), box({2, 2, 0.5}, {4, 4, 3})));
  EXPECT_NEAR(signedVolume(s.mesh), 16 + 2 * 8, 0.01);
}

/// A quarter-pipe scan with a rim that crosses itself when seen from above: a sheet with an overhang.
TEST(Close, RimThatCrossesItselfInProjectionGetsABase) {
  // A spiral ribbon over the plane: a climbing arc of 1.2 turns, 2 wide, normals up.
  Mesh m;
  const int n = 60;
  for (int i = 0; i <= n; ++i) {
    const double a = 2 * M_PI * 1.2 * i / n, z = 10 + 6.0 * i / n;
    for (const double r : {4.0, 6.0}) m.vertices.push_back(roundedToFloat(Vec3d(r * std::cos(a), r * std::sin(a), z)));
  }
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(n); ++i) {
    m.triangles.push_back({2 * i, 2 * i + 1, 2 * i + 3});
    m.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 2});
  }
  const Solid s = closed(m, {.mode = CloseMode::kBase, .base_smoothing_mm = 0, .base_direction = Vec3d(0, 0, -1)});
  EXPECT_EQ(s.report.rims_extruded, 1u);
  // The ribbon's shadow is the full ring. Where it overlaps itself, the upper turn decides. Height over the base at z =
  // 8.
  double expected = 0;
  const double segment = 0.5 * (36 - 16) * std::sin(2 * M_PI * 1.2 / n);
  for (int i = n / 6; i < n; ++i) expected += segment * (2 + 6.0 * (i + 0.5) / n);
  EXPECT_NEAR(signedVolume(s.mesh), expected, 0.02 * expected);
}

TEST(Close, VerticalRimEdgesAreNoTrouble) {
  Mesh m = box({0, 0, 0}, {4, 3, 2});
  m.triangles.erase(m.triangles.begin() + 4, m.triangles.begin() + 6);  // the front as well as
  m.triangles.erase(m.triangles.begin(), m.triangles.begin() + 2);      // the floor: the rim climbs vertical edges
  const Solid s = closed(m, {.mode = CloseMode::kBase, .base_smoothing_mm = 0, .base_direction = Vec3d(0, 0, -1)});
  EXPECT_DOUBLE_EQ(signedVolume(s.mesh), 48);
}

TEST(Close, TriangleWithoutAreaOnAnEdgeIsResolved) {
  Mesh m = box(0, 2);
  // Puts a vertex on the edge 0-1 of one of its two triangles, and a triangle without area between.
  m.vertices.push_back({1, 0, 0});
  for (std::size_t t = 0; t < 12; ++t)
    if (m.triangles[t] == Triangle{0, 1, 4}) {
      m.triangles[t] = {0, 8, 4};
      m.triangles.push_back({8, 1, 4});
      m.triangles.push_back({0, 1, 8});
    }
  const Solid s = closed(m);
  EXPECT_DOUBLE_EQ(signedVolume(s.mesh), 8);
  expectSourceFirst(s, m);
}

TEST(Close, DuplicateTriangleInAScanIsDropped) {
  Mesh m = ball(8, 16, 3);
  const double volume = signedVolume(m);
  m.triangles.push_back(m.triangles[20]);
  const Solid s = closed(m);
  EXPECT_DOUBLE_EQ(signedVolume(s.mesh), volume);
  EXPECT_EQ(s.report.triangles_kept + s.report.triangles_dropped, m.triangles.size());
}

TEST(Close, DoubleCoordinatesAreRoundedAndReported) {
  Mesh m = box(0, 2);
  for (Vec3d& p : m.vertices) p.array() += 0.1;
  const Solid s = closed(m);
  EXPECT_EQ(s.report.vertices_rounded, 8u);
  EXPECT_EQ(s.report.changes.size(), 1u);
}

TEST(Close, CrumbsGoAndAreCounted) {
  Mesh m = ball(12, 24, 5);
  Mesh crumb;
  crumb.vertices = {{20, 0, 0}, {20.5, 0, 0}, {20, 0.5, 0}};
  crumb.triangles = {{0, 1, 2}};
  const Solid s = closed(both(m, crumb));
  EXPECT_EQ(s.report.crumbs_dropped, 1u);
  EXPECT_EQ(s.mesh.triangles, m.triangles);
}

TEST(Close, ColoursAreKeptAndAddedPartsAreStone) {
  Mesh m = box({0, 0, 0}, {4, 3, 2});
  for (std::uint8_t k = 0; k < 12; ++k) m.face_colors.push_back({k, 0, 0, 255});
  for (std::uint8_t k = 0; k < 8; ++k) m.vertex_colors.push_back({0, k, 0, 255});
  m.triangles.erase(m.triangles.begin(), m.triangles.begin() + 2);
  m.face_colors.erase(m.face_colors.begin(), m.face_colors.begin() + 2);
  const Solid s = closed(m);
  ASSERT_EQ(s.mesh.face_colors.size(), s.mesh.triangles.size());
  ASSERT_EQ(s.mesh.vertex_colors.size(), s.mesh.vertices.size());
  for (std::size_t t = 0; t < s.mesh.triangles.size(); ++t)
    EXPECT_EQ(s.mesh.face_colors[t],
              s.source_triangle[t] == kAdded ? (Rgba8{214, 205, 189, 255}) : m.face_colors[s.source_triangle[t]]);
  for (std::size_t v = 0; v < 8; ++v) EXPECT_EQ(s.mesh.vertex_colors[v], m.vertex_colors[v]);
}

TEST(Close, TheRimsColoursDoNotRunDownTheWalls) {
  Mesh m = box({0, 0, 0}, {4, 3, 2});
  m.triangles.erase(m.triangles.begin(), m.triangles.begin() + 2);
  m.vertex_colors.assign(8, {255, 0, 0, 255});
  for (const BaseStyle style : {BaseStyle::kHorseshoe, BaseStyle::kFull}) {
    const Solid s = closed(m, {.base_style = style, .base_smoothing_mm = 0});
    EXPECT_DOUBLE_EQ(signedVolume(s.mesh), 48);
    for (std::size_t v = 0; v < s.mesh.vertices.size(); ++v)
      EXPECT_EQ(s.mesh.vertex_colors[v], v < 8 ? (Rgba8{255, 0, 0, 255}) : (Rgba8{214, 205, 189, 255}));
    for (const Triangle& t : s.mesh.triangles)
      for (int k = 0; k < 3; ++k)
        if ((t[static_cast<std::size_t>(k)] < 8) != (t[static_cast<std::size_t>((k + 1) % 3)] < 8)) {
          const double down = std::abs(s.mesh.vertices[t[static_cast<std::size_t>(k)]].z() -
                                       s.mesh.vertices[t[static_cast<std::size_t>((k + 1) % 3)]].z());
          EXPECT_LT(down, 0.21) << "red fades into stone there";
        }
  }
}

TEST(Close, OnSmoothWallsTheRimsColoursEndInTheLip) {
  Mesh m = box({0, 0, 0}, {4, 3, 2});
  m.triangles.erase(m.triangles.begin(), m.triangles.begin() + 2);
  m.vertex_colors.assign(8, {255, 0, 0, 255});
  const Solid s = closed(m);
  EXPECT_NEAR(signedVolume(s.mesh), 48, 0.3) << "corners are rounded a little";
  for (const Vec3d& p : s.mesh.vertices)
    EXPECT_LT((p - p.cwiseMax(Vec3d(0, 0, -2)).cwiseMin(Vec3d(4, 3, 2))).norm(), 0.1);
  for (std::size_t v = 0; v < s.mesh.vertices.size(); ++v) {
    EXPECT_EQ(s.mesh.vertex_colors[v], v < 8 ? (Rgba8{255, 0, 0, 255}) : (Rgba8{214, 205, 189, 255}));
    if (v >= 8) EXPECT_GT(s.mesh.vertices[v].z(), -2.01);
  }
  double lip = 1;
  for (std::size_t v = 8; v < s.mesh.vertices.size(); ++v) lip = std::min(lip, std::abs(s.mesh.vertices[v].z()));
  EXPECT_LT(lip, 0.31) << "stone begins there";
}

TEST(Close, WrapSaysThatItIsAnApproximation) {
  const auto s = closeMesh(box(0, 4), {.mode = CloseMode::kWrap});
  ASSERT_TRUE(s) << s.error().message();
  expectSolid(*s);
  EXPECT_FALSE(s->report.exact);
  EXPECT_NEAR(signedVolume(s->mesh), 4.1 * 4.1 * 4.1, 3.0);
  EXPECT_GT(signedVolume(s->mesh), 64);
}

TEST(Close, SeveralMeshesUnite) {
  const std::vector<Mesh> meshes = {box(0, 2), box(1, 3)};
  const auto s = closeMeshes(meshes);
  ASSERT_TRUE(s);
  EXPECT_DOUBLE_EQ(signedVolume(s->mesh), 15);
  for (const std::uint32_t t : s->source_triangle) EXPECT_LT(t, 24u);
}

TEST(Close, SameBitsForAnyNumberOfThreads) {
  Mesh m = ball(16, 32, 5);
  for (int k = 1; k < 4; ++k) {
    Mesh other = ball(16, 32, 5);
    for (Vec3d& p : other.vertices) p = roundedToFloat(Vec3d(p + k * Vec3d(3.3, 1.7, -2.2)));
    append(m, other);
  }
  const Solid many = closed(m);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Solid single = closed(m);
  EXPECT_EQ(many.mesh.vertices, single.mesh.vertices);
  EXPECT_EQ(many.mesh.triangles, single.mesh.triangles);
  EXPECT_EQ(many.source_triangle, single.source_triangle);
}

TEST(Close, OnATinyScanTheBaseIsTinyToo) {
  Mesh m = box({0, 0, 0}, {0.04, 0.03, 0.02});
  m.triangles.erase(m.triangles.begin(), m.triangles.begin() + 2);
  const Solid s = closed(m);
  EXPECT_EQ(s.report.rims_extruded, 1u);
  EXPECT_LT(bounds(s.mesh).size().z(), 0.06);
  ASSERT_FALSE(s.report.changes.empty());
  EXPECT_NE(s.report.changes[0].find("unit"), std::string::npos);
}

TEST(Close, StopsWhereverItIsAskedTo) {
  // A ragged rim under a bowl that crosses itself, and a ball through it: every step has work.
  Mesh m = ball(24, 48, 5);
  std::erase_if(m.triangles, [&](const Triangle& t) { return m.vertices[t[0]].z() < -3.5 + 0.2 * (t[0] % 3); });
  Mesh other = ball(24, 48, 4);
  for (Vec3d& p : other.vertices) p = roundedToFloat(Vec3d(p + Vec3d(3.3, 1.7, 2.2)));
  append(m, other);
  for (const CloseMode mode : {CloseMode::kBase, CloseMode::kWrap}) {
    int all = 0;
    ASSERT_TRUE(closeMesh(m, {.mode = mode}, [&](double, std::string_view) { return ++all > 0; }));
    EXPECT_GT(all, 30);
    for (int stop = 0; stop < all; stop += 1 + all / 40) {
      int calls = 0;
      const auto s = closeMesh(m, {.mode = mode}, [&](double, std::string_view) { return calls++ < stop; });
      ASSERT_FALSE(s) << stop << " of " << all;
      EXPECT_EQ(s.error().code, Error::Code::kCancelled);
      EXPECT_EQ(calls, stop + 1) << "no step goes on after a no";
    }
  }
}

Mesh meshOf(std::vector<Vec3d> vertices, std::vector<Triangle> triangles) {
  Mesh out;
  out.vertices = std::move(vertices);
  out.triangles = std::move(triangles);
  return out;
}

TEST(Close, TrianglesOnALineAreRefusedByEveryWay) {
  const Mesh line = meshOf({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {5, 0, 0}}, {{0, 1, 2}, {1, 2, 3}, {0, 0, 1}});
  for (const CloseMode mode : {CloseMode::kAuto, CloseMode::kBase, CloseMode::kRepair, CloseMode::kWrap}) {
    const auto refused = closeMesh(line, {.mode = mode});
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().found.find("no area"), std::string::npos) << refused.error().message();
  }
}

// Seen along the base's direction, its rim has no inside.
TEST(Close, AnUprightTriangleGetsNoBase) {
  const Mesh upright = meshOf({{0, 0, 0}, {4, 0, 0}, {2, 0, 4}}, {{0, 1, 2}});
  const auto refused = closeMesh(upright, {.mode = CloseMode::kBase, .base_direction = -Vec3d::UnitZ()});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Error::Code::kGeometry) << refused.error().message();
}

TEST(Close, AWrapThatWouldTakeAllMemoryIsRefusedWithOneThatDoesNot) {
  const auto refused = closeMesh(box(0, 1000), {.mode = CloseMode::kWrap});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Error::Code::kBadValue) << refused.error().message();
  EXPECT_NE(refused.error().expected.find("mm or more"), std::string::npos) << refused.error().message();
}

TEST(Close, WhatIsLargerThanTwoMetresIsRefusedBeforeAnyStep) {
  bool began = false;
  const auto refused = closeMesh(box(0, 1500), {}, [&](double, std::string_view) { return began = true; });
  ASSERT_FALSE(refused);
  EXPECT_FALSE(began);
  EXPECT_EQ(refused.error().code, Error::Code::kBadValue);
  EXPECT_NE(refused.error().hint.find("unit"), std::string::npos) << refused.error().message();
  EXPECT_EQ(findOcclusalPlaneOfScan(box(0, 1500)).error().code, Error::Code::kBadValue);
  EXPECT_TRUE(closeMesh(box(0, 1000)));
  Mesh small = box(0, 10);  // a vertex without a triangle is no part of it
  small.vertices.push_back({1e6, 0, 0});
  EXPECT_TRUE(closeMesh(small));
}

// Files in inches sometimes turn 0 into 1e-17 mm.
TEST(Close, AVertexThatWasWeldedIsNotLost) {
  const Mesh whole = ball(12, 24, 5);
  Mesh m;
  for (const Triangle& f : whole.triangles)
    for (const std::uint32_t v : f) {
      const auto n = static_cast<std::uint32_t>(m.vertices.size());
      if (n % 3 == 0) m.triangles.push_back({n, n + 1, n + 2});
      Vec3d p = whole.vertices[v];
      p.z() = std::abs(p.z()) < 1e-6 ? roundedToFloat(1e-17 * n) : p.z();
      m.vertices.push_back(p);
    }
  const Solid s = closed(m);
  EXPECT_GT(s.report.vertices_welded, 0u);
  EXPECT_EQ(s.report.vertices_lost, 0u) << "all of the equator lies within 1e-14 mm";
  EXPECT_TRUE(s.report.warnings.empty()) << fmt::format("{}", fmt::join(s.report.warnings, "; "));
}

TEST(Close, WhereMostVerticesAreLostIsTold) {
  Mesh sunk = ball(16, 32, 3);
  for (Vec3d& p : sunk.vertices) p = roundedToFloat(Vec3d(p + Vec3d(10.1, 10.2, 9.3)));
  const Solid s = closed(both(box(0, 10), sunk));
  ASSERT_FALSE(s.report.lost_at.empty());
  EXPECT_GT(s.report.lost_at[0].vertices, kManyLostTogether);
  EXPECT_LE(s.report.lost_at[0].vertices, s.report.vertices_lost);
  EXPECT_LT((s.report.lost_at[0].middle - Vec3d(9, 9, 8.5)).norm(), 2);
}

// All triangles between 40 points. Most of them cross: no surface, and minutes of work if each pair were resolved.
TEST(Close, AHeapOfTrianglesIsNotResolved) {
  Mesh heap;
  for (std::uint32_t n = 0; n < 40; ++n) {
    const double turn = 2.399963 * n;
    heap.vertices.push_back(roundedToFloat({10 * std::cos(turn), 10 * std::sin(turn), 0.37 * n}));
  }
  for (std::uint32_t a = 0; a < 40; ++a)
    for (std::uint32_t b = 0; b < a; ++b)
      for (std::uint32_t c = 0; c < b; ++c) heap.triangles.push_back({a, b, c});
  const auto refused = closeMesh(heap, {.mode = CloseMode::kRepair});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Error::Code::kGeometry) << refused.error().message();
}

TEST(Close, NothingInNothingOut) {
  EXPECT_EQ(closeMesh({}).error().code, Error::Code::kEmpty);
  Mesh point;
  point.vertices = {{0, 0, 0}};
  point.triangles = {{0, 0, 0}};
  EXPECT_EQ(closeMesh(point).error().code, Error::Code::kEmpty);
  EXPECT_EQ(closeMesh(box(0, 1), {.base_margin_mm = -1}).error().code, Error::Code::kBadValue);
  EXPECT_EQ(closeMesh(box(0, 1), {}, [](double, std::string_view) { return false; }).error().code,
            Error::Code::kCancelled);
}

}  // namespace
}  // namespace kerf::close_test
