#include "preprocess/print/pockets.h"

#include <algorithm>
#include <map>
#include <random>

#include "tests/preprocess/print/print_shapes.h"

namespace kerf {
namespace {

using test::addArc;
using test::revolved;
using test::turned;
using test::turns;

// A half ball of radius 10 in one of 12, open towards +z; with a hole of this radius at its bottom.
Mesh bowl(double hole = 0) {
  std::vector<Eigen::Vector2d> profile;
  const auto angle = [hole](double r) { return -std::acos(hole / r); };
  addArc(profile, 12, angle(12), 0);
  addArc(profile, 10, 0, angle(10));
  return revolved(profile);
}
constexpr double kBowl = 2 * M_PI / 3 * 1000;

Pockets pocketsOf(const Mesh& solid, const PocketOptions& options) {
  auto out = findPockets(solid, options);
  EXPECT_TRUE(out) << out.error().message();
  return out ? *out : Pockets{};
}
PocketOptions onSupports(const Vec3d& direction) { return {.direction = direction, .on_plate = false}; }

Pocket onlyPocket(const Pockets& found, PocketKind kind) {
  EXPECT_EQ(found.pockets.size(), 1u) << (found.pockets.size() > 1 ? describe(found.pockets[1]) : "");
  if (found.pockets.empty()) return {};
  EXPECT_EQ(found.pockets[0].kind, kind) << describe(found.pockets[0]);
  return found.pockets[0];
}

TEST(Pockets, BowlTowardsThePlateIsAPoolTheOtherWayACup) {
  for (const Eigen::Matrix3d& turn : turns()) {
    const Vec3d shift(31, -7, 12), up = turn * Vec3d::UnitZ();
    const Mesh solid = turned(bowl(), turn, shift);
    for (const bool is_cup : {false, true}) {
      const Pocket p = onlyPocket(pocketsOf(solid, onSupports(is_cup ? up : Vec3d(-up))),
                                  is_cup ? PocketKind::kCup : PocketKind::kPool);
      EXPECT_NEAR(p.volume_mm3, kBowl, 0.004 * kBowl);
      EXPECT_NEAR(p.depth_mm, 10, 0.02);
      EXPECT_NEAR(p.area_mm2, 100 * M_PI, 4);
      EXPECT_LT((p.deepest - (shift - 10 * up)).norm(), 0.3);
      ASSERT_TRUE(p.spill);
      EXPECT_NEAR((*p.spill - shift).dot(up), 0, 0.01);
      EXPECT_NEAR((*p.spill - shift).norm(), 11, 1.3);  // on the flat rim
      EXPECT_TRUE(p.box.contains(shift - 10 * up) && p.box.contains(shift));
      EXPECT_LT(p.box.size().maxCoeff(), 21);
    }
  }
}

TEST(Pockets, TiltedBowlHoldsTheCapBelowItsLowestLip) {
  for (const double tilt : {0.2, 0.5, 0.9}) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(tilt, Vec3d(0.6, 0.8, 0)).toRotationMatrix();
    const Pocket p = onlyPocket(pocketsOf(turned(bowl(), turn), onSupports(-Vec3d::UnitZ())), PocketKind::kPool);
    const double h = 10 - 10 * std::sin(tilt), cap = M_PI * h * h * (30 - h) / 3;
    EXPECT_NEAR(p.depth_mm, h, 0.2 * std::tan(tilt) + 0.03) << tilt;
    EXPECT_NEAR(p.volume_mm3, cap, M_PI * h * (20 - h) * 0.1 * std::tan(tilt) + 0.004 * kBowl) << tilt;
  }
}

TEST(Pockets, PlateClosesWhatStandsOnIt) {
  const Vec3d up = Vec3d::UnitZ();
  const Pocket dome = onlyPocket(pocketsOf(bowl(), {.direction = -up}), PocketKind::kSealed);
  EXPECT_TRUE(dome.is_closed_by_plate);
  EXPECT_NEAR(dome.volume_mm3, kBowl - 0.05 * 100 * M_PI, 0.004 * kBowl);  // the lowest layer belongs to the plate

  // A tube: no pocket on supports; a cup while it stands on the plate.
  const Mesh tube = revolved({{5, 0}, {8, 0}, {8, 10}, {5, 10}});
  EXPECT_TRUE(pocketsOf(tube, onSupports(up)).pockets.empty());
  const Pocket cup = onlyPocket(pocketsOf(tube, {.direction = up}), PocketKind::kCup);
  EXPECT_NEAR(cup.volume_mm3, 25 * M_PI * 9.95, 0.01 * 25 * M_PI * 10);
  // A tunnel across the direction drains both ways.
  EXPECT_TRUE(pocketsOf(tube, onSupports(Vec3d::UnitX())).pockets.empty());
}

TEST(Pockets, ClosedBallIsSealedInAnyDirection) {
  const Mesh solid = both(ball(128, 256, 9), flipped(ball(128, 256, 7)));
  for (const Eigen::Matrix3d& turn : turns()) {
    const Pocket p = onlyPocket(pocketsOf(solid, {.direction = turn.col(2)}), PocketKind::kSealed);
    EXPECT_NEAR(p.volume_mm3, 4 * M_PI / 3 * 343, 0.004 * 4 * M_PI / 3 * 343);
    EXPECT_FALSE(p.is_closed_by_plate);
    EXPECT_FALSE(p.spill);
    EXPECT_LT((p.deepest - 7 * turn.col(2)).norm(), 0.3);
  }
}

TEST(Pockets, BottleDrainsDownToItsNeck) {
  // Radius 8, 20 long, with a neck of radius 2.
  const Mesh bottle =
      revolved({{0, -2}, {10, -2}, {10, 22}, {4, 22}, {4, 30}, {2, 30}, {2, 20}, {8, 20}, {8, 0}, {0, 0}});
  ASSERT_GT(signedVolume(bottle), 0);
  const double body = M_PI * 64 * 20, neck = M_PI * 4 * 10;
  EXPECT_NEAR(onlyPocket(pocketsOf(bottle, onSupports(Vec3d::UnitZ())), PocketKind::kCup).volume_mm3, body + neck,
              0.004 * body);
  EXPECT_NEAR(onlyPocket(pocketsOf(bottle, onSupports(-Vec3d::UnitZ())), PocketKind::kPool).volume_mm3, body + neck,
              0.004 * body);
  // On its side: a pool below the neck, and the same above it for the air.
  const Pockets lying = pocketsOf(bottle, onSupports(Vec3d(0.6, 0.8, 0)));
  ASSERT_EQ(lying.pockets.size(), 2u);
  const double segment = 20 * (64 * std::acos(2.0 / 8) - 2 * std::sqrt(60.0));
  for (const Pocket& p : lying.pockets) EXPECT_NEAR(p.volume_mm3, segment, 0.01 * segment) << describe(p);
  EXPECT_EQ(lying.pockets[0].kind, PocketKind::kPool);
  EXPECT_EQ(lying.pockets[1].kind, PocketKind::kCup);
}

// Overlapping blocks: legs 4 and 3 wide, 5 deep, joined below 2 mm by a duct, the legs 10 and 6 high.
TEST(Pockets, UTubeStandsAtTheLowerLegInBoth) {
  Mesh solid = box({-1, -1, -1}, {12, 6, 0});
  append(solid, box({-1, -1, -1}, {0, 6, 10}));
  append(solid, box({4, -1, 2}, {8, 6, 10}));
  append(solid, box({11, -1, -1}, {12, 6, 6}));
  append(solid, box({-1, -1, -1}, {12, 0, 10}));
  append(solid, box({-1, 5, -1}, {12, 6, 10}));
  for (const Eigen::Matrix3d& turn : turns()) {
    const Pocket p = onlyPocket(pocketsOf(turned(solid, turn), onSupports(-turn.col(2))), PocketKind::kPool);
    EXPECT_NEAR(p.volume_mm3, 5 * (4 * 6 + 3 * 6 + 4 * 2), 0.02 * 250);
    EXPECT_NEAR(p.depth_mm, 6, 0.01);
    ASSERT_TRUE(p.spill);
    const Vec3d spill = turn.transpose() * *p.spill;
    EXPECT_NEAR(spill[0], 11.5, 0.7);
    EXPECT_NEAR(spill[2], 6, 0.01);
  }
}

TEST(Pockets, HoleAsWideAsPromisedNeverCloses) {
  for (const Eigen::Matrix3d& turn : turns())
    for (int n = 0; n < 8; ++n) {
      PocketOptions options = onSupports(-turn.col(2));
      options.voxel_mm = 1.41;
      options.narrowest_mm = 2;
      // The wall has to be thicker than the voxel; a hole a hair wider than the passage.
      const Mesh solid = turned(bowl(1.005), turn, Vec3d(0.31, 0.23, 0.17) * n);
      const Pockets found = pocketsOf(solid, options);
      EXPECT_LE(found.passage_mm, 2);
      for (const Pocket& p : found.pockets) EXPECT_LT(p.volume_mm3, 0.05 * kBowl) << describe(p);
      options.voxel_mm = 0.6;
      EXPECT_NEAR(onlyPocket(pocketsOf(turned(bowl(), turn), options), PocketKind::kPool).volume_mm3, kBowl,
                  0.02 * kBowl);
    }
}

TEST(Pockets, WallAsThickAsAVoxelNeverLeaks) {
  const Mesh solid = both(ball(64, 128, 9), flipped(ball(64, 128, 8.38)));
  for (const Eigen::Matrix3d& turn : turns())
    for (int n = 0; n < 4; ++n) {
      PocketOptions options = onSupports(turn.col(0));
      options.voxel_mm = 0.6;
      const Pocket p =
          onlyPocket(pocketsOf(turned(solid, turn, Vec3d(0.31, 0.23, 0.17) * n), options), PocketKind::kSealed);
      EXPECT_NEAR(p.volume_mm3, 4 * M_PI / 3 * std::pow(8.38, 3), 0.01 * 2465);
    }
}

// The layers one by one: a cell of air is trapped if it has no way out through the layers up to its own.
double trappedByLayers(const std::vector<char>& solid, int n, bool is_from_below, bool wants_sealed) {
  const auto at = [n](int x, int y, int z) { return static_cast<std::size_t>((z * n + y) * n + x); };
  double cells = 0;
  for (int top = 0; top < n; ++top) {
    std::vector<char> seen(solid.size());
    std::vector<std::array<int, 3>> stack;
    const auto go = [&](int x, int y, int k) {
      const int z = is_from_below ? k : n - 1 - k;
      if (x < 0 || y < 0 || x >= n || y >= n || k < 0 || k > (wants_sealed ? n - 1 : top)) return;
      if (solid[at(x, y, z)] || seen[at(x, y, z)]) return;
      seen[at(x, y, z)] = 1;
      stack.push_back({x, y, k});
    };
    for (int k = 0; k < n; ++k)
      for (int a = 0; a < n; ++a) go(0, a, k), go(n - 1, a, k), go(a, 0, k), go(a, n - 1, k);
    while (!stack.empty()) {
      const auto [x, y, k] = stack.back();
      stack.pop_back();
      go(x - 1, y, k), go(x + 1, y, k), go(x, y - 1, k), go(x, y + 1, k), go(x, y, k - 1), go(x, y, k + 1);
    }
    const int z = is_from_below ? top : n - 1 - top;
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) cells += !solid[at(x, y, z)] && !seen[at(x, y, z)];
  }
  return cells;
}

