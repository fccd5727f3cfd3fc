#include "sim/session/session.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <filesystem>

#include "sim/run/files/log_sink.h"
#include "sim/run/report/replay.h"
#include "tests/sim/block_scene.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/temporary_file.h"

namespace kerf::session_test {
namespace {

Model twoBalls() {
  Model model;
  model.tools = {practiceBall(0.5, 840), practiceBall(0.3, 840)};
  model.tissues = test::oneTissue(200, 0.3, 1000);
  return model;
}

Rigid3 at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), {x, y, z}}; }

// A dab: down to `depth` beside the last one with the pedal pressed, and up again.
void dab(Session& session, double x, double depth) {
  StepOutput out;
  for (int n = 0; n <= 200; ++n) {
    const double down = n < 100 ? n / 100.0 : (200 - n) / 100.0;
    session.tick(test::sampleAt(at(x, 0.1, 0.3 - (0.3 + depth) * down), n < 200 ? 1 : 0), out);
  }
}

TEST(Session, UndoTakesBackAStrokeBitForBitAndRedoBringsItBack) {
  Session session(twoBalls(), {test::block({6, 4, 2}, 0.1)}, at(-1.5, 0.1, 0.3));
  const auto field = [&] { return session.state().objects[0].stateHash(); };
  const auto removed = [&] {
    return session.state().objects[0].removed_mm3[static_cast<std::size_t>(Material::kDentin)];
  };
  std::vector<std::uint64_t> states{field()};
  std::vector<double> volumes{0};
  for (const double x : {-1.5, -0.9, 0.4}) {  // the second overlaps the first
    dab(session, x, 0.6);
    states.push_back(field());
    volumes.push_back(removed());
    ASSERT_NE(states.back(), states[states.size() - 2]);
  }
  for (int n = 2; n >= 0; --n) {
    ASSERT_TRUE(session.apply(Undo{}));
    EXPECT_EQ(field(), states[static_cast<std::size_t>(n)]);
    EXPECT_NEAR(removed(), volumes[static_cast<std::size_t>(n)], 1e-9);
    EXPECT_EQ(session.state().objects[0].bricks().shellDefects(), 0u);
  }
  EXPECT_FALSE(session.apply(Undo{}));
  for (std::size_t n = 1; n <= 3; ++n) {
    ASSERT_TRUE(session.apply(Redo{}));
    EXPECT_EQ(field(), states[n]);
    EXPECT_NEAR(removed(), volumes[n], 1e-9);
  }
  EXPECT_FALSE(session.apply(Redo{}));
  // After an undo, a new stroke clears the redo list.
  ASSERT_TRUE(session.apply(Undo{}));
  dab(session, 1.2, 0.4);
  EXPECT_FALSE(session.apply(Redo{}));
  ASSERT_TRUE(session.apply(Undo{}));
  EXPECT_EQ(field(), states[2]);
}

TEST(Session, ListsTheStepsThatUndoAndRedoTake) {
  Session session(twoBalls(), {test::block({6, 4, 2}, 0.1)}, at(-1.5, 0.1, 0.3));
  const auto removed = [&] {
    return session.state().objects[0].removed_mm3[static_cast<std::size_t>(Material::kDentin)];
  };
  EXPECT_EQ(session.undoList(), UndoList{});

  dab(session, -1.5, 0.6);
  const double first = removed();
  ASSERT_TRUE(session.apply(SelectTool{1}));
  const std::uint64_t began = session.state().tick;
  dab(session, 0.4, 0.6);
  ASSERT_TRUE(session.apply(MoveObject{0, {0, 0, 1}}));
  UndoList list = session.undoList();
  EXPECT_EQ(list.undoable, 3u);
  EXPECT_EQ(list.redoable, 0u);
  ASSERT_EQ(list.newest_count, 3u);
  EXPECT_EQ(list.newest[0].number, 1u);
  EXPECT_EQ(list.newest[0].kind, UndoStep::Kind::kStroke);
  EXPECT_NEAR(list.newest[0].removed_mm3, first, 1e-9);
  EXPECT_EQ(list.newest[1].origin, (StepOrigin{began, 1}));
  EXPECT_NEAR(list.newest[1].removed_mm3, removed() - first, 1e-9);
  EXPECT_EQ(list.newest[2].kind, UndoStep::Kind::kMove);
  EXPECT_EQ(list.newest[2].number, 3u);

  // Undone strokes stand behind those that can be undone.
  ASSERT_TRUE(session.apply(Undo{}) && session.apply(Undo{}));
  EXPECT_EQ(session.undoList().undoable, 1u);
  EXPECT_EQ(session.undoList().redoable, 2u);
  EXPECT_EQ(session.undoList().newest, list.newest);
  // A new stroke takes its place, with its own number.
  dab(session, 1.2, 0.4);
  list = session.undoList();
  EXPECT_EQ(list.undoable, 2u);
  EXPECT_EQ(list.redoable, 0u);
  ASSERT_EQ(list.newest_count, 2u);
  EXPECT_EQ(list.newest[1].number, 4u);
  EXPECT_GT(list.newest[1].removed_mm3, 0);

  // Only the last of many are listed.
  for (int n = 0; n < 10; ++n) ASSERT_TRUE(session.apply(MoveObject{0, {0, 0, 2.0 + n}}));
  list = session.undoList();
  EXPECT_EQ(list.undoable, 12u);
  EXPECT_EQ(list.newest_count, UndoList::kMostNewest);
  EXPECT_EQ(list.newest.front().number, 7u);
  EXPECT_EQ(list.newest.back().number, 14u);
  for (std::size_t n = 0; n < 12; ++n) ASSERT_TRUE(session.apply(Undo{}));
  EXPECT_FALSE(session.apply(Undo{}));
  EXPECT_EQ(session.undoList().undoable, 0u);
  EXPECT_EQ(session.undoList().redoable, 12u);
}

