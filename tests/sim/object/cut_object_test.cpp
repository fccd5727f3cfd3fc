#include "sim/object/cut_object.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "sim/session/session_history.h"
#include "tests/sim/block_scene.h"
#include "tests/support/allocation_guard.h"

namespace kerf::cut_object_test {
namespace {

using test::block;

double sum(const std::array<double, 256>& volumes) {
  double total = 0;
  for (const double v : volumes) total += v;
  return total;
}

TEST(PointShell, AreaOfABallIsRightWhateverTheVoxelAndWhereItLies) {
  for (const double h : {0.1, 0.05})
    for (const double offset : {0.0, 0.031, 0.077}) {
      const Vec3d center(offset, -0.4 * offset, 1.7 * offset);
      Box3 box;
      box.add(Vec3d(center.array() - 1.01));
      box.add(Vec3d(center.array() + 1.01));
      const auto ball = test::bakedFrom([&](const Vec3d& p) { return (p - center).norm() - 1; }, box, h);
      double area = 0;
      Vec3d closed = Vec3d::Zero();
      std::vector<ShellChunk> shell(kShellChunks);
      for (const BakedObject::Slot& slot : ball->slots()) {
        const int nodes = ball->shellOf(slot, shell.data());
        ASSERT_EQ(nodes, slot.shell_count);
        for (std::size_t n = 0; n < static_cast<std::size_t>(nodes); ++n) {
          const ShellChunk& chunk = shell[n / ShellChunk::kNodes];
          const std::size_t at = n % ShellChunk::kNodes;
          const Vec3d w(chunk.x[at], chunk.y[at], chunk.z[at]);
          area += w.norm();
          closed += w;
        }
      }
      EXPECT_NEAR(area / (4 * M_PI), 1, h == 0.1 ? 0.003 : 0.001) << h << " " << offset;
      EXPECT_LT(closed.norm(), 5e-4 * area);  // area vectors of a closed surface sum to zero
    }
}

TEST(PointShell, NormalsPointOutOfTheTissue) {
  const auto object = block({4, 4, 2}, 0.1);
  std::vector<ShellChunk> shell(kShellChunks);
  for (const BakedObject::Slot& slot : object->slots()) {
    const auto nodes = static_cast<std::size_t>(object->shellOf(slot, shell.data()));
    for (std::size_t n = 0; n < nodes; ++n) {
      const ShellChunk& chunk = shell[n / ShellChunk::kNodes];
      const int offset = chunk.offset[n % ShellChunk::kNodes];
      const Vec3i at = 8 * slot.brick + Vec3i(offset >> 6, offset >> 3 & 7, offset & 7);
      const Vec3d p = 0.1 * at.cast<double>();
      if (std::abs(p[0]) < 1.5 && std::abs(p[1]) < 1.5 && p[2] > -0.5) {
        ASSERT_GT(chunk.z[n % ShellChunk::kNodes], 0);
      }
    }
  }
}

// Two chunks more than the longest shell: every shell replaces earlier ones.
TEST(LoadedShells, AreThoseOfTheValuesHoweverOftenTheyAreMade) {
  const auto baked = block({3, 2, 2}, 0.1, {Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Vec3d::UnitX())), {0, 0, 0}});
  BrickStore bricks(baked, BrickStore::Begin::kWithAllBricks);
  LoadedShells shells;
  shells.reserve(*baked, kShellChunks + 2);
  std::vector<ShellChunk> expected(kShellChunks);
  int made = 0, dropped = 0;
  for (int s = 0; s < bricks.slotCount(); ++s) {
    if (bricks.slot(s).shell_count == 0) continue;
    shells.make(bricks, s);
    ++made;
    // All slots with a shell have the right one.
    for (int other = 0; other <= s; ++other) {
      const BrickSlot& slot = bricks.slot(other);
      if (slot.shell_count == 0) continue;
      dropped += slot.shell == nullptr;
      if (slot.shell == nullptr) continue;
      const BakedObject::Slot& loaded = baked->slots()[static_cast<std::size_t>(other)];
      ASSERT_EQ(baked->shellOf(loaded, expected.data()), slot.shell_count);
      for (int c = 0; c < chunkCount(slot.shell_count); ++c) {
        const auto at = static_cast<std::size_t>(c);
        ASSERT_EQ(slot.chunk(at).x, expected[at].x);
        ASSERT_EQ(slot.chunk(at).phi, expected[at].phi);
        ASSERT_EQ(slot.chunk(at).offset, expected[at].offset);
      }
    }
    ASSERT_NE(bricks.slot(s).shell, nullptr);
  }
  EXPECT_GT(made, 50);
  EXPECT_GT(dropped, 1000);
  EXPECT_EQ(bricks.shellDefects(), 0u);
}

