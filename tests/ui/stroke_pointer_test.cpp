#include "ui/app/hand/stroke_pointer.h"
#include "ui/app/commands/zoom.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/ui/block_on_bench.h"
#include "ui/app/document/document.h"
#include "ui/app/readout/point_readout.h"
#include "ui/app/workbench/strokes.h"

namespace kerf::stroke_pointer_test {
namespace {

using test::OnABlock;
using test::StrokePointerTest;

TEST_F(StrokePointerTest, AltKeepsTheToolWhereItIsAndTiltsIt) {
  pointer_.move(context_, {200, 150}, {});
  EXPECT_TRUE(bench_.strokes->tilt.isUpright());
  pointer_.move(context_, {260, 150}, {.alt = true});
  EXPECT_EQ(pointer_.at(), Pixel(200, 150));
  EXPECT_NEAR(bench_.strokes->tilt.angle, 30 * kDegree, 1e-9);
  EXPECT_NEAR((bench_.strokes->tilt.towards - camera_.right()).norm(), 0, 1e-9);

  pointer_.move(context_, {261, 150}, {});
  EXPECT_EQ(pointer_.at(), Pixel(261, 150));
  EXPECT_NEAR(bench_.strokes->tilt.angle, 30 * kDegree, 1e-9) << "it holds";
}

TEST_F(StrokePointerTest, TwoTapsOnAltSetItUprightUnlessItWasTiltedBetween) {
  pointer_.move(context_, {0, 0}, {});
  pointer_.tapAlt(context_, 1);
  pointer_.move(context_, {60, 0}, {.alt = true});
  pointer_.tapAlt(context_, 1.2);
  EXPECT_FALSE(bench_.strokes->tilt.isUpright());
  pointer_.tapAlt(context_, 3);
  EXPECT_FALSE(bench_.strokes->tilt.isUpright()) << "too late";
  pointer_.tapAlt(context_, 3.2);
  EXPECT_TRUE(bench_.strokes->tilt.isUpright());
}

TEST_F(OnABlock, CtrlLeadsTheToolAlongItsAxisAloneAndItStaysThere) {
  pointer_.move(context_, {200, 150}, {});
  ASSERT_TRUE(pointer_.press(context_, {200, 150}));
  runToDepth();
  ASSERT_NEAR(*bench_.strokes->depthNow(), 0.6, 0.05);
  const Vec3d pointer = bench_.strokes->pointer();

  pointer_.move(context_, {240, 120}, {.ctrl = true});  // 30 pixels up
  run(1);
  EXPECT_NEAR(*bench_.strokes->depthNow(), 0.3, 0.05);
  EXPECT_EQ(bench_.strokes->pointer(), pointer) << "not sideways";
  pointer_.move(context_, {240, 320}, {.ctrl = true});
  runToDepth();
  EXPECT_NEAR(*bench_.strokes->depthNow(), 0.6, 0.05) << "no deeper than the depth";
  pointer_.move(context_, {240, 0}, {.ctrl = true});
  run(1);
  EXPECT_NEAR(*bench_.strokes->depthNow(), -MouseHand::kClearance, 0.05) << "no higher than over the surface";

  pointer_.move(context_, {250, 0}, {});
  EXPECT_NEAR((bench_.strokes->pointer() - pointer)[0], 10 * camera_.mmPerPixel(context_.height), 0.01)
      << "it is dragged from where it was, not from where the cursor is";
}

// On the top of the block, from above and aslant, with each projection.
TEST_F(OnABlock, APointIsPickedInBothProjectionsAtThePixelWhereItIsSeen) {
  const double top = 0;  // mm; less exact at the surface's edges
  const Vec3d middle = bench_.document->scene().bounds().center();
  for (const double degrees : {0, 20, 60})
    for (const double elevation : {90, 50}) {
      camera_.elevation = elevation * kDegree;
      setFieldOfView(camera_, degrees * kDegree);
      fitToBox(camera_, bench_.document->scene().bounds(), context_.width, context_.height);
      for (const auto& [x, y] : {std::array{0.0, 0.0}, {2.0, 1.0}, {-2.2, 1.3}}) {
        const Vec3d p(middle[0] + x, middle[1] + y, top);
        const auto at = pixelOf(camera_, p, context_.width, context_.height);
        const auto point = readoutAt(bench_, rayUnder(camera_, at[0], at[1], context_.width, context_.height));
        ASSERT_TRUE(point) << degrees << " deg";
        EXPECT_LT((point->point - p).norm(), 0.02) << degrees << " deg, elevation " << elevation;
      }
    }
}

TEST_F(OnABlock, AGrooveDrilledInPerspectiveIsWhereTheCursorWent) {
  const double top = 0;  // mm; less exact at the surface's edges
  const Vec3d middle = bench_.document->scene().bounds().center();
  const Vec3d from(middle[0] - 1.6, middle[1] + 0.8, top), to(middle[0] + 1.6, middle[1] - 0.6, top);
  setFieldOfView(camera_, 60 * kDegree);
  fitToBox(camera_, bench_.document->scene().bounds(), context_.width, context_.height);
  const auto pixel = [&](const Vec3d& p) {
    const auto at = pixelOf(camera_, p, context_.width, context_.height);
    return Pixel(at[0], at[1]);
  };

  pointer_.move(context_, pixel(from), {});
  ASSERT_TRUE(pointer_.press(context_, pixel(from)));
  runToDepth();
  const auto follows = [&](const Vec3d& p) {
    for (int n = 0; n < 20 && (tip() - p).head<2>().norm() > 0.1; ++n) run(0.5);
    return (tip() - p).head<2>().norm() < 0.1;
  };
  EXPECT_TRUE(follows(from)) << tip().transpose();
  constexpr int kSteps = 20;
  for (int n = 1; n <= kSteps; ++n) {
    pointer_.move(context_, pixel(from + n / double(kSteps) * (to - from)), {});
    run(0.3);
  }
  EXPECT_LT((bench_.strokes->pointer() - to).norm(), 0.03);
  EXPECT_TRUE(follows(to)) << tip().transpose();

  // Moved by numbers, it moves sideways in the picture and stays on the surface.
  const Pixel before = pixel(bench_.strokes->pointer());
  pointer_.nudge(context_, -Vec3d::UnitX(), {});
  const Pixel moved = pixel(bench_.strokes->pointer()) - before;
  EXPECT_NEAR(moved[0], -0.1 / camera_.mmPerPixelAt(to, context_.height), 0.3);
  EXPECT_NEAR(moved[1], 0, 0.3);
  EXPECT_NEAR(bench_.strokes->pointer()[2], top, 0.02);
}

TEST_F(OnABlock, ZoomedInInPerspectiveThePointUnderTheCursorStaysAndTheEyeOutside) {
  const double top = 0;  // mm; less exact at the surface's edges
  const Vec3d middle = bench_.document->scene().bounds().center(), p(middle[0] + 2, middle[1] + 1, top);
  setFieldOfView(camera_, 40 * kDegree);
  fitToBox(camera_, bench_.document->scene().bounds(), context_.width, context_.height);
  const auto before = pixelOf(camera_, p, context_.width, context_.height);
  for (int n = 0; n < 30; ++n) zoomAt(context_, before[0], before[1], 1.15);
  const auto after = pixelOf(camera_, p, context_.width, context_.height);
  EXPECT_NEAR(after[0], before[0], 2);
  EXPECT_NEAR(after[1], before[1], 2);
  EXPECT_GT((camera_.target + camera_.eyeDistance() * camera_.backwards())[2], top);
  EXPECT_NEAR(camera_.target[2], top, 0.02) << "the scale bar holds on the surface";
}

TEST_F(OnABlock, ATiltedToolThatIsLedOutGoesBackAlongItsAxis) {
  bench_.strokes->tilt = tiltInView(camera_, 45 * kDegree, 0);
  pointer_.move(context_, {200, 150}, {});
  ASSERT_TRUE(pointer_.press(context_, {200, 150}));
  runToDepth();
  run(3);  // the sideways pull is weaker than the push
  ASSERT_NEAR(*bench_.strokes->depthNow(), 0.6, 0.05);
  const Vec3d deep = tip();
  bench_.strokes->moveAlong(-0.3 * std::sqrt(2));
  run(1);
  EXPECT_NEAR(tip()[2] - deep[2], 0.3, 0.05);
  EXPECT_NEAR(tip()[0] - deep[0], 0.3, 0.08);
}

TEST_F(OnABlock, APedalHoldsTheStrokeAndKeysNudgeItInTheirSteps) {
  pointer_.move(context_, {200, 150}, {});
  EXPECT_FALSE(bench_.strokes->stepOnPedal({})) << "nothing was pointed at";
  ASSERT_TRUE(pointer_.press(context_, {200, 150}));
  ASSERT_TRUE(bench_.strokes->stepOnPedal({}));
  pointer_.release(context_);
  EXPECT_TRUE(bench_.strokes->isPressed()) << "the button may go";
  const Vec3d before = bench_.strokes->pointer();
  pointer_.move(context_, {300, 100}, {});
  EXPECT_EQ(bench_.strokes->pointer(), before) << "the hands are free";

  pointer_.nudge(context_, Vec3d::UnitX(), {});
  pointer_.nudge(context_, Vec3d::UnitY(), {.shift = true});
  EXPECT_NEAR((bench_.strokes->pointer() - before - Vec3d(0.1, 1, 0)).norm(), 0, 1e-3);
  pointer_.nudge(context_, -Vec3d::UnitX(), {.ctrl = true});
  EXPECT_NEAR((bench_.strokes->pointer() - before - Vec3d(0.09, 1, 0)).norm(), 0, 1e-3);
  const auto behind = [&] { return (tip() - bench_.strokes->pointer()).head<2>().norm(); };
  runUntil([&] { return behind() < 0.1; });
  runToDepth();
  EXPECT_LT(behind(), 0.1) << "the tool followed";
  ASSERT_NEAR(*bench_.strokes->depthNow(), 0.6, 0.05);
  pointer_.nudge(context_, -Vec3d::UnitZ(), {});
  runUntil([&] { return *bench_.strokes->depthNow() < 0.53; });
  EXPECT_NEAR(*bench_.strokes->depthNow(), 0.5, 0.05);

  bench_.strokes->release();
  EXPECT_FALSE(bench_.strokes->isOnPedal());
  ASSERT_TRUE(bench_.strokes->stepOnPedal({})) << "where it was last";
  EXPECT_NEAR((bench_.strokes->pointer() - before - Vec3d(0.09, 1, 0)).norm(), 0, 0.02);
}

TEST_F(OnABlock, TheSpindleTurnsAtTheSpeedItIsSetTo) {
  const double nominal = bench_.document->run()->model().tools[0].drive.speed;
  bench_.strokes->setForce(Strokes::kLeastForce);
  pointer_.move(context_, {200, 150}, {});
  for (const double percent : {50, 100, 0}) {
    bench_.strokes->setSpeed(0.01 * percent);
    ASSERT_TRUE(bench_.strokes->isPressed() || pointer_.press(context_, {200, 150}));
    run(percent > 0 ? 2 : 5);
    EXPECT_NEAR(100 * bench_.document->report().output.speed / nominal, percent, 10) << "per cent";
  }
}

TEST_F(OnABlock, TheCommandsSayWhatTheyWereGiven) {
  const auto run_it = [&](const char* id, std::vector<std::string> words) {
    return runAppCommand(context_, id, words);
  };
  EXPECT_FALSE(run_it("cut.nudge", {"0.1", "0", "0"})) << "no stroke";
  EXPECT_FALSE(run_it("cut.pedal", {"perhaps"}));
  EXPECT_FALSE(run_it("cut.pedal", {"on", "2", "2"})) << "beside the block";
  EXPECT_FALSE(run_it("cut.speed", {"120"}));
  ASSERT_TRUE(run_it("cut.pedal", {"on", "200", "150"}));
  const Vec3d before = bench_.strokes->pointer();
  ASSERT_TRUE(run_it("cut.nudge", {"0.5", "-0.25", "0"}));
  EXPECT_NEAR((bench_.strokes->pointer() - before - Vec3d(0.5, -0.25, 0)).norm(), 0, 1e-3);
  ASSERT_TRUE(run_it("cut.pedal", {}));
  EXPECT_FALSE(bench_.strokes->isPressed());
}

}  // namespace
}  // namespace kerf::stroke_pointer_test
