#include "sim/pieces/pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <random>

#include "bench/scenes/carved_field.h"
#include "geometry/field/marching_cubes.h"
#include "geometry/field/sample_field.h"
#include "sim/pieces/split_field.h"
#include "tests/geometry/sampled_field.h"

namespace kerf::pieces_test {
namespace {

using scenes::ballWithAHole;
using scenes::carve;
using scenes::carveAtRandom;

// Reference: flood fill of all nodes, one by one.
struct Flood {
  std::map<std::uint64_t, int> label;
  std::vector<std::uint64_t> nodes;  // per label

  explicit Flood(const BrickField& field) {
    std::vector<std::uint64_t> bricks;
    for (std::size_t b = 0; b < field.brickCount(); ++b) bricks.push_back(coordKey(field.brickCoord(b)));
    for (const Vec3i& c : field.interiorBricks()) bricks.push_back(coordKey(c));
    std::vector<Vec3i> stack;
    for (const std::uint64_t key : bricks) {
      const auto c = coordOfKey(key);
      for (int n = 0; n < kBrickNodes; ++n) {
        const Vec3i start = 8 * Vec3i{c[0], c[1], c[2]} + Vec3i{n >> 6, n >> 3 & 7, n & 7};
        if (!(field.at(start) < 0) || label.contains(coordKey(start))) continue;
        const int mine = static_cast<int>(nodes.size());
        nodes.push_back(0);
        label[coordKey(start)] = mine;
        stack.push_back(start);
        while (!stack.empty()) {
          const Vec3i p = stack.back();
          stack.pop_back();
          ++nodes.back();
          for (int axis = 0; axis < 3; ++axis)
            for (const int step : {-1, 1}) {
              const Vec3i q = p + step * Vec3i(Vec3i::Unit(axis));
              if (field.at(q) < 0 && label.try_emplace(coordKey(q), mine).second) stack.push_back(q);
            }
        }
      }
    }
  }
};

std::vector<Piece> all(const PieceList& list) {
  std::vector<Piece> out = list.pieces;
  out.insert(out.end(), list.crumbs.begin(), list.crumbs.end());
  return out;
}

// Same nodes in the same pieces as by flood fill, and a balanced ledger.
void expectAsFlooded(PieceFinder& finder) {
  const Flood flood(finder.field().flattened());
  const PieceList& list = finder.find();
  const std::vector<Piece> pieces = all(list);
  ASSERT_EQ(pieces.size(), flood.nodes.size());

  std::map<std::uint32_t, int> as_flooded;
  for (const auto& [key, label] : flood.label) {
    const auto c = coordOfKey(key);
    const std::uint32_t id = finder.pieceAt({c[0], c[1], c[2]});
    ASSERT_LT(id, pieces.size());
    ASSERT_EQ(as_flooded.try_emplace(id, label).first->second, label);
  }

  SolidMeasure sum;
  for (std::size_t n = 0; n < pieces.size(); ++n) {
    EXPECT_EQ(pieces[n].id, n);
    EXPECT_EQ(pieces[n].measure.nodes, flood.nodes[static_cast<std::size_t>(as_flooded.at(pieces[n].id))]);
    EXPECT_EQ(finder.pieceAt(pieces[n].first_node), n);
    if (n > 0) {
      EXPECT_GE(pieces[n - 1].volume, pieces[n].volume);
    }
    sum.add(pieces[n].measure);
  }
  EXPECT_EQ(sum, list.whole);
}

// Field with every node inside or outside as given, at half a voxel from the surface.
BrickField nodesInside(const std::vector<Vec3i>& inside) {
  BrickField field(0.1, 0.3f, -0.4f);
  for (const Vec3i& n : inside)
    for (int c = 0; c < 27; ++c) {
      const Vec3i near = n + Vec3i{c / 9 - 1, c / 3 % 3 - 1, c % 3 - 1};
      BrickValues& v = field.brick(field.touch(brickOf(near)));
      static_cast<void>(v);
    }
  for (std::size_t b = 0; b < field.brickCount(); ++b) field.brick(b).fill(0.05f);
  for (const Vec3i& n : inside)
    field.brick(field.touch(brickOf(n)))[static_cast<std::size_t>(nodeOffset(n[0], n[1], n[2]))] = -0.05f;
  return field;
}

std::size_t pieceCount(const BrickField& field) {
  PieceFinder finder(field);
  expectAsFlooded(finder);
  return all(finder.find()).size();
}

// All nodes of the box [low, high].
void addBox(std::vector<Vec3i>& nodes, const Vec3i& low, const Vec3i& high) {
  for (int x = low[0]; x <= high[0]; ++x)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int z = low[2]; z <= high[2]; ++z) nodes.push_back({x, y, z});
}

TEST(PieceFinder, PartsThatTouchAtAnEdgeOrACornerAreTwoPieces) {
  for (const int shift : {0, 3, 7, 8, -5}) {  // inside a brick and across its faces
    const Vec3i o = Vec3i::Constant(shift);
    EXPECT_EQ(pieceCount(nodesInside({o, o + Vec3i{1, 1, 1}})), 2u);
    EXPECT_EQ(pieceCount(nodesInside({o, o + Vec3i{1, 1, 0}})), 2u);
    EXPECT_EQ(pieceCount(nodesInside({o, o + Vec3i{0, 1, 0}})), 1u);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(pieceCount(nodesInside({o, o + Vec3i(Vec3i::Unit(axis))})), 1u);
      EXPECT_EQ(pieceCount(nodesInside({o, o + 2 * Vec3i(Vec3i::Unit(axis))})), 2u);
    }
  }
}