TEST(CutObject, FindsEveryBrickAndNoOther) {
  CutObject object(block({3, 2, 2}, 0.1, {Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Vec3d::UnitX())), {0, 0, 0}}), 64);
  for (int s = 0; s < object.slotCount(); ++s) ASSERT_EQ(object.find(object.slot(s).brick), s);
  EXPECT_EQ(object.find({1000, 0, 0}), -1);
  EXPECT_EQ(object.find({-1000, -1000, 1 << 30}), -1);
}

// After 10 000 ticks a session equals a rebuild from the field alone.
TEST(CutObject, AfterTenThousandRandomCarvesShellAndLedgerAreThoseOfAFullRebuild) {
  Model model;
  model.tools = {practiceBall(0.35, 840)};
  model.tissues = test::oneTissue(200, 0.5, 1000);
  model.settings.rendering = Rendering::kRigid;
  State state;
  const Rigid3 askew{Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3d(1, 2, -1).normalized())), {0, 0, 0}};
  state.objects.emplace_back(block({4, 4, 3}, 0.08, askew));
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(-1, 1);
  StepOutput out;
  Vec3d at(0, 0, 0.5), velocity(0.02, 0, -0.02);
  double removed = 0;

  for (int tick = 0; tick < 10000; ++tick) {
    velocity += 0.01 * Vec3d(u(random), u(random), u(random)) - 0.0005 * (at - Vec3d(0, 0, -0.6));
    velocity *= std::min(1.0, 0.08 / velocity.norm());
    at += velocity;
    step(model, state, test::sampleAt({askew.rotation, askew * at}), out);
    removed += out.removed_mm3;
    ASSERT_EQ(out.status, kStepOk) << tick;
  }

  const CutObject& object = state.objects[0];
  EXPECT_GT(removed, 5);
  EXPECT_EQ(object.bricks().shellDefects(), 0u);
  const double initial = sum(object.baked().volumes()), remaining = sum(object.bricks().countVolumes());
  EXPECT_NEAR(sum(object.removed_mm3) + remaining, initial, 1e-6 * initial);
  EXPECT_NEAR(sum(object.removed_mm3), removed, 1e-9);
}

TEST(CutObject, WithoutMemoryNothingIsLostOnlyLate) {
  const auto baked = block({4, 4, 2}, 0.1);
  Model model;
  model.tools = {practiceBall(0.5, 840)};
  model.tissues = test::oneTissue(200, 0.5, 1000);
  model.settings.rendering = Rendering::kRigid;
  model.settings.geometry_only = true;
  const auto dig = [&](State& state, int ticks) {
    StepOutput out;
    std::uint32_t status = 0;
    for (int n = 0; n < ticks; ++n) {
      step(model, state, test::sampleAt({Eigen::Quaterniond::Identity(), {0.013, 0.027, -0.8}}), out);
      status |= out.status;
    }
    return status;
  };

  State poor, rich;
  poor.objects.emplace_back(baked, 3);
  rich.objects.emplace_back(baked, 4096);
  EXPECT_TRUE(dig(poor, 2) & kStepBricksRanOut);
  EXPECT_EQ(poor.objects[0].bricks().shellDefects(), 0u);  // any volume that can be cut can be felt
  EXPECT_FALSE(dig(rich, 3) & kStepBricksRanOut);

  EXPECT_NE(poor.objects[0].stateHash(), rich.objects[0].stateHash());

  ASSERT_TRUE(poor.objects[0].reserve(4096));
  EXPECT_FALSE(dig(poor, 1) & kStepBricksRanOut);
  EXPECT_EQ(poor.objects[0].stateHash(), rich.objects[0].stateHash());
  EXPECT_EQ(poor.objects[0].bricks().shellDefects(), 0u);
}