TEST(Session, WhatTheToolCutsWhileItRunsDownBelongsToItsStroke) {
  Model model = twoBalls();
  model.tools[0].drive.time_constant = 0.1;
  Session session(std::move(model), {test::block({6, 4, 2}, 0.1)}, at(0, 0.1, 0.3));
  const std::uint64_t untouched = session.state().objects[0].stateHash();
  StepOutput out;
  for (int n = 0; n < 600; ++n) session.tick(test::sampleAt(at(0, 0.1, 0.3 - 0.001 * std::min(n, 800)), n < 400), out);
  double coasting = 0;
  for (int n = 0; n < 100; ++n) {
    session.tick(test::sampleAt(at(0, 0.1, -0.4), 0), out);
    coasting += out.removed_mm3;
  }
  EXPECT_GT(coasting, 0);
  ASSERT_TRUE(session.apply(Undo{}));
  EXPECT_EQ(session.state().objects[0].stateHash(), untouched);
}

TEST(Session, OneUndoTakesBackOneStrokeWhateverObjectItWasOn) {
  const auto block = test::block({2, 2, 1}, 0.1);
  Session session(twoBalls(), {block, block}, at(0, 0.1, 0.3));
  const_cast<State&>(session.state()).objects[1].moveTo({Eigen::Quaterniond::Identity(), {10, 0, 0}});
  dab(session, 0, 0.5);
  dab(session, 10, 0.5);
  const auto hash = [&](std::size_t n) { return session.state().objects[n].stateHash(); };
  const std::uint64_t first = hash(0), second = hash(1);
  ASSERT_TRUE(session.apply(Undo{}));
  EXPECT_EQ(hash(0), first);
  EXPECT_NE(hash(1), second);
  ASSERT_TRUE(session.apply(Redo{}));
  EXPECT_EQ(hash(1), second);
}

TEST(Session, RefusesCommandsThatThereIsNothingToDoTo) {
  Session session(twoBalls(), {test::block({3, 3, 1}, 0.1)}, at(0, 0, 0.3));
  for (const Command& command : {Command(Undo{}), Command(Redo{}), Command(SelectTool{2})})
    EXPECT_FALSE(session.apply(command)) << printCommand(command);
  EXPECT_TRUE(session.apply(SelectTool{1}));
}

struct Recorded {
  std::filesystem::path file;
  std::uint64_t hash = 0;
};
// Two tools, strokes undone and redone, a fault: everything a session may hold.
Recorded record(const std::filesystem::path& file, const std::shared_ptr<const BakedObject>& block) {
  SessionHeader header = describe(Session(twoBalls(), {block}, at(-1.5, 0.1, 0.3)));
  auto writer = SessionLogWriter::create(file, header);
  EXPECT_TRUE(writer) << writer.error().message();
  LogSink sink(*writer);
  Session session(twoBalls(), {block}, at(-1.5, 0.1, 0.3), &sink);
  dab(session, -1.5, 0.6);
  dab(session, -0.5, 0.5);
  EXPECT_TRUE(session.apply(Undo{}));
  EXPECT_TRUE(session.apply(SelectTool{1}));
  dab(session, 0.5, 0.4);
  StepOutput out;
  DeviceSample bad = test::sampleAt(at(0, 0, 0));
  bad.pedal = 3;
  session.tick(bad, out);
  EXPECT_TRUE(session.apply(ClearLatch{}));
  for (int n = 0; n < 6; ++n) dab(session, 1.5 - 0.3 * n, 0.3);
  EXPECT_TRUE(session.apply(Undo{}));
  session.finish();
  EXPECT_TRUE(sink.close());
  return {file, session.hash()};
}