TEST(PieceFinder, ABridgeOfOneNodeJoinsAndItsLossSeparates) {
  for (const int at : {4, 7, 8, 15, 16}) {  // the bridge in the middle of a brick and at its faces
    std::vector<Vec3i> nodes;
    addBox(nodes, {at - 10, 0, 0}, {at - 1, 9, 9});
    addBox(nodes, {at + 1, 0, 0}, {at + 10, 9, 9});
    const Vec3i bridge{at, 3, 8};
    nodes.push_back(bridge);
    const BrickField field = nodesInside(nodes);
    PieceFinder finder(field);
    const SolidMeasure before = finder.find().whole;
    ASSERT_EQ(all(finder.find()).size(), 1u);

    BrickEdit edit;
    edit.brick = brickOf(bridge);
    edit.phi = *field.valuesAt(edit.brick);
    float& v = edit.phi[static_cast<std::size_t>(nodeOffset(bridge[0], bridge[1], bridge[2]))];
    v = 0;  // a node on the surface is outside
    finder.apply(std::span(&edit, 1));
    EXPECT_EQ(all(finder.find()).size(), 2u);
    expectAsFlooded(finder);
    EXPECT_EQ(finder.find().whole.nodes + 1, before.nodes);
    EXPECT_EQ(finder.pieceAt(bridge), PieceFinder::kNoPiece);

    v = -0.05f;
    finder.apply(std::span(&edit, 1));
    EXPECT_EQ(all(finder.find()).size(), 1u);
    EXPECT_EQ(finder.find().whole, before);
  }
}

TEST(PieceFinder, NoiseAndACheckerboardAreFoundAsByFloodFill) {
  std::mt19937 random(3);
  for (const double inside : {0.2, 0.35, 0.7}) {
    std::bernoulli_distribution is_inside(inside);
    std::vector<Vec3i> nodes;
    addBox(nodes, {-9, -9, -9}, {12, 12, 12});
    std::erase_if(nodes, [&](const Vec3i&) { return !is_inside(random); });
    EXPECT_GE(pieceCount(nodesInside(nodes)), 1u);
  }
  std::vector<Vec3i> board;
  addBox(board, {0, 0, 0}, {15, 7, 7});
  std::erase_if(board, [](const Vec3i& n) { return ((n[0] + n[1] + n[2]) & 1) != 0; });
  EXPECT_EQ(pieceCount(nodesInside(board)), 512u);
}

