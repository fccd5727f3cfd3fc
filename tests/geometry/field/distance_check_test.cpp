#include "geometry/field/distance_check.h"

#include <gtest/gtest.h>

#include <random>

namespace kerf::distance_check_test {
namespace {

constexpr double kVoxel = 0.2;

// The bricks of a band around {d = 0}, as baking makes them.
template <class Distance>
BrickField band(const Distance& d) {
  BrickField field(kVoxel, static_cast<float>(3 * kVoxel), static_cast<float>(-4 * kVoxel));
  for (int i = -5; i < 5; ++i)
    for (int j = -5; j < 5; ++j)
      for (int k = -5; k < 5; ++k) {
        BrickValues values;
        float least = 1e9f, most = -1e9f;
        for (int n = 0; n < kBrickNodes; ++n) {
          const Vec3i node = 8 * Vec3i{i, j, k} + Vec3i{n >> 6, n >> 3 & 7, n & 7};
          const double v = std::clamp(d(kVoxel * node.cast<double>()), -4 * kVoxel, 3 * kVoxel);
          values[static_cast<std::size_t>(n)] = static_cast<float>(v);
          least = std::min(least, static_cast<float>(v));
          most = std::max(most, static_cast<float>(v));
        }
        if (least < 3 * kVoxel - 1e-6 && most > -4 * kVoxel + 1e-6)
          field.add({i, j, k}, values);
        else if (most < 0)
          field.markInterior({i, j, k});
      }
  return field;
}

double ball(const Vec3d& p) { return p.norm() - 4; }
double box(const Vec3d& p) { return (p.cwiseAbs() - Vec3d(4, 2, 3)).maxCoeff(); }

std::string refusalOf(const BrickField& field) {
  const auto checked = requireDistances(field);
  return checked ? "" : checked.error().message();
}

TEST(DistanceCheck, FieldsOfSolidsAreDistances) {
  EXPECT_EQ(refusalOf(band(ball)), "");
  EXPECT_EQ(refusalOf(band(box)), "");
  EXPECT_EQ(refusalOf(band([](const Vec3d& p) { return std::max(ball(p), -(p - Vec3d(0, 0, 4)).norm() + 1); })), "")
      << "a ball with a hollow";
  EXPECT_EQ(refusalOf(band([](const Vec3d& p) { return std::max(ball(p), 2 - p.norm()); })), "") << "a shell";
}

TEST(DistanceCheck, PairsAlongEachAxisCount) {
  for (const int step : {64, 8, 1}) {
    BrickField layers = band(ball);
    for (std::size_t b = 0; b < layers.brickCount(); ++b)
      for (int n = 0; n < kBrickNodes; ++n) layers.brick(b)[static_cast<std::size_t>(n)] = (n / step & 1) != 0 ? 1 : -1;
    EXPECT_NE(refusalOf(layers).find("noise: 33 % of"), std::string::npos) << refusalOf(layers);
  }
}

TEST(DistanceCheck, NoiseIsRefusedWithItsShare) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> value(-0.8f, 0.6f);
  BrickField noise = band(ball);
  for (std::size_t b = 0; b < noise.brickCount(); ++b)
    for (float& v : noise.brick(b)) v = value(random);
  EXPECT_NE(refusalOf(noise).find("% of neighbouring values differ by more than 0.3 mm"), std::string::npos)
      << refusalOf(noise);

  // Noise in a twentieth of the values also counts as noise; one bad value does not.
  BrickField some = band(ball), one = band(ball);
  for (std::size_t b = 0; b < some.brickCount(); ++b)
    for (float& v : some.brick(b))
      if (random() % 20 == 0) v = v > 0 ? -0.8f : 0.6f;
  EXPECT_NE(refusalOf(some).find("noise"), std::string::npos);
  one.brick(0)[100] = -0.8f;
  EXPECT_EQ(refusalOf(one), "");
}

TEST(DistanceCheck, ATurnedSignIsRefused) {
  BrickField turned = band(ball);
  for (std::size_t b = 0; b < turned.brickCount(); ++b)
    for (float& v : turned.brick(b)) v = -v;
  EXPECT_NE(refusalOf(turned).find("a turned sign: "), std::string::npos) << refusalOf(turned);
}

}  // namespace
}  // namespace kerf::distance_check_test