TEST(Session, ReplayIsTheSameBitForBitOnAnyNumberOfThreads) {
  const auto block = test::block({6, 4, 2}, 0.1);
  const TemporaryFile file("session.log", "");
  std::filesystem::remove(file.path());
  const Recorded recorded = record(file.path(), block);
  const auto log = readSessionLog(file.path());
  ASSERT_TRUE(log) << log.error().message();
  for (const std::size_t threads : {1u, 2u, 5u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Model model = twoBalls();
    model.tissues = test::oneTissue(1, 1, 1);  // the log's settings count
    const auto again = replay(*log, file.path().string(), std::move(model), {test::block({6, 4, 2}, 0.1)});
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_TRUE(again->is_same) << again->differs_at;
    EXPECT_GE(again->checks, 2u);
    EXPECT_EQ(again->commands, 4u);
    EXPECT_EQ(again->note, "");
    EXPECT_EQ(again->state_hash, fmt::format("{:016x}", recorded.hash));
  }
}

// The same numbers in every build: Debug, Release, under sanitizers, with any vector instructions.
TEST(Session, TheStateOfAScriptedSessionIsTheOneOnRecord) {
  const TemporaryFile file("session.log", "");
  std::filesystem::remove(file.path());
  EXPECT_EQ(fmt::format("{:016x}", record(file.path(), test::block({6, 4, 2}, 0.1)).hash), "6229707d8e05d090");
}

TEST(Session, AReplayOfSomethingElseIsNotTheSame) {
  const TemporaryFile file("session.log", "");
  std::filesystem::remove(file.path());
  record(file.path(), test::block({6, 4, 2}, 0.1));
  auto log = readSessionLog(file.path());
  ASSERT_TRUE(log);
  log->samples[90].sample.T_world_device.translation[2] -= 0.01;
  const auto again = replay(*log, "changed.log", twoBalls(), {test::block({6, 4, 2}, 0.1)});
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_FALSE(again->is_same);
  EXPECT_EQ(again->differs_at, 999u);  // the first check after it
}

TEST(Session, AHeaderWithoutItsNumbersIsRefusedByName) {
  const TemporaryFile file("session.log", "");
  std::filesystem::remove(file.path());
  record(file.path(), test::block({6, 4, 2}, 0.1));
  auto log = readSessionLog(file.path());
  ASSERT_TRUE(log);
  for (auto& [key, value] : log->header)
    if (key == "coupling.damping") value = "much";
  const auto again = replay(*log, "odd.log", twoBalls(), {test::block({6, 4, 2}, 0.1)});
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().message().find("coupling.damping"), std::string::npos) << again.error().message();
}

// Older logs have one damping for running and stopped drives.
TEST(Session, ALogThatDoesNotTellItsDampingWhileRunningReplays) {
  const TemporaryFile file("session.log", "");
  std::filesystem::remove(file.path());
  record(file.path(), test::block({6, 4, 2}, 0.1));
  auto log = readSessionLog(file.path());
  ASSERT_TRUE(log);
  const auto named =
      std::erase_if(log->header, [](const auto& row) { return row.first.starts_with("coupling.running_"); });
  EXPECT_EQ(named, 2u);
  const auto again = replay(*log, "old.log", twoBalls(), {test::block({6, 4, 2}, 0.1)});
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->is_same);

  for (auto& [key, value] : log->header)
    if (key == "coupling.damping") value = "0.004";
  Model model = twoBalls();
  Rigid3 start;
  ASSERT_TRUE(restoreSettings(*log, "old.log", model, start));
  EXPECT_EQ(model.settings.coupling.running_damping, 0.004);
}

// Accepts everything and keeps the numbers.
struct CountingSink final : SessionSink {
  void sample(const DeviceSample&, std::uint64_t) noexcept override { ++samples; }
  void command(const Command&, std::uint64_t) noexcept override { ++commands; }
  void mark(StrokeMark, std::uint64_t) noexcept override { ++marks; }
  void check(const StateCheck& check, std::uint64_t) noexcept override {
    ++checks;
    last = check;
  }
  int samples = 0, commands = 0, marks = 0, checks = 0;
  StateCheck last;
};