TEST(Pockets, AgreesWithTheLayersOneByOne) {
  std::mt19937 random(43);
  const auto upTo = [&](int most) { return static_cast<int>(random() % static_cast<unsigned>(most + 1)); };
  double cups = 0, pools = 0, seals = 0;
  for (int round = 0; round < 60; ++round) {
    constexpr int kSide = 14;
    std::vector<char> cells(kSide * kSide * kSide);
    Mesh solid;
    for (int b = 0; b < 60; ++b) {
      // Thin plates along any axis, so that there are walls.
      Vec3i lo(1 + upTo(9), 1 + upTo(9), 1 + upTo(9)), hi = lo + Vec3i(2 + upTo(6), 2 + upTo(6), 2 + upTo(6));
      hi = hi.cwiseMin(kSide - 1);
      const int flat = upTo(2);
      hi[flat] = lo[flat] + 1;
      append(solid, box(lo.cast<double>(), hi.cast<double>()));
      for (int z = lo[2]; z < hi[2]; ++z)
        for (int y = lo[1]; y < hi[1]; ++y)
          for (int x = lo[0]; x < hi[0]; ++x) cells[static_cast<std::size_t>((z * kSide + y) * kSide + x)] = 1;
    }
    PocketOptions options{.on_plate = false, .voxel_mm = 1, .narrowest_mm = 2, .least_mm3 = 0.5};
    std::map<PocketKind, double> volume;
    for (const Pocket& p : pocketsOf(solid, options).pockets) volume[p.kind] += p.volume_mm3;
    const double sealed = trappedByLayers(cells, kSide, true, true);
    EXPECT_NEAR(volume[PocketKind::kSealed], sealed, 1e-9) << round;
    EXPECT_NEAR(volume[PocketKind::kCup], trappedByLayers(cells, kSide, true, false) - sealed, 1e-9) << round;
    EXPECT_NEAR(volume[PocketKind::kPool], trappedByLayers(cells, kSide, false, false) - sealed, 1e-9) << round;
    seals += sealed;
    cups += volume[PocketKind::kCup];
    pools += volume[PocketKind::kPool];
  }
  EXPECT_GT(std::min({seals, cups, pools}), 100);  // the solids had pockets of each kind
}