TEST(CutObject, RestoredBricksAreTheOldOnesBitForBit) {
  Model model;
  model.tools = {practiceBall(0.5, 840)};
  model.tissues = test::oneTissue(200, 0.5, 1000);
  model.settings.rendering = Rendering::kRigid;
  State state;
  state.objects.emplace_back(block({4, 4, 2}, 0.1));
  CutObject& object = state.objects[0];
  const std::uint64_t untouched = object.stateHash();

  StepOutput out;
  for (int n = 0; n < 50; ++n)
    step(model, state, test::sampleAt({Eigen::Quaterniond::Identity(), {0, 0, -0.01 * n}}), out);
  EXPECT_NE(object.stateHash(), untouched);

  for (int s = 0; s < object.slotCount(); ++s)
    if (object.slot(s).own) {
      BrickValues values;
      std::copy_n(object.slot(s).baked, kBrickNodes, values.begin());
      ASSERT_TRUE(object.restore(s, values, nullptr));
    }
  ASSERT_TRUE(object.repair());
  EXPECT_EQ(object.stateHash(), untouched);
  EXPECT_EQ(object.bricks().shellDefects(), 0u);
}

TEST(CutObject, MemoryMadeElsewhereIsTakenAndUsedWithoutAllocating) {
  CutObject object(block({4, 4, 2}, 0.1), 2);
  auto pool = BrickPool::make(100);
  ASSERT_TRUE(pool);
  const AllocationGuard guard;
  EXPECT_TRUE(object.write(0) && object.write(1));
  EXPECT_FALSE(object.write(2));
  EXPECT_TRUE(object.repair());
  EXPECT_EQ(object.freeBricks(), 0u);
  object.memory().take(std::move(pool));
  EXPECT_EQ(object.freeBricks(), 100u);
  EXPECT_TRUE(object.write(2));
  EXPECT_EQ(object.freeBricks(), 99u);
}

TEST(CutObject, EverySubscriberIsGivenEachChangedBrickOnceTheLastFirst) {
  CutObject object(block({4, 4, 2}, 0.1));
  const auto taken = [&](BrickSubscriber who, bool is_wanted = true) {
    std::vector<int> slots;
    object.changes(who).take([&](const CutObject::Slot& slot) {
      slots.push_back(object.find(slot.brick));
      return is_wanted;
    });
    return slots;
  };
  for (const int s : {3, 1, 2, 1}) ASSERT_TRUE(object.write(s));
  EXPECT_EQ(object.changes(BrickSubscriber::kMesher).count(), 3u);
  EXPECT_EQ(taken(BrickSubscriber::kMesher), (std::vector<int>{2, 1, 3}));
  EXPECT_TRUE(object.changes(BrickSubscriber::kMesher).isEmpty());

  // The other subscriber has no report yet. Its unwanted changes wait.
  EXPECT_EQ(taken(BrickSubscriber::kPieces, false), (std::vector<int>{2}));
  ASSERT_TRUE(object.write(1));
  EXPECT_EQ(taken(BrickSubscriber::kPieces), (std::vector<int>{2, 1, 3}));
  EXPECT_EQ(taken(BrickSubscriber::kMesher), (std::vector<int>{1})) << "it changed again";
}

// Digs at random places, with strokes ended, undone and redone, as in a session.
struct Digger {
  Digger() : state() {
    model.tools = {practiceBall(0.4, 840)};
    model.tissues = test::oneTissue(200, 0.5, 1000);
    model.settings.rendering = Rendering::kRigid;
    model.settings.geometry_only = true;
    state.objects.emplace_back(block({5, 5, 2}, 0.1));
    EXPECT_TRUE(state.objects[0].reserve(4096));  // more strokes than records in a pool for its bricks alone
  }
  CutObject& object() { return state.objects[0]; }
  void dig(double x, double y) {
    StepOutput out;
    state.place({Eigen::Quaterniond::Identity(), {x, y, 0}});
    for (int n = 0; n < 20; ++n)
      step(model, state, test::sampleAt({Eigen::Quaterniond::Identity(), {x, y, -0.03 * n}}), out);
  }
  Model model;
  State state;
};

