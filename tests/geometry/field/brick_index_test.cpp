#include "geometry/field/brick_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <tuple>
#include <utility>

namespace kerf::brick_index_test {
namespace {

using Place = std::tuple<int, int, int>;

Place placeOf(const Vec3i& brick) { return {brick[0], brick[1], brick[2]}; }

// Stored and marked bricks near the origin and far from it, and the same content as a map.
struct Filled {
  BrickIndex index;
  std::map<Place, std::int32_t> stored;
  std::set<Place> inside;

  Filled() {
    std::mt19937 random(3);
    std::uniform_int_distribution<int> near(-13, 13);
    std::int32_t number = 0;
    for (int n = 0; n < 8000; ++n) {
      const Vec3i brick =
          Vec3i(near(random), near(random), near(random)) + (n % 3 == 0 ? Vec3i(-131072, 0, 99999) : Vec3i(0, 0, 0));
      const Place place = placeOf(brick);
      if (n % 2 == 0) {
        index.markInterior(brick);
        if (!stored.contains(place)) inside.insert(place);
      } else if (!stored.contains(place)) {
        index.add(brick, number);
        stored[place] = number++;
        inside.erase(place);
      }
    }
  }
};

void expectSame(const BrickIndex& index, const Filled& filled) {
  for (const Vec3i& corner : {Vec3i(-14, -14, -14), Vec3i(-131086, -14, 99985)})
    for (int n = 0; n < 28 * 28 * 28; ++n) {
      const Vec3i brick = corner + Vec3i(n / 784, n / 28 % 28, n % 28);
      const auto known = filled.stored.find(placeOf(brick));
      ASSERT_EQ(index.find(brick), known == filled.stored.end() ? BrickIndex::kNone : known->second)
          << brick.transpose();
      ASSERT_EQ(index.isInterior(brick), filled.inside.contains(placeOf(brick))) << brick.transpose();
    }
}

TEST(BrickIndex, KnowsWhatAMapKnows) {
  const Filled filled;
  ASSERT_GT(filled.stored.size(), 2000u);
  ASSERT_GT(filled.inside.size(), 1000u);
  expectSame(filled.index, filled);
}

TEST(BrickIndex, ListsWhatIsInsideInTheOrderOfCoordinates) {
  const Filled filled;
  const std::vector<Vec3i> listed = filled.index.interior();
  ASSERT_EQ(listed.size(), filled.inside.size());
  // A set of places is ordered by their keys.
  EXPECT_TRUE(std::equal(listed.begin(), listed.end(), filled.inside.begin(),
                         [](const Vec3i& brick, const Place& place) { return placeOf(brick) == place; }));
  EXPECT_TRUE(std::is_sorted(listed.begin(), listed.end(),
                             [](const Vec3i& a, const Vec3i& b) { return coordKey(a) < coordKey(b); }));
}

TEST(BrickIndex, HasNothingBeforeAnythingIsAddedAndAfterItWasMovedAway) {
  BrickIndex index;
  EXPECT_EQ(index.find({0, 0, 0}), BrickIndex::kNone);
  EXPECT_FALSE(index.isInterior({0, 0, 0}));
  EXPECT_TRUE(index.interior().empty());

  Filled filled;
  const BrickIndex taken = std::move(filled.index);
  expectSame(taken, filled);
  EXPECT_EQ(filled.index.find({0, 0, 0}), BrickIndex::kNone);
  EXPECT_TRUE(filled.index.interior().empty());
  filled.index.add({0, 0, 0}, 7);
  EXPECT_EQ(filled.index.find({0, 0, 0}), 7);
}

TEST(BrickIndex, ACopyIsItsOwn) {
  const Filled filled;
  BrickIndex copy = filled.index;
  copy.add({500, 500, 500}, 4000);
  copy.markInterior({-500, 0, 0});
  EXPECT_EQ(filled.index.find({500, 500, 500}), BrickIndex::kNone);
  EXPECT_FALSE(filled.index.isInterior({-500, 0, 0}));
  EXPECT_EQ(copy.find({500, 500, 500}), 4000);
  EXPECT_TRUE(copy.isInterior({-500, 0, 0}));
  expectSame(filled.index, filled);
}

TEST(BrickIndex, IsTheSameWhetherMemoryWasReservedOrNot) {
  BrickIndex grown, reserved;
  reserved.reserve(5000);
  for (int n = 0; n < 5000; ++n) {
    grown.add({n, -n, n / 7}, n);
    reserved.add({n, -n, n / 7}, n);
  }
  for (int n = 0; n < 5000; ++n) {
    ASSERT_EQ(grown.find({n, -n, n / 7}), n);
    ASSERT_EQ(reserved.find({n, -n, n / 7}), n);
  }
  EXPECT_EQ(reserved.find({5000, -5000, 5000 / 7}), BrickIndex::kNone);
}

}  // namespace
}  // namespace kerf::brick_index_test