TEST(PieceFinder, NothingInsideIsNoPiece) {
  const BrickField empty(0.1, 0.3f);
  PieceFinder finder(empty);
  EXPECT_TRUE(all(finder.find()).empty());
  EXPECT_EQ(finder.find().whole, SolidMeasure{});
  EXPECT_EQ(finder.pieceAt({0, 0, 0}), PieceFinder::kNoPiece);
  EXPECT_EQ(finder.pieceOfBrick({0, 0, 0}), PieceFinder::kNoPiece);
}

TEST(PieceFinder, VolumeOfABallFallsShortByLessThanHalfTheSquareOfVoxelOverRadius) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  for (const double voxels : {5.0, 10.0, 30.0})
    for (int round = 0; round < 5; ++round) {
      const double h = 1 / voxels;
      const Vec3d c = h * Vec3d(shift(random), shift(random), shift(random));
      Box3 box;
      box.add(c);
      box.grow(1);
      const BrickField phi0 = sampleDistance([&](const Vec3d& p) { return (p - c).norm() - 1; }, box, h);
      PieceFinder finder(phi0);
      const PieceList& list = finder.find();
      ASSERT_EQ(list.pieces.size(), 1u);
      EXPECT_NEAR(list.pieces[0].volume / (4.0 / 3.0 * std::numbers::pi), 1, 0.5 / voxels / voxels) << voxels;
      EXPECT_LT((list.pieces[0].bounds.center() - c).norm(), h);
      EXPECT_LT((list.pieces[0].bounds.size() - Vec3d::Constant(2)).cwiseAbs().maxCoeff(), 2 * h);
    }
}

TEST(PieceFinder, VolumeOfABoxFollowsEverySideEvenly) {
  // Sides along the grid, at any place between nodes: only edges are uncertain. A node there sees half of each of two
  // gaps of up to h / 2, but not the bar where both meet: 3/4 h^2 at worst.
  const double h = 0.05;
  for (const double x : {0.8, 0.803, 0.81, 0.825, 0.84, 0.8499}) {
    const Vec3d half(x, 1.21, 0.57);
    Box3 box;
    box.add(Vec3d::Zero());
    box.grow(1.5);
    const BrickField phi0 = sampled(h, box, [&](const Vec3d& p) { return (p.cwiseAbs() - half).maxCoeff(); });
    PieceFinder finder(phi0);
    ASSERT_EQ(finder.find().pieces.size(), 1u);
    EXPECT_NEAR(finder.find().pieces[0].volume, 8 * half.prod(), 8 * half.sum() * 0.75 * h * h);
  }
}

TEST(PieceFinder, VolumeOfAPlateDoesNotDependOnItsAttitude) {
  std::mt19937 random(9);
  std::normal_distribution<double> n;
  const double h = 0.1;
  const Vec3d half(0.233, 1.5, 1.5);
  for (int round = 0; round < 12; ++round) {
    const Eigen::Quaterniond turn = Eigen::Quaterniond(n(random), n(random), n(random), n(random)).normalized();
    Box3 box;
    box.add(Vec3d::Zero());
    box.grow(2.2);
    const BrickField phi0 = sampled(h, box, [&](const Vec3d& p) {
      const Vec3d d = (turn * p).cwiseAbs() - half;
      return d.cwiseMax(0.0).norm() + std::min(0.0, d.maxCoeff());
    });
    PieceFinder finder(phi0);
    EXPECT_NEAR(finder.find().whole.volume(h) / (8 * half.prod()), 1, 0.01);
  }
}

