#include "ui/app/hand/space_mouse_map.h"

#include <gtest/gtest.h>

#include "tests/ui/block_on_bench.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/strokes.h"

namespace kerf::space_mouse_map_test {
namespace {

using Limits = SpaceMouseLimits;
using test::OnABlock;

constexpr SpaceMouseSettings kTool{.leads = SpaceMouseLeads::kTool};
constexpr SpaceMouseSettings kView{.leads = SpaceMouseLeads::kView};

SpaceMouseWish wishFor(const std::array<double, 6>& axes, const SpaceMouseSettings& settings, double seconds = 0.01) {
  return wishOf({axes, 0}, {}, settings, Camera{.half_height = 5}, 400, seconds);
}

TEST(SpaceMouseMap, NearItsMiddleAnAxisIsAtRestAndFromThereThereIsNoStep) {
  EXPECT_EQ(settledAxes({0.05, -0.05, 0, 0, 0, 0}, kTool), (std::array<double, 6>{}));
  EXPECT_NEAR(settledAxes({0.051, 0, 0, 0, 0, 0}, kTool)[0], 0, 0.002);
  EXPECT_DOUBLE_EQ(settledAxes({0, -1, 0, 0, 0, 0}, kTool)[1], -1);
  EXPECT_DOUBLE_EQ(settledAxes({0, 7, 0, 0, 0, 0}, kTool)[1], 1) << "whatever a device says";
}

TEST(SpaceMouseMap, InvertedAxesGoTheOtherWayAndOnlyTheLargestCountsIfSoWanted) {
  SpaceMouseSettings settings = kTool;
  settings.dead_band = 0;
  settings.is_inverted[3] = true;
  EXPECT_EQ(settledAxes({0.5, 0, 0, 0.6, 0, 0}, settings), (std::array<double, 6>{0.5, 0, 0, -0.6, 0, 0}));
  settings.is_dominant = true;
  EXPECT_EQ(settledAxes({0.5, 0, 0, 0.6, 0, 0}, settings), (std::array<double, 6>{0, 0, 0, -0.6, 0, 0}));
}

TEST(SpaceMouseMap, TheToolGoesByWhatThePictureShowsAndNeverFasterThanTheHand) {
  const SpaceMouseWish wish = wishFor({0.5, -0.5, 0, 0, 0, 0}, kTool);
  const double half = (0.5 - 0.05) / 0.95;
  EXPECT_NEAR(wish.tool_mm[0], 0.01 * half * Limits::kViewHeights * 10, 1e-12) << "the picture is 10 mm high";
  EXPECT_NEAR(wish.tool_mm[1], -wish.tool_mm[0], 1e-12);
  SpaceMouseSettings fast = kTool;
  fast.gain = 4;
  EXPECT_NEAR(wishFor({1, 1, 0, 0, 0, 0}, fast).tool_mm.norm(), 0.01 * Limits::kToolSpeed, 1e-12);
}

TEST(SpaceMouseMap, PressedDownItDrillsOnlyBeyondARest) {
  EXPECT_EQ(wishFor({0, 0, -0.3, 0, 0, 0}, kTool).pedal, 0);
  EXPECT_EQ(wishFor({0, 0, -1, 0, 0, 0}, kTool).pedal, 1);
  EXPECT_EQ(wishFor({0, 0, 1, 0, 0, 0}, kTool).pedal, 0) << "pulled up";
  EXPECT_EQ(wishFor({0, 0, -1, 0, 0, 0}, kView).pedal, 0) << "it leads the view";
}

TEST(SpaceMouseMap, OfTheViewTheObjectGoesWithTheKnob) {
  const SpaceMouseWish wish = wishFor({1, 1, 1, 1, 1, 1}, kView, 0.1);
  EXPECT_GT(wish.pan[0], 0) << "to the right";
  EXPECT_LT(wish.pan[1], 0) << "up: pixels count downwards";
  EXPECT_LT(wish.zoom, 1) << "away";
  EXPECT_GT(wish.orbit[0], 0);
  EXPECT_TRUE(wish.tool_mm.isZero(0));
}

TEST(SpaceMouseMap, LeadingNothingItLeadsNothingAndASlowFrameMakesNoLeap) {
  SpaceMouseSettings off = kTool;
  off.leads = SpaceMouseLeads::kNothing;
  const SpaceMouseWish wish = wishFor({1, 1, -1, 1, 1, 1}, off);
  EXPECT_TRUE(wish.tool_mm.isZero(0) && wish.orbit.isZero(0) && wish.pan.isZero(0) && wish.pedal == 0);
  EXPECT_EQ(wishFor({1, 0, 0, 0, 0, 0}, kTool, 60).tool_mm, wishFor({1, 0, 0, 0, 0, 0}, kTool, 0.1).tool_mm);
}

class SpaceMouseOnABlock : public OnABlock {
 protected:
  void play(const std::optional<SpaceMouseState>& state, double seconds) {
    const auto end = bench_.document->report().tick + static_cast<std::uint64_t>(seconds / kTick);
    until([&] {
      hand_.update(context_, pointer_, kTool, state, 0.002);
      return bench_.document->report().tick >= end;
    });
  }
  SpaceMouseHand hand_;
};

TEST_F(SpaceMouseOnABlock, PressedItDrillsLedItMovesAndButtonTwoTakesItBack) {
  bench_.strokes->setForce(Strokes::kLeastForce);
  pointer_.move(context_, {200, 150}, {});
  play(SpaceMouseState{{0, 0, -1, 0, 0, 0}}, 2);
  ASSERT_TRUE(bench_.strokes->isPressed());
  EXPECT_GT(bench_.document->removedMm3(), 0);

  const Vec3d began = bench_.strokes->pointer();
  hand_.update(context_, pointer_, kTool, SpaceMouseState{{0, 1, -1, 0, 0, 0}}, 0.05);
  EXPECT_GT((bench_.strokes->pointer() - began).dot(context_.camera.up()), 0.01) << "pushed away: up in the picture";

  play(SpaceMouseState{}, 0.05);
  EXPECT_FALSE(bench_.strokes->isPressed());
  play(SpaceMouseState{{}, 2}, 0.5);
  EXPECT_NEAR(bench_.document->removedMm3(), 0, 1e-9);
}

TEST_F(SpaceMouseOnABlock, UnpluggedWhileItDrillsItEndsTheStrokeAndLosesNothing) {
  pointer_.move(context_, {200, 150}, {});
  play(SpaceMouseState{{0, 0, -1, 0, 0, 0}}, 1);
  ASSERT_TRUE(bench_.strokes->isPressed());
  play({}, 0.05);
  EXPECT_FALSE(bench_.strokes->isPressed());
  EXPECT_GT(bench_.document->removedMm3(), 0);
}

}  // namespace
}  // namespace kerf::space_mouse_map_test
