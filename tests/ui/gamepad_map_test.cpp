#include "ui/app/hand/gamepad_map.h"

#include <gtest/gtest.h>

#include "tests/ui/block_on_bench.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/strokes.h"

namespace kerf::gamepad_map_test {
namespace {

using Limits = GamepadLimits;
using test::OnABlock;

TEST(GamepadMap, NearItsMiddleAStickIsAtRestAndFromThereThereIsNoStep) {
  const auto speed = [](double x, double y) { return wishOf({.left_stick = {x, y}}, {}, 0.01).tool_mm.norm() / 0.01; };
  EXPECT_EQ(speed(0, 0), 0);
  EXPECT_EQ(speed(0.1, -0.1), 0);
  EXPECT_LT(speed(Limits::kStickRest + 0.01, 0), 0.01);
  EXPECT_NEAR(speed(1, 0), Limits::kToolSpeed, 1e-9);
  EXPECT_NEAR(speed(0.8, -0.8), Limits::kToolSpeed, 1e-9) << "a corner is no faster";
  for (double x = 0; x < 1; x += 0.05) EXPECT_LE(speed(x, 0), speed(x + 0.05, 0));
}

TEST(GamepadMap, StickAndPictureHaveTheSameUp) {
  const GamepadWish wish = wishOf({.left_stick = {0.6, -0.6}, .right_stick = {0.6, -0.6}}, {}, 0.01);
  EXPECT_GT(wish.tool_mm[0], 0);
  EXPECT_GT(wish.tool_mm[1], 0) << "up";
  EXPECT_GT(wish.orbit[0], 0);
  EXPECT_LT(wish.orbit[1], 0) << "pixels, downwards";
}

TEST(GamepadMap, ContactIsHeavyTheDriveIsFineAndALatchIsRest) {
  HapticReport report;
  EXPECT_EQ(rumbleOf(report, 0), Rumble{}) << "nothing turns";
  const Rumble air = rumbleOf(report, 1);
  EXPECT_EQ(air.strong, 0);
  EXPECT_GT(air.weak, 0.1);
  report.output.normal_load = 1.5;
  const Rumble cuts = rumbleOf(report, -1);
  EXPECT_GT(cuts.strong, 0.4) << "backwards, too";
  EXPECT_GT(cuts.weak, air.weak);
  report.output.normal_load = 100;
  EXPECT_LE(rumbleOf(report, 1).strong, 1);
  report.is_latched = true;
  EXPECT_EQ(rumbleOf(report, 1), Rumble{});
}

TEST(GamepadMap, TheLeftTriggerSlowsBothSticksToAFifth) {
  const GamepadState fast{.left_stick = {1, 0}, .right_stick = {0, 1}};
  GamepadState slow = fast;
  slow.left_trigger = 1;
  EXPECT_NEAR(wishOf(slow, {}, 0.01).tool_mm[0], 0.2 * wishOf(fast, {}, 0.01).tool_mm[0], 1e-12);
  EXPECT_NEAR(wishOf(slow, {}, 0.01).orbit[1], 0.2 * wishOf(fast, {}, 0.01).orbit[1], 1e-12);
  slow.left_trigger = Limits::kTriggerRest;
  EXPECT_EQ(wishOf(slow, {}, 0.01).tool_mm, wishOf(fast, {}, 0.01).tool_mm);
}

TEST(GamepadMap, TheRightTriggerIsThePedalAboveItsRest) {
  const auto pedal = [](double trigger) { return wishOf({.right_trigger = trigger}, {}, 0.01).pedal; };
  EXPECT_EQ(pedal(0), 0);
  EXPECT_EQ(pedal(Limits::kTriggerRest), 0);
  EXPECT_NEAR(pedal(0.55), 0.5, 1e-12);
  EXPECT_EQ(pedal(1), 1);
}

TEST(GamepadMap, AButtonCountsWhenItGoesDown) {
  const GamepadState down{.a = true, .left_bumper = true, .right_bumper = true};
  const GamepadWish pressed = wishOf(down, {}, 0.01), held = wishOf(down, down, 0.01),
                    released = wishOf({}, down, 0.01);
  EXPECT_TRUE(pressed.undoes && pressed.takes_next && pressed.takes_previous);
  EXPECT_FALSE(held.undoes || held.takes_next || held.takes_previous);
  EXPECT_FALSE(released.undoes || released.takes_next || released.takes_previous);
}

TEST(GamepadMap, ASlowFrameMakesNoLeap) {
  EXPECT_NEAR(wishOf({.left_stick = {1, 0}}, {}, 5).tool_mm[0], Limits::kToolSpeed * Limits::kLongest, 1e-12);
  EXPECT_EQ(wishOf({.left_stick = {1, 0}}, {}, -1).tool_mm[0], 0);
}

class GamepadOnABlock : public OnABlock {
 protected:
  void play(const GamepadState& state, double seconds) {
    const auto end = bench_.document->report().tick + static_cast<std::uint64_t>(seconds / kTick);
    until([&] {
      hand_.update(context_, pointer_, state, 0.002);
      return bench_.document->report().tick >= end;
    });
  }
  GamepadHand hand_;
};

TEST_F(GamepadOnABlock, TheTriggerDrillsAndItsReleaseEndsTheStroke) {
  const double nominal = bench_.document->run()->model().tools[0].drive.speed;
  bench_.strokes->setForce(Strokes::kLeastForce);
  pointer_.move(context_, {200, 150}, {});
  play({.right_trigger = 0.55}, 2);
  EXPECT_TRUE(bench_.strokes->isPressed());
  EXPECT_NEAR(bench_.document->report().output.speed / nominal, 0.5, 0.1) << "its value is the pedal";
  EXPECT_GT(bench_.document->removedMm3(), 0);
  play({}, 0.01);
  EXPECT_FALSE(bench_.strokes->isPressed());

  pointer_.move(context_, {2, 2}, {});
  play({.right_trigger = 1}, 0.05);
  EXPECT_FALSE(bench_.strokes->isPressed()) << "in the air there is nothing to cut";
}

TEST_F(GamepadOnABlock, TheStickLeadsTheStrokeAndTurningTheViewDoesNot) {
  pointer_.move(context_, {200, 150}, {});
  const Pixel before = pointer_.at();
  hand_.update(context_, pointer_, GamepadState{.left_stick = {1, 0}}, 0.05);
  EXPECT_NEAR((pointer_.at() - before)[0] * camera_.mmPerPixel(context_.height), 0.05 * Limits::kToolSpeed, 1e-9);

  GamepadState state{.right_trigger = 1};
  hand_.update(context_, pointer_, state, 0.01);
  ASSERT_TRUE(bench_.strokes->isPressed());
  const Vec3d began = bench_.strokes->pointer();
  state.left_stick = {0, -1};
  hand_.update(context_, pointer_, state, 0.05);
  EXPECT_NEAR((bench_.strokes->pointer() - began - Vec3d(0, 0.05 * Limits::kToolSpeed, 0)).norm(), 0, 1e-3);

  const Vec3d led = bench_.strokes->pointer();
  const double azimuth = camera_.azimuth;
  state.left_stick = {0, 0};
  state.right_stick = {1, 0.5};
  hand_.update(context_, pointer_, state, 0.1);
  EXPECT_EQ(bench_.strokes->pointer(), led);
  EXPECT_NE(camera_.azimuth, azimuth);
}

TEST_F(GamepadOnABlock, UnpluggedWhileItDrillsItEndsTheStrokeAndNoOther) {
  pointer_.move(context_, {200, 150}, {});
  play({.right_trigger = 1}, 0.1);
  ASSERT_TRUE(bench_.strokes->isPressed());
  hand_.update(context_, pointer_, {}, 0.01);
  EXPECT_FALSE(bench_.strokes->isPressed());

  ASSERT_TRUE(pointer_.press(context_, {200, 150}));
  hand_.update(context_, pointer_, {}, 0.01);
  EXPECT_TRUE(bench_.strokes->isPressed()) << "the mouse's";
}

TEST_F(GamepadOnABlock, AfterAnUndoTheTriggerHasToGoToRestFirst) {
  pointer_.move(context_, {200, 150}, {});
  play({.right_trigger = 1}, 2);
  ASSERT_GT(bench_.document->removedMm3(), 0);
  play({.right_trigger = 1, .a = true}, 0.5);
  EXPECT_FALSE(bench_.strokes->isPressed());
  EXPECT_NEAR(bench_.document->removedMm3(), 0, 1e-9);
  play({}, 0.01);
  play({.right_trigger = 1}, 0.05);
  EXPECT_TRUE(bench_.strokes->isPressed());
}

}  // namespace
}  // namespace kerf::gamepad_map_test