TEST(PieceFinder, CrumbsAreListedApartLargestFirst) {
  const double h = 0.1;
  Box3 box;
  box.add(Vec3d::Constant(-3));
  box.add(Vec3d::Constant(3));
  const std::array<std::pair<Vec3d, double>, 4> balls{
      {{{0, 0, 0}, 1.0}, {{2.5, 0, 0}, 0.35}, {{0, 2.5, 0}, 0.25}, {{-1.8, -1.8, 0}, 0.6}}};
  const BrickField phi0 = sampleDistance(
      [&](const Vec3d& p) {
        double d = 1e9;
        for (const auto& [c, r] : balls) d = std::min(d, (p - c).norm() - r);
        return d;
      },
      box, h);

  PieceOptions options;
  options.crumb_mm3 = 0.3;  // between the third ball's 0.18 and the fourth's 0.9
  PieceFinder finder(phi0, options);
  const PieceList& list = finder.find();
  ASSERT_EQ(list.pieces.size(), 2u);
  ASSERT_EQ(list.crumbs.size(), 2u);

  EXPECT_EQ(finder.pieceAt({0, 0, 0}), 0u);
  EXPECT_EQ(finder.pieceAt({-18, -18, 0}), 1u);
  EXPECT_EQ(finder.pieceAt({25, 0, 0}), 2u);
  EXPECT_EQ(finder.pieceAt({0, 25, 0}), 3u);
  expectAsFlooded(finder);
}

TEST(PieceFinder, TenThousandCarvesEndWhereARebuildBegins) {
  const double r = 2.0;
  const BrickField phi0 = ballWithAHole(r, 0.1);
  OverlayField truth(phi0);
  PieceFinder finder(phi0);
  std::mt19937 random(12);
  for (int n = 0; n < 10'000; ++n) {
    finder.apply(carveAtRandom(truth, r, random));
    if (n % 500 == 0) expectAsFlooded(finder);
    if (::testing::Test::HasFailure()) return;
  }

  const BrickField whole = truth.flattened();
  PieceFinder fresh(whole);
  const std::vector<Piece> a = all(finder.find()), b = all(fresh.find());
  ASSERT_EQ(a.size(), b.size());
  EXPECT_GT(a.size(), 3u);
  EXPECT_EQ(finder.find().whole, fresh.find().whole);
  for (std::size_t n = 0; n < a.size(); ++n) {
    EXPECT_EQ(a[n].measure, b[n].measure);
    EXPECT_EQ(a[n].first_node, b[n].first_node);
    EXPECT_EQ(a[n].bounds.min, b[n].bounds.min);
    EXPECT_EQ(a[n].bounds.max, b[n].bounds.max);
  }
}

// A bar of 3 x 2 x 2 mm, sawn by an oblique kerf of 0.35 mm, and a chip in the kerf. Distances of its pieces are exact
// except beyond edges, where they are too small.
double barDistance(const Vec3d& p) {
  const Vec3d d = p.cwiseAbs() - Vec3d(1.5, 1, 1);
  return d.cwiseMax(0.0).norm() + std::min(0.0, d.maxCoeff());
}
double kerfHeight(const Vec3d& p) { return Vec3d(1, 0.3, 0.2).normalized().dot(p); }
double upperHalfDistance(const Vec3d& p) { return std::max(barDistance(p), 0.175 - kerfHeight(p)); }
double lowerHalfDistance(const Vec3d& p) { return std::max(barDistance(p), 0.175 + kerfHeight(p)); }
double chipDistance(const Vec3d& p) { return (p - Vec3d(-0.1, 0.2, 0.2)).norm() - 0.06; }

BrickField sawnBar() {
  Box3 box;
  box.add(Vec3d(-1.5, -1, -1));
  box.add(Vec3d(1.5, 1, 1));
  return sampleDistance(
      [](const Vec3d& p) {
        return std::min({upperHalfDistance(p), lowerHalfDistance(p), chipDistance(p)});
      },
      box, 0.1);
}

