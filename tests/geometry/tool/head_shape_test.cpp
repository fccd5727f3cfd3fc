#include "geometry/tool/head_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kerf::head_shape_test {
namespace {

// A valid outline: from axis to axis, upwards, off the axis in between, finite.
void expectSound(const RevolvedProfile& head, const std::string& what) {
  ASSERT_FALSE(head.pieces().empty()) << what;
  EXPECT_EQ(head.pieces().front().from, RevolvedProfile::Point(0, 0)) << what;
  EXPECT_EQ(head.end()[0], 0) << what;
  RevolvedProfile::Point at(0, 0);
  for (const auto& piece : head.pieces()) {
    EXPECT_EQ(piece.from, at) << what;
    EXPECT_TRUE(piece.to.allFinite() && piece.center.allFinite() && std::isfinite(piece.arc_radius)) << what;
    EXPECT_GE(piece.to[1], piece.from[1] - 1e-12) << what;
    EXPECT_GE(piece.to[0], -1e-12) << what;
    if (piece.arc_radius > 0) {
      EXPECT_NEAR((piece.from - piece.center).norm(), piece.arc_radius, 1e-6 * (1 + piece.arc_radius)) << what;
      EXPECT_NEAR((piece.to - piece.center).norm(), piece.arc_radius, 1e-6 * (1 + piece.arc_radius)) << what;
    }
    at = piece.to;
  }
}

TEST(HeadShape, AnyNumbersMakeASoundHeadOrAMistakeThatNamesItsKey) {
  std::mt19937 engine(17);
  const auto any = [&](double low, double high) {  // small and large equally often
    const double t = std::uniform_real_distribution<double>(0, 1)(engine);
    return std::max(low, 1e-3) * std::pow(high / std::max(low, 1e-3), t);
  };
  for (const HeadShape& shape : headShapes()) {
    if (shape.takes_profile) continue;
    int made = 0;
    for (int n = 0; n < 3000; ++n) {
      HeadNumbers numbers;
      std::string what = shape.name;
      for (const HeadKey& key : headKeys()) {
        const auto taken = std::find_if(shape.keys.begin(), shape.keys.end(),
                                        [&](const auto& k) { return std::string(k.name) == key.name; });
        const bool is_diameter = key.value == &HeadNumbers::head_diameter;
        if (!is_diameter && taken == shape.keys.end()) continue;
        if (!is_diameter && taken->unsaid && n % 2) continue;
        numbers.*key.value = any(key.low, key.high);
        what += std::string(" ") + key.name + " " + std::to_string(numbers.*key.value);
      }
      const auto head = shape.build(numbers);
      if (!head) {
        EXPECT_FALSE(head.error().key.empty() || head.error().expected.empty()) << what;
        EXPECT_TRUE(std::any_of(headKeys().begin(), headKeys().end(), [&](const HeadKey& key) {
          return head.error().key == key.name;
        })) << what;
        continue;
      }
      ++made;
      expectSound(*head, what);
      EXPECT_NEAR(head->largestRadius(), 0.5 * numbers.head_diameter, 1e-6) << what;
      if (HasFailure()) return;
    }
    EXPECT_GT(made, 50) << shape.name;
  }
}

TEST(HeadShape, AnyCornersMakeASoundHeadOrAMistake) {
  std::mt19937 engine(18);
  std::uniform_real_distribution<double> u(0, 1);
  int made = 0, arcs = 0;
  for (int n = 0; n < 5000; ++n) {
    HeadNumbers numbers;
    double height = 0;
    for (int i = 0; i < 5; ++i) {
      const double arc = i > 0 && u(engine) < 0.3 ? 4 * u(engine) - 2 : 0;
      numbers.profile.push_back({height, u(engine) < 0.1 ? 0 : 2 * u(engine), arc});
      height += u(engine) < 0.1 ? 0 : u(engine);
    }
    const auto head = findHeadShape("profile")->build(numbers);
    if (!head) {
      EXPECT_EQ(head.error().key, "profile");
      continue;
    }
    ++made;
    for (const auto& piece : head->pieces()) arcs += piece.arc_radius > 0;
    expectSound(*head, "profile");
    if (HasFailure()) return;
  }
  EXPECT_GT(made, 500);
  EXPECT_GT(arcs, 500);
}

TEST(HeadShape, ArcsMeetTheirNeighboursWithoutAKink) {
  HeadNumbers n;
  n.head_diameter = 1.6;
  n.head_length = 8;
  n.tip_diameter = 1.1;
  n.point_length = 1.1;
  n.top_diameter = 0.9;
  n.edge_radius = 0.2;
  n.widest_at = 4;
  for (const char* name : {"taper_round", "torpedo", "pear", "flame", "football", "taper_flat", "inverted_cone"}) {
    const auto head = findHeadShape(name)->build(n);
    ASSERT_TRUE(head) << name;
    const auto& pieces = head->pieces();
    for (std::size_t i = 0; i + 1 < pieces.size(); ++i) {
      const auto &low = pieces[i], &high = pieces[i + 1];
      if (low.arc_radius == 0) continue;  // an arc may start at an edge: a flat end, a point
      const Eigen::Vector2d radius = (low.to - low.center) / low.arc_radius;
      if (high.to[1] == high.from[1]) continue;  // the flat top
      const Eigen::Vector2d across = high.arc_radius > 0 ? (high.from - high.center).normalized()
                                                         : Eigen::Vector2d((high.to - high.from).normalized());
      EXPECT_NEAR(high.arc_radius > 0 ? across.dot(radius) - 1 : across.dot(radius), 0, 1e-9) << name << " piece " << i;
    }
  }
}

}  // namespace
}  // namespace kerf::head_shape_test
