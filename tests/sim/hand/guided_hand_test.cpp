#include "sim/hand/guided_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/tool/saw_blade.h"
#include "geometry/tool/tool_file.h"
#include "sim/hand/mouse_hand.h"
#include "sim/run/scene/load_scene.h"
#include "sim/session/session.h"
#include "tests/sim/block_scene.h"
#include "tests/support/allocation_guard.h"

namespace kerf::guided_hand_test {
namespace {

Tool toolOf(const std::string& id) {
  const auto file = findToolFile(id, defaultToolFolders());
  EXPECT_TRUE(file) << id;
  auto tool = readTool(*file);
  EXPECT_TRUE(tool) << id;
  return *tool;
}

// A saw above a block with its top at z = 0, its blade in the plane x = 0, in lockstep, as on the haptic thread.
class Bench {
 public:
  Bench(const std::string& saw, const Vec3d& block)
      : tool_(toolOf(saw)),
        blade_(*SawBlade::of(tool_)),
        object_(made(block)),
        mouse_(std::shared_ptr<const BrickField>(object_, &object_->phi0()), above(2)),
        hand_(mouse_, 1, 1000),
        session_(*makeModel(std::span(&tool_, 1)), {object_}, above(2)) {}

  Rigid3 above(double z) const { return blade_.poseAt({0, 0, z}, Vec3d::UnitX(), -Vec3d::UnitZ(), false); }

  // Down to z = -depth and out again.
  GuidedCut cutTo(double depth, double force) const {
    GuidedCut cut;
    cut.id = 1;
    cut.is_wanted = true;
    cut.start = above(2);
    cut.force = force;
    cut.ways[0] = {above(0.3).translation, false};
    cut.ways[1] = {above(-depth).translation, true};
    cut.ways[2] = {above(2).translation, false};
    cut.count = 3;
    return cut;
  }
  void begin(const GuidedCut& cut) {
    cut_ = cut;
    hand_.order(cut);
    const Vec3d& p = cut.start.translation;
    const Eigen::Quaterniond& q = cut.start.rotation;
    EXPECT_TRUE(session_.apply(PlaceTool{{p[0], p[1], p[2]}, {q.w(), q.x(), q.y(), q.z()}}));
    hand_.placed(session_.state().body.pose);
  }
  // @return whether the hand was done within that time.
  bool run(double seconds) {
    for (int n = 0; n < seconds / kTick; ++n) {
      sample = hand_.read();
      if (!has_power) sample.pedal = 0;
      session_.tick(sample, out);
      hand_.write(out.force);
      hand_.update();
      removed += out.removed_mm3;
      time += kTick;
      pull = std::max(pull, out.force.force.norm());
      const Vec3d front = out.T_world_tool * blade_.front;
      if (sample.pedal > 0) {
        deepest = std::min(deepest, front[2]);
        aside = std::max(aside, std::abs(front[0]));
        tilt = std::max(tilt, out.T_world_tool.rotation.angularDistance(cut_.start.rotation));
      }
      if (hand_.report().stage == GuidedStage::kOver) return true;
    }
    return false;
  }
  double frontNow() const { return (out.T_world_tool * blade_.front)[2]; }
  GuidedHand& hand() { return hand_; }
  MouseHand& mouse() { return mouse_; }
  Session& session() { return session_; }
  const SawBlade& blade() const { return blade_; }

  bool has_power = true;
  DeviceSample sample;
  StepOutput out;
  double removed = 0, time = 0, pull = 0, deepest = 9, aside = 0, tilt = 0;

