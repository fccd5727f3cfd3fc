#include "ui/app/view/upright.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "tests/preprocess/solid_checks.h"

namespace kerf::upright_test {
namespace {

// The upper half of a ball on a flat plate, its top towards +z.
Mesh dome(bool has_plate) {
  Mesh m = ball(40, 80, 10);
  for (Vec3d& p : m.vertices) p.z() = std::max(p.z(), 0.0);
  std::erase_if(m.triangles, [&](const Triangle& f) {
    const bool is_flat = m.vertices[f[0]].z() == 0 && m.vertices[f[1]].z() == 0 && m.vertices[f[2]].z() == 0;
    return is_flat && !has_plate;
  });
  return m;
}

Mesh turned(Mesh m, const Eigen::Matrix3d& turn) {
  for (Vec3d& p : m.vertices) p = turn * p;
  return m;
}

// A crown of 8 mm: four cusps with fissures between them towards +z, or round; closed by a round face towards -z.
Mesh crown(bool has_fissures) {
  Mesh m = ball(24, 48, 4);
  for (Vec3d& p : m.vertices)
    if (has_fissures && p.z() > 0) p.z() *= (0.8 - 0.2 * std::cos(2 * p.x())) * (0.8 - 0.2 * std::cos(2 * p.y()));
  return m;
}

// Fourteen of them along half an ellipse, each at another height than its neighbours: an arch without gums and base.
Mesh archOfCrowns(bool has_fissures) {
  constexpr int kTeeth = 14;
  Mesh arch;
  for (int n = 0; n < kTeeth; ++n) {
    const double angle = std::numbers::pi * (n + 0.5) / kTeeth;
    const Vec3d place(27 * std::cos(angle), 38 * std::sin(angle), 0.3 * (n % 3));
    const auto first = static_cast<std::uint32_t>(arch.vertices.size());
    const Mesh tooth = crown(has_fissures);
    for (const Vec3d& p : tooth.vertices) arch.vertices.push_back(p + place);
    for (const Triangle& f : tooth.triangles) arch.triangles.push_back({f[0] + first, f[1] + first, f[2] + first});
  }
  return arch;
}

TEST(Upright, AClosedArchWithoutABaseHasItsFissuresUpHoweverItIsStored) {
  const Mesh arch = archOfCrowns(true);
  for (const Vec3d& up : {Vec3d(0, 0, 1), Vec3d(0, 0, -1), Vec3d(0, 1, 0)}) {
    const Mesh stored = turned(arch, Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), up).toRotationMatrix());
    const auto found = surelyUp(stored);
    ASSERT_TRUE(found) << up.transpose();
    EXPECT_EQ(*found, up);
  }
  const auto normal = occlusalNormalOf(arch);
  ASSERT_TRUE(normal);
  EXPECT_GT(normal->z(), 0.95) << normal->transpose();
}

TEST(Upright, AnArchThatIsAsSmoothOnBothSidesAndASingleCrownAreLeftAlone) {
  EXPECT_FALSE(surelyUp(archOfCrowns(false)));
  EXPECT_FALSE(surelyUp(crown(true)));
}

TEST(Upright, AScanStandsOnItsBaseOrItsOpeningHoweverItIsStored) {
  for (const Vec3d& up :
       {Vec3d(1, 0, 0), Vec3d(-1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, -1, 0), Vec3d(0, 0, 1), Vec3d(0, 0, -1)})
    for (const bool has_plate : {true, false})
      for (const double tilt : {0.0, 0.2}) {  // rad: a plaster cast is trimmed by hand
        const Eigen::Matrix3d turn = Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), up).toRotationMatrix() *
                                     Eigen::AngleAxisd(tilt, Vec3d(1, 1, 0).normalized()).toRotationMatrix();
        const auto found = surelyUp(turned(dome(has_plate), turn));
        ASSERT_TRUE(found) << up.transpose() << " " << has_plate << " " << tilt;
        EXPECT_EQ(*found, up) << has_plate << " " << tilt;
      }
}

TEST(Upright, WhatHasNoUnderTellsNothing) {
  EXPECT_FALSE(surelyUp(ball(40, 80, 10)));
  EXPECT_FALSE(surelyUp(box({0, 0, 0}, {2, 4, 6}))) << "a block has as much on the other side";
  EXPECT_FALSE(surelyUp(Mesh{}));
}

}  // namespace
}  // namespace kerf::upright_test