TEST(SplitField, PartsAndCrumbsSumToTheWholeToTheBit) {
  const BrickField phi0 = sawnBar();
  OverlayField truth(phi0);
  PieceFinder finder(phi0);
  finder.apply(carve(truth, {1.5, 1, 1}, 0.5));  // changed bricks are split too
  const std::vector<Piece> pieces = all(finder.find());
  ASSERT_EQ(pieces.size(), 3u);
  ASSERT_EQ(finder.find().crumbs.size(), 1u);

  SolidMeasure sum;
  double volumes = 0;
  for (const Piece& piece : pieces) {
    const BrickField alone = splitField(finder, piece.id);
    PieceFinder again(alone);
    ASSERT_EQ(all(again.find()).size(), 1u);
    EXPECT_EQ(again.find().whole, piece.measure);
    sum.add(again.find().whole);
    volumes += all(again.find())[0].volume;
  }
  EXPECT_EQ(sum, finder.find().whole);
  EXPECT_NEAR(volumes / finder.find().whole.volume(0.1), 1, 1e-12);
}

TEST(SplitField, ThePieceKeepsItsSurfaceAndNothingIsLeftOfTheOthers) {
  const BrickField phi0 = sawnBar();
  PieceFinder finder(phi0);
  const double h = 0.1;
  for (const Piece& piece : all(finder.find())) {
    const BrickField alone = splitField(finder, piece.id);
    MarchingCubesOptions plain;
    plain.chord_balance = 0;
    const Mesh whole = marchingCubes(phi0, plain), mesh = marchingCubes(alone, plain);
    expectClosedManifold(mesh);

    // Every vertex equals one of the whole, bit for bit.
    std::vector<std::array<double, 3>> known;
    for (const Vec3d& p : whole.vertices) known.push_back({p[0], p[1], p[2]});
    std::sort(known.begin(), known.end());
    for (const Vec3d& p : mesh.vertices)
      ASSERT_TRUE(std::binary_search(known.begin(), known.end(), std::array{p[0], p[1], p[2]}));

    // Only the piece makes the field small: at the places of the others it is the distance to this one.
    const auto distance = chipDistance(h * piece.first_node.cast<double>()) < 0 ? chipDistance
                          : kerfHeight(h * piece.first_node.cast<double>()) > 0 ? upperHalfDistance
                                                                                : lowerHalfDistance;
    std::size_t in_the_kerf = 0;
    for (std::size_t b = 0; b < alone.brickCount(); ++b)
      for (int n = 0; n < kBrickNodes; ++n) {
        const Vec3i node = alone.brickCoord(b) * kBrickSide + Vec3i{n >> 6, n >> 3 & 7, n & 7};
        const Vec3d p = h * node.cast<double>();
        const float v = alone.brick(b)[static_cast<std::size_t>(n)];
        const bool is_mine = finder.pieceAt(node) == piece.id;
        ASSERT_EQ(v < 0, is_mine);
        if (is_mine) {
          ASSERT_EQ(v, phi0.at(node));
          continue;
        }
        const double wanted = std::min(distance(p), double{alone.background()});
        // Half a voxel: if two pieces are equally near, or one is a chip of a few nodes, the distance of the other may
        // be used.
        ASSERT_GT(v, wanted - 0.6 * h);
        if (barDistance(p) > -3 * h) continue;  // beside the kerf's mouth: balls do not reach its sharp edges
        ASSERT_LT(v, wanted + 0.3 * h);
        ++in_the_kerf;
      }
    EXPECT_GT(in_the_kerf, 200u);
  }
}

