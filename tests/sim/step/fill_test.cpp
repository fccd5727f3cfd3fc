// Adding material: composite into a cavity, wax onto a surface.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "sim/session/session.h"
#include "tests/sim/block_scene.h"
#include "tests/support/allocation_guard.h"

namespace kerf::fill_test {
namespace {

constexpr auto kDentin = static_cast<std::size_t>(Material::kDentin);
constexpr auto kComposite = static_cast<std::size_t>(Material::kComposite);

Rigid3 at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), {x, y, z}}; }

Model oneBall(double radius, double stiffness = 200) {
  Model model;
  model.tools = {practiceBall(radius, 840)};
  model.tissues = test::oneTissue(stiffness, 0.3, 1000);
  model.settings.rendering = Rendering::kRigid;
  return model;
}

void expectLedgerBalances(const CutObject& object) {
  const std::array<double, 256> now = object.bricks().countVolumes();
  double whole = 0;
  for (const double v : object.baked().volumes()) whole += v;
  for (std::size_t m = 0; m < 256; ++m)
    EXPECT_NEAR(object.baked().volumes()[m] - object.removed_mm3[m] + object.added_mm3[m], now[m], 1e-9 * whole) << m;
}

TEST(Fill, ABallInTheAirIsABallOfItsMaterial) {
  const Model model = oneBall(0.5);
  State state;
  state.objects.emplace_back(test::block({4, 4, 2}, 0.05));
  state.adds = Material::kComposite;
  StepOutput out;
  // Its middle lies 0.9 mm above the block: its tip is the tool's origin.
  step(model, state, test::sampleAt(at(0.3, 0.2, 0.4)), out);
  const double ball = 4.0 / 3 * std::numbers::pi * 0.125;
  EXPECT_NEAR(out.added_mm3, ball, 0.01 * ball);
  EXPECT_EQ(out.removed_mm3, 0);
  EXPECT_EQ(out.status & (kStepFillClipped | kStepBricksRanOut), 0u);
  CutObject& object = state.objects[0];
  EXPECT_NEAR(object.bricks().countVolumes()[kComposite], ball, 0.01 * ball);
  EXPECT_EQ(object.removed_mm3[kDentin], 0);
  EXPECT_EQ(object.bricks().shellDefects(), 0u);
  expectLedgerBalances(object);
  // A repetition adds nothing and changes no bit.
  const std::uint64_t hash = object.stateHash();
  step(model, state, test::sampleAt(at(0.3, 0.2, 0.4)), out);
  EXPECT_EQ(out.added_mm3, 0);
  EXPECT_EQ(object.stateHash(), hash);
}

TEST(Fill, ACavityFilledUpIsWholeAgainAndOfTheFillingsMaterial) {
  Session session(oneBall(0.6), {test::block({5, 4, 3}, 0.1)}, at(0, 0, 0.5));
  const CutObject& object = session.state().objects[0];
  StepOutput out;
  const auto dip = [&](double depth) {
    for (int n = 0; n <= 400; ++n) {
      const double down = n < 200 ? n / 200.0 : (400 - n) / 200.0;
      session.tick(test::sampleAt(at(0, 0, 0.5 - (0.5 + depth) * down), n < 400 ? 1 : 0), out);
    }
  };

  const std::uint64_t untouched = object.stateHash();
  dip(1);
  const double removed = object.removed_mm3[kDentin];
  ASSERT_GT(removed, 0.3);
  const std::uint64_t drilled = object.stateHash();
  ASSERT_TRUE(session.apply(AddMaterial{11, 0}));
  dip(1.02);
  ASSERT_TRUE(session.apply(StopAdding{}));

  // The whole cavity, and the ball's overlap above and beside it.
  EXPECT_GT(object.added_mm3[kComposite], removed);
  expectLedgerBalances(object);
  EXPECT_EQ(object.bricks().shellDefects(), 0u);
  // The filling can be drilled like any tissue, with its own material.
  const double before = object.removed_mm3[kComposite];
  dip(0.5);
  EXPECT_GT(object.removed_mm3[kComposite], before + 0.1);
  expectLedgerBalances(object);

  // Undo covers filling and drilling alike.
  ASSERT_TRUE(session.apply(Undo{}));
  ASSERT_TRUE(session.apply(Undo{}));
  EXPECT_EQ(object.stateHash(), drilled);
  EXPECT_EQ(object.removed_mm3[kDentin], removed);
  EXPECT_EQ(object.added_mm3[kComposite], 0);
  ASSERT_TRUE(session.apply(Undo{}));
  EXPECT_EQ(object.stateHash(), untouched);
  EXPECT_FALSE(session.apply(Undo{}));
  for (int n = 0; n < 3; ++n) ASSERT_TRUE(session.apply(Redo{}));
  expectLedgerBalances(object);
}

