#include "geometry/field/brick_directory.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace kerf::brick_directory_test {
namespace {

const Vec3i kLow(-2, 3, -7), kSize(4, 3, 5);

// Every brick of the box has its place in coordinate order.
BrickDirectory numbered() {
  BrickDirectory out(kLow, kSize);
  std::int32_t next = 0;
  for (int x = 0; x < kSize[0]; ++x)
    for (int y = 0; y < kSize[1]; ++y)
      for (int z = 0; z < kSize[2]; ++z) out.set(out.indexOf(kLow + Vec3i(x, y, z)), next++);
  return out;
}

TEST(BrickDirectory, HasOnePlaceForEachBrickOfItsBoxAndNoneOutside) {
  const BrickDirectory directory = numbered();
  EXPECT_EQ(directory.cellCount(), 60u);
  for (int n = 0; n < 60; ++n) {
    const Vec3i brick = kLow + Vec3i(n / 15, n / 5 % 3, n % 5);
    EXPECT_TRUE(directory.contains(brick));
    EXPECT_EQ(directory.find(brick), n);
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(directory.find(kLow - Vec3i(Vec3i::Unit(axis))), BrickDirectory::kNone);
    EXPECT_EQ(directory.find(kLow + kSize[axis] * Vec3i(Vec3i::Unit(axis))), BrickDirectory::kNone);
  }
  EXPECT_EQ(BrickDirectory(kLow, kSize).find(kLow), BrickDirectory::kNone) << "no number yet";
}

TEST(BrickDirectory, TheIndexBesideIsThatOfTheNeighbor) {
  const BrickDirectory directory = numbered();
  const Vec3i brick = kLow + Vec3i(1, 1, 2);
  for (int face = 0; face < 6; ++face) {
    Vec3i next = brick;
    next[face / 2] += face & 1 ? 1 : -1;
    EXPECT_EQ(directory.indexBeside(directory.indexOf(brick), face), directory.indexOf(next)) << face;
  }
}

TEST(BrickDirectory, VisitsABoxInOrderAndAsFarAsItGoes) {
  const BrickDirectory directory = numbered();
  std::vector<std::int32_t> seen;
  const auto see = [&](std::int32_t number) { seen.push_back(number); };
  directory.forEachIn(kLow + Vec3i(1, 1, 3), kLow + Vec3i(2, 1, 9), see);
  EXPECT_EQ(seen, (std::vector<std::int32_t>{23, 24, 38, 39}));
  seen.clear();
  directory.forEachIn(kLow + Vec3i(9, 0, 0), kLow + Vec3i(9, 1, 1), see);
  EXPECT_TRUE(seen.empty());
}

TEST(BrickDirectory, VisitsWhatIsAroundABrickWithTheStepToIt) {
  BrickDirectory directory = numbered();
  const Vec3i corner = kLow + kSize - Vec3i::Ones();
  directory.set(directory.indexOf(corner - Vec3i(1, 0, 0)), BrickDirectory::kNone);
  std::size_t count = 0;
  directory.forEachAround(corner, [&](std::int32_t number, const Vec3i& step) {
    EXPECT_EQ(number, directory.find(corner + step));
    ++count;
  });
  EXPECT_EQ(count, 7u) << "eight are in the box, one has no number";
}

}  // namespace
}  // namespace kerf::brick_directory_test