// Across a corner of the grid, a brick deep in one piece may be near another only by its box: it stays unchanged.
TEST(SplitField, AnObliqueKerfTakesNothingFromEither) {
  constexpr double h = 0.1;
  for (const double width : {2.6, 4.5})  // voxels
    for (const Vec3d& normal : {Vec3d(1, 1, 1), Vec3d(1, 1, 0), Vec3d(1, -1, 1)})
      for (const double shift : {-2.6, -1.1, 0.9, 2.0}) {
        const Vec3d n = normal.normalized();
        // Every brick is stored, including those all inside or all outside, as beside any sampled surface.
        BrickField phi0(h, static_cast<float>(3 * h), static_cast<float>(-3 * h));
        for (int x = -4; x < 4; ++x)
          for (int y = -4; y < 4; ++y)
            for (int z = -4; z < 4; ++z) {
              BrickValues values;
              for (int i = 0; i < kBrickNodes; ++i) {
                const Vec3d p = Vec3d(8 * x + (i >> 6), 8 * y + (i >> 3 & 7), 8 * z + (i & 7));
                const double cube = (p + Vec3d::Constant(0.5)).cwiseAbs().maxCoeff() - 27;
                const double kerf = 0.5 * width - std::abs(p.dot(n) - shift);
                values[static_cast<std::size_t>(i)] =
                    static_cast<float>(h * std::clamp(std::max(cube, kerf), -3.0, 3.0));
              }
              phi0.add({x, y, z}, values);
            }

        PieceFinder finder(phi0);
        const std::vector<Piece> pieces = all(finder.find());
        ASSERT_EQ(pieces.size(), 2u);
        for (const Piece& piece : pieces) {
          const BrickField alone = splitField(finder, piece.id);
          PieceFinder again(alone);
          EXPECT_EQ(again.find().whole, piece.measure) << width << " along " << normal.transpose() << " at " << shift;
          EXPECT_EQ(all(again.find()).size(), 1u);
        }
      }
}

// Undo restores values, but a subscriber has seen the values in between. A piece must not depend on them.
TEST(SplitField, WhatWasTakenBackLeavesNoTrace) {
  Box3 box;
  box.add(Vec3d(-2.2, -2.2, -2.2));
  box.add(Vec3d(6.6, 2.2, 2.2));
  const auto twoBalls = [](const Vec3d& p) { return std::min(p.norm(), (p - Vec3d(4.4, 0, 0)).norm()) - 2; };
  const BrickField phi0 = sampleDistance(twoBalls, box, 0.1);
  PieceFinder fresh(phi0), follower(phi0);
  OverlayField truth(phi0);

  const std::vector<BrickEdit> cut = carve(truth, {0.5, 0, 0}, 0.8);
  std::vector<BrickEdit> back;
  const auto asLoaded = [&](const Vec3i& brick) {
    BrickEdit edit;
    edit.brick = brick;
    if (const BrickValues* values = phi0.valuesAt(brick))
      edit.phi = *values;
    else
      edit.phi.fill(phi0.constantAt(brick));
    return edit;
  };

  for (const BrickEdit& edit : cut) back.push_back(asLoaded(edit.brick));
  for (const Vec3i& brick : phi0.interiorBricks()) back.push_back(asLoaded(brick));
  for (int x = -3; x <= 3; ++x) back.push_back(asLoaded({x, 4, 0}));  // air beside it

  ASSERT_FALSE(phi0.interiorBricks().empty());
  follower.apply(cut);
  follower.apply(back);

  const std::size_t count = fresh.find().pieces.size();
  ASSERT_EQ(follower.find().pieces.size(), count);
  const auto expected = bricksOfPieces(fresh, count), found = bricksOfPieces(follower, count);
  for (std::size_t n = 0; n < count; ++n) {
    EXPECT_EQ(found[n].bricks, expected[n].bricks);
    EXPECT_EQ(found[n].interior.size(), expected[n].interior.size());
    ASSERT_EQ(found[n].changed.size(), expected[n].changed.size());
    for (std::size_t e = 0; e < found[n].changed.size(); ++e) {
      EXPECT_EQ(found[n].changed[e].brick, expected[n].changed[e].brick);
      EXPECT_EQ(found[n].changed[e].phi, expected[n].changed[e].phi);
    }
  }
}

TEST(SplitField, OfASinglePieceIsTheFieldItself) {
  const BrickField phi0 = ballWithAHole(1.5, 0.1);
  PieceFinder finder(phi0);
  ASSERT_EQ(all(finder.find()).size(), 1u);
  const BrickField alone = splitField(finder, 0);
  EXPECT_EQ(alone.interiorBricks().size(), phi0.interiorBricks().size());
  for (std::size_t b = 0; b < alone.brickCount(); ++b) EXPECT_EQ(alone.brick(b), *phi0.valuesAt(alone.brickCoord(b)));
}

}  // namespace
}  // namespace kerf::pieces_test