 private:
  static std::shared_ptr<const BakedObject> made(const Vec3d& size) {
    auto block = practiceBlock(size, 0.1);
    EXPECT_TRUE(block);
    return *block;
  }
  Tool tool_;
  SawBlade blade_;
  std::shared_ptr<const BakedObject> object_;
  MouseHand mouse_;
  GuidedHand hand_;
  Session session_;
  GuidedCut cut_;
};

TEST(GuidedHand, ItSawsToTheDepthInItsPlaneAndComesOutAgain) {
  for (const char* const saw : {"saw-reciprocating-25", "saw-sagittal-10", "saw-piezo-050", "disc-22"}) {
    Bench bench(saw, {3, 6, 4});
    bench.begin(bench.cutTo(2, 4));
    ASSERT_TRUE(bench.run(60)) << saw;  // a piezo saw is slow
    EXPECT_NEAR(bench.deepest, -2, 0.03) << saw;
    EXPECT_LE(bench.aside, 0.08) << saw << ", mm";
    EXPECT_LE(bench.tilt, 0.01) << saw << ", rad";
    EXPECT_LE(bench.pull, 4.2) << saw << ", N";
    EXPECT_NEAR(bench.frontNow(), 2, 0.1) << saw;
    EXPECT_EQ(bench.hand().report().given_up, 0u) << saw;
    // A slot of 6 x 2 mm. Teeth on an arc leave part of its corners.
    const double slot = bench.blade().kerf * 6 * 2;
    EXPECT_GE(bench.removed, 0.9 * slot) << saw;
    EXPECT_LE(bench.removed, 1.02 * slot) << saw;
  }
}

TEST(GuidedHand, WhereItBreaksThroughItDoesNotRunOn) {
  for (const char* const saw : {"saw-reciprocating-25", "saw-sagittal-10", "disc-22"})
    for (const double force : {2.0, 8.0}) {
      Bench bench(saw, {3, 6, 3});
      bench.begin(bench.cutTo(4, force));
      ASSERT_TRUE(bench.run(30)) << saw;
      EXPECT_GE(bench.deepest, -4.4) << saw << ", " << force << " N";
      EXPECT_LE(bench.deepest, -3.95) << saw << ", " << force << " N";
      EXPECT_LE(bench.aside, 0.1) << saw << ", " << force << " N";
    }
}

TEST(GuidedHand, NeitherForceNorFeedPassesItsBound) {
  Bench bench("saw-sagittal-10", {3, 6, 4});
  GuidedCut cut = bench.cutTo(2, 1);
  cut.feed = 0.5;
  bench.begin(cut);
  bench.run(1.5);  // down to the bone, and into it
  double fastest = 0;
  for (int n = 0; n < 40; ++n) {
    const double before = bench.frontNow();
    bench.run(0.05);
    fastest = std::max(fastest, (before - bench.frontNow()) / 0.05);
  }
  EXPECT_LE(fastest, 0.6) << "mm/s";
  EXPECT_GE(fastest, 0.1) << "mm/s";
  EXPECT_LE(bench.pull, 1.3) << "N";
}

TEST(GuidedHand, BrokenOffItComesOutWithTheDriveOff) {
  Bench bench("saw-reciprocating-25", {3, 6, 4});
  GuidedCut cut = bench.cutTo(3, 4);
  bench.begin(cut);
  ASSERT_FALSE(bench.run(3));
  EXPECT_EQ(bench.sample.pedal, 1);
  EXPECT_LT(bench.frontNow(), -0.5);
  const double removed = bench.removed;

  cut.is_wanted = false;
  bench.hand().order(cut);
  ASSERT_TRUE(bench.run(3));
  EXPECT_EQ(bench.sample.pedal, 0);
  EXPECT_NEAR(bench.frontNow(), 2, 0.1);
  EXPECT_LT(bench.removed - removed, 0.1) << "the drive runs down";
}

TEST(GuidedHand, WhatCannotBeSawnIsLeft) {
  Bench bench("saw-sagittal-10", {3, 6, 4});
  bench.has_power = false;
  bench.begin(bench.cutTo(2, 4));
  ASSERT_TRUE(bench.run(40));
  EXPECT_EQ(bench.hand().report().given_up, 1u);
  EXPECT_GE(bench.hand().report().tries, static_cast<std::uint32_t>(GuidedHand::kMostTries));
  EXPECT_NEAR(bench.frontNow(), 2, 0.1);
}

TEST(GuidedHand, ACutIsOneStroke) {
  Bench bench("saw-reciprocating-25", {3, 6, 4});
  bench.begin(bench.cutTo(1, 4));
  ASSERT_TRUE(bench.run(20));
  bench.run(1);
  ASSERT_TRUE(bench.session().canUndo());
  EXPECT_TRUE(bench.session().apply(Undo{}));
  EXPECT_FALSE(bench.session().canUndo());
}

TEST(GuidedHand, InAPauseItStandsStill) {
  Bench bench("saw-reciprocating-25", {3, 6, 4});
  bench.begin(bench.cutTo(3, 4));
  ASSERT_FALSE(bench.run(3));
  const Vec3d before = bench.hand().read().T_world_device.translation;
  for (int n = 0; n < 200; ++n) {
    bench.hand().write({});
    EXPECT_EQ(bench.hand().read().T_world_device.translation, before);
  }
  ASSERT_TRUE(bench.run(20));
  EXPECT_NEAR(bench.deepest, -3, 0.03);
}

TEST(GuidedHand, WhileNothingIsRenderedItDoesNotRunAheadOfTheTool) {
  Bench bench("saw-reciprocating-25", {3, 6, 4});
  bench.begin(bench.cutTo(3, 4));
  bench.run(0.05);  // still in air
  const Vec3d before = bench.hand().read().T_world_device.translation;
  for (int n = 0; n < 5000; ++n) {
    bench.hand().write({});
    bench.hand().read();
  }
  EXPECT_LE((bench.hand().read().T_world_device.translation - before).norm(), 0.2) << "latched, it waits";
}

TEST(GuidedHand, ThePersonsHandIsAskedUntilACutBeginsAndAfterIt) {
  Bench bench("saw-sagittal-10", {3, 6, 4});
  const Rigid3 elsewhere = bench.above(5);
  bench.hand().placed(elsewhere);
  EXPECT_EQ(bench.hand().read().T_world_device.translation, elsewhere.translation);

  GuidedCut cut = bench.cutTo(1, 4);
  bench.hand().order(cut);
  EXPECT_EQ(bench.hand().read().pedal, 0) << "ordered, but the tool was not placed yet";
  bench.begin(cut);
  bench.run(0.1);
  EXPECT_EQ(bench.sample.pedal, 1);

  bench.hand().placed(elsewhere);  // for a stroke by mouse
  EXPECT_EQ(bench.hand().read().T_world_device.translation, elsewhere.translation);
  EXPECT_EQ(bench.hand().read().pedal, 0);
  bench.hand().update();
  EXPECT_EQ(bench.hand().report().stage, GuidedStage::kNone);
}

TEST(GuidedHand, ItIsAtRestFromTheEndOfACutToTheNext) {
  Bench bench("saw-sagittal-10", {3, 6, 4});
  EXPECT_TRUE(bench.hand().isAtRest()) << "the mouse";
  GuidedCut cut = bench.cutTo(1, 8);
  bench.begin(cut);
  EXPECT_FALSE(bench.run(0.2));
  EXPECT_FALSE(bench.hand().isAtRest());
  ASSERT_TRUE(bench.run(30));
  EXPECT_TRUE(bench.hand().isAtRest());
  const Rigid3 over = bench.hand().read().T_world_device;
  for (int n = 0; n < 500; ++n) bench.hand().write({});
  EXPECT_EQ(bench.hand().read().T_world_device.translation, over.translation) << "it stands still";
  ++cut.id;
  bench.begin(cut);
  EXPECT_FALSE(bench.hand().isAtRest());
}

TEST(GuidedHand, ReadsWithoutAllocating) {
  Bench bench("saw-sagittal-10", {3, 6, 4});
  const GuidedCut cut = bench.cutTo(1, 4);
  const AllocationGuard guard;
  bench.hand().order(cut);
  bench.hand().placed(cut.start);
  for (int n = 0; n < 2000; ++n) {
    bench.hand().read();
    bench.hand().write({{0, 0, 0.5}, {1, 0, 0}});
    bench.hand().update();
  }
}

}  // namespace
}  // namespace kerf::guided_hand_test
