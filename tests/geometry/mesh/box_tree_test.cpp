#include "geometry/mesh/box_tree.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace kerf::box_tree_test {
namespace {

std::vector<Box3> randomBoxes(std::size_t count, double largest) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-10, 10), size(0, largest);
  std::vector<Box3> out(count);
  for (Box3& box : out) {
    const Vec3d low(place(random), place(random), place(random));
    box.add(low);
    box.add(Vec3d(low + Vec3d(size(random), size(random), size(random))));
  }
  return out;
}

TEST(BoxTree, FindsTheBoxesThatASearchOfAllFinds) {
  const std::vector<Box3> boxes = randomBoxes(2000, 1);
  const BoxTree tree(boxes);
  for (const Box3& asked : randomBoxes(50, 4)) {
    std::set<std::uint32_t> found, expected;
    EXPECT_TRUE(tree.visit([&](const Box3& node) { return overlap(node, asked); },
                           [&](std::uint32_t n) {
                             if (overlap(boxes[n], asked)) {
                               EXPECT_TRUE(found.insert(n).second) << "twice";
                             }
                             return true;
                           }));
    for (std::uint32_t n = 0; n < boxes.size(); ++n)
      if (overlap(boxes[n], asked)) expected.insert(n);
    EXPECT_EQ(found, expected);
  }
}

TEST(BoxTree, AsksFewOfManyAndNoMoreWhereTheyLieOnEachOther) {
  std::size_t asked = 0;
  const auto count = [&](std::uint32_t) { return ++asked > 0; };
  const std::vector<Box3> boxes = randomBoxes(100'000, 0.01);
  const BoxTree tree(boxes);
  tree.visit([&](const Box3& node) { return node.contains(boxes[7].min); }, count);
  EXPECT_LT(asked, 100u);
  EXPECT_GE(asked, 1u);

  asked = 0;
  const BoxTree heap(std::vector<Box3>(100'000, boxes[7]));
  heap.visit([&](const Box3& node) { return node.contains(Vec3d(50, 0, 0)); }, count);
  EXPECT_EQ(asked, 0u);
}

TEST(BoxTree, StopsWhenToldTo) {
  const BoxTree tree(randomBoxes(1000, 1));
  std::size_t asked = 0;
  EXPECT_FALSE(tree.visit([](const Box3&) { return true; }, [&](std::uint32_t) { return ++asked < 5; }));
  EXPECT_EQ(asked, 5u);
  EXPECT_TRUE(BoxTree({}).visit([](const Box3&) { return true; }, [](std::uint32_t) { return false; }));
}

}  // namespace
}  // namespace kerf::box_tree_test
