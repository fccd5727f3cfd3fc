// Selection of the triangles that a picture needs, against a slow reference: does any pixel centre lie in the triangle?
#include "ui/window/draw/seen_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace kerf::internal {
namespace {

/// Object frame and pixels are the same.
Sight plainSight() {
  Sight sight;
  sight.to_pixels << 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1;
  return sight;
}

double twiceArea(const Vec3f& a, const Vec3f& b, double x, double y) {
  return (double{b[0]} - a[0]) * (y - a[1]) - (double{b[1]} - a[1]) * (x - a[0]);
}

/// @param slack  pixels beyond each side that count as inside
bool coversAMiddle(const std::array<Vec3f, 3>& t, double slack) {
  const auto [left, right] = std::minmax({t[0][0], t[1][0], t[2][0]});
  const auto [low, high] = std::minmax({t[0][1], t[1][1], t[2][1]});
  for (double x = std::ceil(left - slack); x <= right + slack; ++x)
    for (double y = std::ceil(low - slack); y <= high + slack; ++y) {
      bool is_within = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3f &from = t[k], &to = t[(k + 1) % 3];
        const double reach = slack * (std::abs(to[0] - from[0]) + std::abs(to[1] - from[1]));
        is_within &= twiceArea(from, to, x, y) >= -reach;
      }
      if (is_within) return true;
    }
  return false;
}

/// Smaller than two pixels each way: larger triangles skip the coverage test.
bool isSmall(const std::array<Vec3f, 3>& t) {
  const auto [left, right] = std::minmax({t[0][0], t[1][0], t[2][0]});
  const auto [low, high] = std::minmax({t[0][1], t[1][1], t[2][1]});
  return std::max(right - left, high - low) < 1.9;
}

struct Triangles {
  std::vector<std::array<Vec3f, 3>> corners;
  SeenTriangles seen;

  void add(const std::array<Vec3f, 3>& t) {
    const auto first = static_cast<std::uint32_t>(3 * corners.size());
    corners.push_back(t);
    for (const Vec3f& p : t) seen.addVertex(p);
    seen.addTriangle(first, first + 1, first + 2);
  }
  /// For each triangle, whether it was selected.
  std::vector<bool> chosen(const Sight& sight) {
    seen.look(sight);
    std::vector<std::uint32_t> out;
    seen.choose(0, corners.size(), out);
    std::vector<bool> is_chosen(corners.size());
    for (std::size_t i = 0; i < out.size(); i += 3) {
      EXPECT_EQ(out[i] % 3, 0u);
      EXPECT_EQ(out[i + 1], out[i] + 1);
      EXPECT_EQ(out[i + 2], out[i] + 2);
      is_chosen[out[i] / 3] = true;
    }
    return is_chosen;
  }
};

/// Edges from a hundredth of a pixel to ten, all over 1000 x 1000 pixels, in both orientations.
Triangles randomTriangles(int count) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> place(0, 1000), unit(-1, 1);
  Triangles out;
  for (int n = 0; n < count; ++n) {
    const float size = std::pow(10.0f, 1.5f * unit(random) - 0.5f);
    const Vec3f middle(place(random), place(random), 0);
    std::array<Vec3f, 3> t;
    for (Vec3f& p : t) p = middle + size * Vec3f(unit(random), unit(random), 0);
    out.add(t);
  }
  return out;
}

TEST(SeenTriangles, WhatCoversAMiddleIsKeptAndLittleElse) {
  Triangles random = randomTriangles(30000);
  const std::vector<bool> is_chosen = random.chosen(plainSight());
  int kept = 0, in_vain = 0, behind = 0;
  for (std::size_t n = 0; n < is_chosen.size(); ++n) {
    const auto& t = random.corners[n];
    const double area = twiceArea(t[0], t[1], t[2][0], t[2][1]);
    if (area > 0 && coversAMiddle(t, 0)) {
      EXPECT_TRUE(is_chosen[n]) << n;
    }
    kept += is_chosen[n];
    in_vain += is_chosen[n] && area > 0 && isSmall(t) && !coversAMiddle(t, 0.05);
    behind += is_chosen[n] && area < -1;
  }
  EXPECT_GT(kept, 3000);
  EXPECT_EQ(in_vain, 0);
  EXPECT_EQ(behind, 0);
}

TEST(SeenTriangles, BacksAreKeptWhereTheyAreAskedFor) {
  Triangles random = randomTriangles(10000);
  Sight sight = plainSight();
  sight.has_backs = true;
  const std::vector<bool> is_chosen = random.chosen(sight);
  for (std::size_t n = 0; n < is_chosen.size(); ++n) {
    auto t = random.corners[n];
    if (twiceArea(t[0], t[1], t[2][0], t[2][1]) < 0) std::swap(t[1], t[2]);
    if (coversAMiddle(t, 0)) {
      EXPECT_TRUE(is_chosen[n]) << n;
    }
    if (is_chosen[n] && isSmall(t)) {
      EXPECT_TRUE(coversAMiddle(t, 0.05)) << n;
    }
  }
}

TEST(SeenTriangles, WhatLiesBehindTheEyeOrIsAskedForWholeIsKeptWhole) {
  Triangles random = randomTriangles(1000);
  const auto all = [](const std::vector<bool>& is) { return std::count(is.begin(), is.end(), true) == 1000; };
  Sight sight = plainSight();
  EXPECT_FALSE(all(random.chosen(sight)));
  sight.has_all = true;
  EXPECT_TRUE(all(random.chosen(sight)));

  sight = plainSight();
  sight.to_pixels.row(2) << 1.0f / 1000, 0, 0, -0.5f;  // the eye is in the middle
  EXPECT_TRUE(all(random.chosen(sight)));
}

// In parts of any length: the same result as at once.
TEST(SeenTriangles, PartsMakeTheWhole) {
  Triangles random = randomTriangles(500);
  random.seen.look(plainSight());
  std::vector<std::uint32_t> whole, parts;
  random.seen.choose(0, 500, whole);
  for (std::size_t first = 0, length = 1; first < 500; first += length, length = length % 23 + 1)
    random.seen.choose(first, std::min<std::size_t>(500, first + length), parts);
  EXPECT_EQ(whole, parts);
}

// Single precision alone moves corners there.
TEST(SeenTriangles, FarFromTheOriginMoreIsKept) {
  Triangles there;
  const float far = 20000;  // mm, 100 pixels each
  std::mt19937 random(5);
  std::uniform_real_distribution<float> off(-0.02f, 0.02f);
  for (int n = 0; n < 2000; ++n) {
    std::array<Vec3f, 3> t;
    for (Vec3f& p : t) p = Vec3f(far + off(random), far + off(random), 0);
    there.add(t);
  }
  Sight sight = plainSight();
  sight.to_pixels.topRows<2>() << 100, 0, 0, -100 * far, 0, 100, 0, -100 * far;
  sight.has_backs = true;
  const std::vector<bool> is_chosen = there.chosen(sight);
  for (std::size_t n = 0; n < is_chosen.size(); ++n) {
    auto t = there.corners[n];
    for (Vec3f& p : t) p = 100 * (p - Vec3f(far, far, 0));
    if (twiceArea(t[0], t[1], t[2][0], t[2][1]) < 0) std::swap(t[1], t[2]);
    if (coversAMiddle(t, 0.1)) {
      EXPECT_TRUE(is_chosen[n]) << n;
    }
  }
}

}  // namespace
}  // namespace kerf::internal
