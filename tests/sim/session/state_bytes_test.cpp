// The state of a session as bytes: they are complete, and the reader trusts none of them.
#include "sim/session/state_bytes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "geometry/tool/tool_file.h"
#include "sim/run/files/log_sink.h"
#include "sim/run/report/replay.h"
#include "tests/sim/block_scene.h"
#include "tests/support/places.h"
#include "tests/support/temporary_file.h"

namespace kerf::state_bytes_test {
namespace {

Rigid3 at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), {x, y, z}}; }

Model twoBalls() {
  Model model;
  model.tools = {practiceBall(0.65, 8400), practiceBall(0.4, 840)};
  model.tissues = test::oneTissue(200, 0.3, 1000);
  return model;
}

struct Scene {
  LoadedObjects loaded{test::block({6, 2, 1}, 0.1), test::block({2, 2, 1}, 0.1)};
  Session session{twoBalls(), loaded, at(0.3, -1.8, -1.15)};

  // Cut in two, moved, filled, cut again with another tool, which still turns and presses.
  Scene() {
    session.splitWhenApart(5);
    StepOutput out;
    session.apply(MoveObject{1, {0, 0, 5}, {1, 0, 0, 0}});
    for (int n = 0; n <= 2400; ++n)
      session.tick(test::sampleAt(at(0.3, -1.8 + 3.6 * n / 2400, -1.15), n < 2400 ? 1 : 0), out);
    session.apply(MoveObject{2, {1, 0, 0.5}, {1, 0, 0, 0}});
    session.apply(AddMaterial{11, 0});
    for (int n = 0; n <= 200; ++n)
      session.tick(test::sampleAt(at(-1 - 0.005 * n, 0.8 - 0.005 * n, -0.2), n < 200), out);
    session.apply(StopAdding{});
    session.apply(SelectTool{1});
    for (int n = 0; n <= 600; ++n)
      session.tick(test::sampleAt(at(-2 - 0.001 * n, 0, std::max(-0.4, 0.6 - 0.002 * n))), out);
  }
};

TEST(StateBytes, AStateFromBytesGoesOnBitForBit) {
  Scene scene;
  ASSERT_EQ(scene.session.state().objects.size(), 3u);
  ASSERT_GT(scene.session.state().objects[0].slotCount(), scene.session.state().objects[0].bricks().firstSlotCount());
  const std::vector<std::byte> bytes = packState(scene.session.state(), scene.loaded);
  auto state = unpackState(bytes, scene.loaded, "test.kerflog");
  ASSERT_TRUE(state) << state.error().message();
  EXPECT_EQ(state->hash(), scene.session.hash());
  for (const CutObject& object : state->objects) EXPECT_EQ(object.bricks().shellDefects(), 0u);
  EXPECT_EQ(packState(*state, scene.loaded), bytes);
  StepOutput expected, got;
  double felt = 0;
  for (int n = 0; n < 800; ++n) {
    const DeviceSample sample = test::sampleAt(at(-2.6 + 0.007 * n, 0.001 * n, -0.4));
    scene.session.tick(sample, expected);
    step(scene.session.model(), *state, sample, got);
    ASSERT_EQ(got.force.force, expected.force.force) << n;
    for (CutObject& object : state->objects)
      if (object.freeBricks() < 2048) object.reserve(4096);
    felt = std::max(felt, got.force.force.norm());
  }
  EXPECT_GT(felt, 0.1);
  EXPECT_EQ(state->hash(), scene.session.hash());
}

// The load of a tool's core acts one evaluation later, and friction depends on its last hold: both are state.
void expectNeedleGoesOn(double pedal) {
  const auto needle = readTool(std::string(kSourceFolder) + "/assets/tools/859-012.toml");
  ASSERT_TRUE(needle) << needle.error().message();
  Model model = twoBalls();
  model.tools = {makeToolModel(*needle)};
  const LoadedObjects loaded{test::block({4, 4, 2}, 0.1)};
  Session session(model, loaded, at(0, 0, 0.1));
  StepOutput expected, got;
  for (int n = 0; n < 200; ++n) session.tick(test::sampleAt(at(0.0005 * n, 0, 0.1 - 0.01 * n), pedal), expected);
  ASSERT_GT(session.state().objects[0].core_load, 0.1);
  ASSERT_EQ(session.state().grip.isZero(0), pedal > 0);

  auto state = unpackState(packState(session.state(), loaded), loaded, "test.kerflog");
  ASSERT_TRUE(state) << state.error().message();
  EXPECT_EQ(state->hash(), session.hash());
  for (int n = 0; n < 100; ++n) {
    const DeviceSample sample = test::sampleAt(at(0.1 + 0.002 * n, 0, -1.9), pedal);
    session.tick(sample, expected);
    step(model, *state, sample, got);
    ASSERT_EQ(got.force.force, expected.force.force) << n;
  }
  EXPECT_EQ(state->hash(), session.hash());
}