TEST(Session, AStepItsStrokesAndCommandsNeitherAllocateNorFree) {
  CountingSink sink;
  Session session(twoBalls(), {test::block({6, 4, 2}, 0.1)}, at(-1.5, 0.1, 0.3), &sink);
  StepOutput out;
  std::uint64_t hash = 0;
  int undone = 0, others_done = 0;
  {
    const AllocationGuard guard;
    for (int n = 0; n < 4000; ++n) {
      const double a = 0.003 * n;
      const Rigid3 pose = at(2 * std::sin(a), std::cos(1.7 * a), 0.2 - 0.8 * std::abs(std::sin(3 * a)));
      session.step(test::sampleAt(pose, n % 500 < 400), out);
      if (n % 900 == 700) undone += session.applyWithin(Undo{}) && session.repair();
      if (n % 900 == 705) {
        session.applyWithin(Redo{});
        session.repair();
      }
      if (n == 2000) session.applyWithin(SelectTool{1});
    }
    // And every other command of a HapticThread between two ticks.
    others_done += session.applyWithin(AddMaterial{11, 0});
    others_done += session.applyWithin(StopAdding{});
    others_done += session.applyWithin(MoveObject{0, {-1.0 / 3, 1e-300, 0.1}, {1, 0, 0, 1e-12}});
    others_done += session.applyWithin(FreezeObject{0});
    others_done += session.applyWithin(UnfreezeObject{0});
    others_done += session.applyWithin(ClearLatch{});
    hash = session.object(0).hashNow();
  }
  EXPECT_EQ(sink.samples, 4000);
  EXPECT_EQ(sink.marks, 22);  // eight strokes, three of them ended by an undo and restarted
  EXPECT_EQ(sink.checks, 4);
  EXPECT_EQ(undone, 4);
  EXPECT_EQ(others_done, 6);
  EXPECT_EQ(sink.commands, 6 + others_done);  // one redo: none during a stroke
  EXPECT_EQ(hash, session.state().objects[0].stateHash());
}

// A check in the log equals the hash of the whole state.
TEST(Session, ChecksAreTheHashOfTheWholeState) {
  CountingSink sink;
  Session session(twoBalls(), {test::block({6, 4, 2}, 0.1)}, at(-1.5, 0.1, 0.3), &sink);
  for (int n = 0, checks = 0; n < 20; ++n) {
    StepOutput out;
    for (int tick = 0; tick < 250; ++tick) {
      session.step(test::sampleAt(at(-1.5 + 0.15 * n, 0.1, 0.1 - 0.003 * tick)), out);
      if (sink.checks == checks) continue;
      checks = sink.checks;
      EXPECT_EQ(sink.last.state_hash, session.hash());
    }
  }
  EXPECT_EQ(sink.checks, 5);
}

TEST(Step, NeitherAllocatesNorFrees) {
  for (const auto& [response, rendering] :
       {std::pair(Response::kPenalty, Rendering::kCoupled), std::pair(Response::kPenalty, Rendering::kDirect),
        std::pair(Response::kPenalty, Rendering::kRigid), std::pair(Response::kConstraint, Rendering::kCoupled),
        std::pair(Response::kConstraint, Rendering::kDirect), std::pair(Response::kImpulse, Rendering::kCoupled),
        std::pair(Response::kImpulse, Rendering::kDirect)}) {
    Model model = twoBalls();
    model.settings.response = response;
    model.settings.rendering = rendering;
    State state;
    state.objects.emplace_back(test::block({6, 4, 2}, 0.1), 512);
    state.objects.emplace_back(test::block({2, 2, 1}, 0.05, {Eigen::Quaterniond::Identity(), {0, 0, 1.5}}), 512);
    StepOutput out;
    int cut = 0;
    {
      const AllocationGuard guard;
      for (int n = 0; n < 1500; ++n) {
        if (n == 700) state.selectTool(1);
        const double a = 0.01 * n;
        DeviceSample sample;
        sample.T_world_device.translation = Vec3d(1.5 * std::sin(a), 0.7 * std::cos(1.3 * a), 0.2 - 0.0006 * n);
        sample.pedal = 1;
        if (n == 1200) sample.is_valid = 0;
        if (n == 1300) state.clearLatch();
        step(model, state, sample, out);
        cut += out.bricks_cut;
      }
    }
    EXPECT_GT(cut, 100);
  }
}

}  // namespace
}  // namespace kerf::session_test
