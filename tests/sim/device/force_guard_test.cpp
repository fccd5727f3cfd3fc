#include "sim/device/frame/force_guard.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "sim/device/frame/workspace_map.h"

namespace kerf::force_guard_test {
namespace {

constexpr double kMs = 1e-3;

TEST(ForceGuard, DisarmedItGivesNothingAndArmedItFadesIn) {
  ForceGuard guard({.force = 3, .rate = 1e9, .ramp_s = 0.5});
  EXPECT_EQ(guard.pass({0, 0, 1}, kMs), Vec3d::Zero());
  guard.arm();
  Vec3d force;
  for (int n = 0; n < 250; ++n) force = guard.pass({0, 0, 1}, kMs);
  EXPECT_NEAR(force[2], 0.5, 1e-9);
  for (int n = 0; n < 250; ++n) force = guard.pass({0, 0, 1}, kMs);
  EXPECT_NEAR(force[2], 1, 1e-9);
  guard.disarm();
  EXPECT_EQ(guard.pass({0, 0, 1}, kMs), Vec3d::Zero()) << "at once";
}

// Distance of a force from the line between the last force and zero.
double fromWayBack(const Vec3d& force, const Vec3d& last) {
  const double old = last.squaredNorm();
  return (force - (old > 0 ? std::clamp(force.dot(last) / old, 0.0, 1.0) : 0.0) * last).norm();
}

TEST(ForceGuard, SizeAndRateAreBoundAndTheWayBackIsNot) {
  ForceGuard guard({.force = 3, .rate = 500, .ramp_s = kMs});
  guard.arm();
  Vec3d last = Vec3d::Zero();
  double most = 0, fastest = 0;
  for (int n = 0; n < 2000; ++n) {
    const double speed = n < 1000 ? 0.01 : 1;  // first the magnitude, then the rate
    const Vec3d force = guard.pass(10 * Vec3d(std::sin(0.9 * speed * n), std::cos(1.7 * speed * n), 1), kMs);
    most = std::max(most, force.norm());
    fastest = std::max(fastest, fromWayBack(force, last));
    last = force;
  }
  EXPECT_LE(most, 3 + 1e-12);
  EXPECT_GT(most, 2.9);
  EXPECT_LE(fastest, 0.5 + 1e-9);
  EXPECT_EQ(guard.pass(Vec3d::Zero(), kMs), Vec3d::Zero());
}

// A hand under a pull must not be struck in the opposite direction, although that force is smaller.
TEST(ForceGuard, AForceThatTurnsRoundGrowsFromZero) {
  ForceGuard guard({.force = 3, .rate = 500, .ramp_s = kMs});
  guard.arm();
  for (int n = 0; n < 100; ++n) guard.pass({0, 0, 3}, kMs);
  const Vec3d turned = guard.pass({0, 0, -2.9}, kMs);
  EXPECT_NEAR(turned[2], -0.5, 1e-9);
}

TEST(ForceGuard, ANumberThatIsNoneTakesTheForceAwayUntilItIsArmedAgain) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    ForceGuard guard({.force = 3, .rate = 1e9, .ramp_s = kMs});
    guard.arm();
    ASSERT_NE(guard.pass({1, 0, 0}, kMs), Vec3d::Zero());
    EXPECT_EQ(guard.pass({bad, 0, 0}, kMs), Vec3d::Zero());
    EXPECT_TRUE(guard.hasFault());
    EXPECT_EQ(guard.pass({1, 0, 0}, kMs), Vec3d::Zero());
    guard.arm();
    EXPECT_NE(guard.pass({1, 0, 0}, kMs), Vec3d::Zero());
  }
}

TEST(WorkspaceMap, ATurnedAndScaledHandMeetsTheToolAndFeelsItsForceWhereItPushes) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(M_PI / 2, Vec3d::UnitZ()));
  WorkspaceMap map(turn, 0.5);
  const Rigid3 hand{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vec3d::UnitY())), {100, 20, -30}};
  const Rigid3 tool{Eigen::Quaterniond(Eigen::AngleAxisd(1.1, Vec3d::UnitX())), {1, 2, 3}};
  map.meet(hand, tool);
  EXPECT_NEAR((map.toWorld(hand).translation - tool.translation).norm(), 0, 1e-12);
  EXPECT_NEAR(map.toWorld(hand).rotation.angularDistance(tool.rotation), 0, 1e-7);

  Rigid3 moved = hand;
  moved.translation += Vec3d(2, 0, 0);
  const Vec3d way = map.toWorld(moved).translation - tool.translation;
  EXPECT_NEAR((way - Vec3d(0, 1, 0)).norm(), 0, 1e-12) << "to its right is along +y of the world, at half the size";
  EXPECT_NEAR((map.toDevice(-way) - Vec3d(-1, 0, 0)).norm(), 0, 1e-12) << "against the motion in both";

  // A turn about its own axis turns the tool about the same axis of the world.
  Rigid3 turned = hand;
  turned.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.2, Vec3d::UnitX())) * hand.rotation;
  const Eigen::AngleAxisd got(map.toWorld(turned).rotation * tool.rotation.conjugate());
  EXPECT_NEAR((got.angle() * got.axis() - 0.2 * Vec3d::UnitY()).norm(), 0, 1e-9);
}

}  // namespace
}  // namespace kerf::force_guard_test