TEST(Fill, WhileItAddsTheToolIsNotFeltAndAfterwardsItFadesIn) {
  Model model = oneBall(0.5);
  model.settings.rendering = Rendering::kCoupled;
  Session session(std::move(model), {test::block({4, 4, 2}, 0.1)}, at(0, 0, 0.6));
  ASSERT_TRUE(session.apply(AddMaterial{11, 0}));
  StepOutput out;
  for (int n = 0; n < 900; ++n) {
    session.tick(test::sampleAt(at(0, 0, std::max(0.6 - 0.001 * n, -0.2))), out);
    EXPECT_EQ(out.normal_load, 0);
    EXPECT_LT(out.force.force.norm(), 0.01);
  }
  EXPECT_GT(session.state().objects[0].added_mm3[kComposite], 0.5);
  EXPECT_EQ(session.state().objects[0].removed_mm3[kDentin], 0);
  // The tool sits inside its added material, which is now hard, and the hand must not be struck.
  ASSERT_TRUE(session.apply(StopAdding{}));
  session.tick(test::sampleAt(at(0, 0, -0.2), 0), out);
  EXPECT_GT(out.normal_load, 0.5);
  EXPECT_LT(out.force.force.norm(), 0.1);
}

TEST(Fill, ItIsSaidWhereNothingCanBeAdded) {
  const Model model = oneBall(0.5);
  State state;
  state.objects.emplace_back(test::block({2, 2, 1}, 0.1));
  state.adds = Material::kComposite;
  StepOutput out;
  std::uint32_t near = 0, far = 0;
  step(model, state, test::sampleAt(at(0, 0, 0.9)), out);
  near = out.status;
  step(model, state, test::sampleAt(at(0, 0, 9)), out);
  far = out.status;
  EXPECT_EQ(near & kStepFillClipped, 0u);
  EXPECT_NE(far & kStepFillClipped, 0u);
  EXPECT_EQ(state.objects[0].bricks().shellDefects(), 0u);
  expectLedgerBalances(state.objects[0]);
}

TEST(Fill, AfterManyRandomAddsAndCutsShellAndLedgerAreThoseOfARebuild) {
  Model model = oneBall(0.35, 400);
  State state;
  state.objects.emplace_back(test::block({3, 3, 1.5}, 0.1), 4096);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-1.4, 1.4), height(-0.6, 0.9);
  StepOutput out;
  double added = 0, removed = 0;
  {
    const AllocationGuard guard;
    for (int n = 0; n < 3000; ++n) {
      state.adds = n / 30 % 2 ? Material::kComposite : Material::kNone;
      state.has_device = n % 30 != 0;  // no sweep from the last place
      step(model, state, test::sampleAt(at(place(random), place(random), height(random))), out);
      added += out.added_mm3;
      removed += out.removed_mm3;
    }
  }
  EXPECT_GT(added, 1);
  EXPECT_GT(removed, 0.2);  // one tick in each place: most of its ticks move only the field, not the surface
  EXPECT_EQ(state.objects[0].bricks().shellDefects(), 0u);
  expectLedgerBalances(state.objects[0]);
}

}  // namespace
}  // namespace kerf::fill_test