TEST(StateBytes, ANeedleThatStandsOnItsCoreGoesOnBitForBit) { expectNeedleGoesOn(1); }
TEST(StateBytes, ANeedleThatFrictionHoldsGoesOnBitForBit) { expectNeedleGoesOn(0); }

TEST(StateBytes, AReplayBeginsAtASnapshotAndEndsTheSame) {
  const TemporaryFile file("session.log", "");
  std::filesystem::remove(file.path());
  const LoadedObjects loaded{test::block({6, 4, 2}, 0.1)};
  const Rigid3 start = at(-1.5, 0.1, 0.3);
  auto writer = SessionLogWriter::create(file.path(), describe(Session(twoBalls(), loaded, start)));
  ASSERT_TRUE(writer) << writer.error().message();
  LogSink sink(*writer);
  Session session(twoBalls(), loaded, start, &sink);
  session.snapshotEvery(250);
  StepOutput out;
  const auto dab = [&](double x) {
    for (int n = 0; n <= 200; ++n) {
      const double down = n < 100 ? n / 100.0 : (200 - n) / 100.0;
      session.tick(test::sampleAt(at(x, 0.1, 0.3 - 0.8 * down), n < 200 ? 1 : 0), out);
    }
  };
  for (const double x : {-1.5, -1.1, -0.6, 0.2}) dab(x);  // snapshots before the third of them
  ASSERT_TRUE(session.apply(Undo{}));
  dab(0.9);
  ASSERT_TRUE(session.apply(Undo{}));
  ASSERT_TRUE(session.apply(Undo{}));
  ASSERT_TRUE(session.apply(Undo{}));  // the second dab: behind every snapshot but the one at its beginning, if any
  dab(1.4);
  dab(2);
  session.finish();
  ASSERT_TRUE(sink.close());
  const std::string hash = fmt::format("{:016x}", session.hash());
  const auto log = readSessionLog(file.path());
  ASSERT_TRUE(log) << log.error().message();
  const auto again = [&](double from) {
    auto replayed = replay(*log, "session.log", twoBalls(), loaded, {}, 1e9, from);
    EXPECT_TRUE(replayed) << replayed.error().message();
    return *replayed;
  };
  const Replay whole = again(0), late = again(1e9), middle = again(0.7);
  EXPECT_EQ(whole.first_tick, 0u);
  EXPECT_GE(whole.snapshots, 3u);
  EXPECT_GT(late.first_tick, 1000u);
  // The later undo applies to a stroke from before the snapshot at 0.4 s: only the beginning knows it.
  EXPECT_EQ(middle.first_tick, 0u);
  for (const Replay& r : {whole, late, middle}) {
    EXPECT_TRUE(r.is_same) << r.differs_at;
    EXPECT_EQ(r.state_hash, hash);
  }
}

TEST(StateBytes, WhatIsNotWholeOrNotOurSceneIsRefused) {
  Scene scene;
  const std::vector<std::byte> bytes = packState(scene.session.state(), scene.loaded);
  for (std::size_t length = 0; length < bytes.size(); length += 1 + length / 9) {
    const auto part = unpackState(std::span(bytes).first(length), scene.loaded, "part.kerflog");
    ASSERT_FALSE(part) << length;
    EXPECT_NE(part.error().message().find("part.kerflog"), std::string::npos);
  }
  std::vector<std::byte> more = bytes;
  more.push_back(std::byte{0});
  EXPECT_FALSE(unpackState(more, scene.loaded, "x"));
  EXPECT_FALSE(unpackState(bytes, {scene.loaded[1]}, "x"));
  EXPECT_FALSE(unpackState(bytes, {}, "x"));
  // Any byte may be wrong: the result is an error or another state, no crash.
  std::mt19937 random(3);
  for (int n = 0; n < 300; ++n) {
    std::vector<std::byte> wrong = bytes;
    const std::size_t place = random() % (n < 150 ? std::min<std::size_t>(wrong.size(), 5000) : wrong.size());
    wrong[place] ^= std::byte{static_cast<unsigned char>(1u << random() % 8)};
    static_cast<void>(unpackState(wrong, scene.loaded, "x"));
  }
}

}  // namespace
}  // namespace kerf::state_bytes_test