TEST(CutObject, TheHashKeptUpToDateIsThatOfTheWholeField) {
  Digger digger;
  CutObject& object = digger.object();
  SessionHistory history(digger.state.objects);
  EXPECT_EQ(object.hashNow(), object.stateHash());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-2, 2);

  for (int stroke = 0; stroke < 30; ++stroke) {
    digger.dig(u(random), u(random));
    object.prepareHash(random() % 20, random() % 8);
    if (stroke % 3 == 0) {
      EXPECT_EQ(object.hashNow(), object.stateHash()) << stroke;
      EXPECT_EQ(object.staleHashes(), 0u);
    }
    history.mark(digger.state.objects);
    if (stroke % 4 == 1) {
      history.undo(digger.state.objects);
      object.repair();
    }
    if (stroke % 8 == 1) {
      history.redo(digger.state.objects);
      object.repair();
    }
  }

  EXPECT_EQ(object.hashNow(), object.stateHash());
  while (history.undo(digger.state.objects)) object.repair();
  EXPECT_EQ(object.hashNow(), object.stateHash());
  EXPECT_EQ(object.hashNow(), CutObject(block({5, 5, 2}, 0.1), 1).stateHash()) << "as baked again";
}

TEST(CutObject, PreparingTheHashIsBoundedAndLeavesWhatStillChanges) {
  Digger digger;
  CutObject& object = digger.object();
  digger.dig(0, 0);
  const std::size_t stale = object.staleHashes();
  ASSERT_GT(stale, 10u);
  object.prepareHash(1000, 1000);
  EXPECT_EQ(object.staleHashes(), stale) << "all of them changed a moment ago";
  object.prepareHash(7, 0);
  EXPECT_EQ(object.staleHashes(), stale - 7);
  EXPECT_EQ(object.hashNow(), object.stateHash());
}

TEST(SessionHistory, BeginsWithTheObjectsAsTheyAre) {
  Digger digger;
  digger.dig(0, 0);
  SessionHistory history(digger.state.objects);
  EXPECT_FALSE(history.hasChanges(digger.state.objects));
  const std::uint64_t begun = digger.object().stateHash();
  digger.dig(0.3, 0);
  EXPECT_TRUE(history.hasChanges(digger.state.objects));
  history.mark(digger.state.objects);
  EXPECT_TRUE(history.undo(digger.state.objects));
  EXPECT_EQ(digger.object().stateHash(), begun);
  EXPECT_FALSE(history.undo(digger.state.objects));
}

TEST(SessionHistory, MarkingUndoAndRedoNeitherAllocateNorFree) {
  Digger digger;
  CutObject& object = digger.object();
  SessionHistory history(digger.state.objects);
  digger.dig(-1, 0);
  history.mark(digger.state.objects);
  const std::uint64_t once = object.stateHash();
  digger.dig(-0.7, 0.1);
  history.mark(digger.state.objects);
  const std::uint64_t twice = object.stateHash();
  EXPECT_GT(history.bytes(), 20 * sizeof(BrickValues));

  const std::size_t free = object.freeBricks();
  std::uint64_t undone = 0, redone = 0;
  {
    const AllocationGuard guard;
    EXPECT_TRUE(history.undo(digger.state.objects) && object.repair());
    undone = object.hashNow();
    EXPECT_TRUE(history.redo(digger.state.objects) && object.repair());
    redone = object.hashNow();
    EXPECT_TRUE(history.undo(digger.state.objects) && object.repair());
    digger.dig(1, 1);
    history.mark(digger.state.objects);
  }

  EXPECT_EQ(undone, once);
  EXPECT_EQ(redone, twice);
  EXPECT_EQ(object.bricks().shellDefects(), 0u);
  EXPECT_EQ(history.redoable(), 0u);
  EXPECT_GT(object.freeBricks() + 40, free) << "what could be redone gave its memory back";
}

TEST(SessionHistory, ForgetsTheOldestStrokeAndKeepsTheOthersRight) {
  Digger digger;
  CutObject& object = digger.object();
  SessionHistory history(digger.state.objects);
  digger.dig(-1, 0);
  history.mark(digger.state.objects);
  const std::uint64_t once = object.stateHash();
  digger.dig(-0.8, 0);
  for (std::size_t n = 0; n < SessionHistory::kMostSteps; ++n) history.mark(digger.state.objects);
  EXPECT_EQ(history.undoable(), SessionHistory::kMostSteps);
  const UndoList list = history.list(digger.state.objects);
  EXPECT_EQ(list.undoable, SessionHistory::kMostSteps);
  EXPECT_EQ(list.forgotten, 1u);
  EXPECT_EQ(list.newest.back().number, SessionHistory::kMostSteps + 1);
  while (history.undo(digger.state.objects)) object.repair();
  EXPECT_EQ(object.stateHash(), once);
}

}  // namespace
}  // namespace kerf::cut_object_test