TEST(Pockets, RefusesWithPlaceAndRemedy) {
  Mesh open = box(0, 10);
  open.triangles.pop_back();
  const auto message = [](const Mesh& m, const PocketOptions& options) {
    const auto found = findPockets(m, options);
    return found ? std::string("found") : found.error().message();
  };
  EXPECT_NE(message(open, onSupports(Vec3d::UnitX())).find("an open surface"), std::string::npos);
  EXPECT_NE(message(flipped(box(0, 10)), {}).find("turned outwards"), std::string::npos);
  EXPECT_NE(message({}, {}).find("without triangles"), std::string::npos);
  EXPECT_NE(message(box(0, 10), {.direction = {1, 1, 0}}).find("a vector of length 1"), std::string::npos);
  EXPECT_NE(message(box(0, 10), {.voxel_mm = 0.8}).find("holes of 1 mm stay open. Try: 0.65 mm"), std::string::npos)
      << message(box(0, 10), {.voxel_mm = 0.8});
  EXPECT_NE(message(box(0, 1000), {.voxel_mm = 0.01}).find("million columns"), std::string::npos);

  for (int step = 0, done = 0; !done; ++step) {
    int asked = 0;
    const auto found =
        findPockets(bowl(), {.voxel_mm = 0.65}, [&](double, std::string_view) { return asked++ < step; });
    done = found.has_value();
    ASSERT_TRUE(done || found.error().code == Error::Code::kCancelled);
    ASSERT_LT(step, 1000);
  }
}

TEST(Pockets, SmallOnesAreCounted) {
  PocketOptions options = onSupports(-Vec3d::UnitZ());
  options.least_mm3 = 1e5;
  const Pockets found = pocketsOf(bowl(), options);
  EXPECT_TRUE(found.pockets.empty());
  EXPECT_GE(found.small, 1u);
  EXPECT_NEAR(found.small_mm3, kBowl, 0.004 * kBowl);
}

}  // namespace
}  // namespace kerf
