#include "sim/run/report/replay.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "sim/run/files/log_sink.h"
#include "tests/sim/block_scene.h"
#include "tests/support/temporary_file.h"

namespace kerf::replay_test {
namespace {

Rigid3 at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), {x, y, z}}; }

Model ball() {
  Model model;
  model.tools.push_back(practiceBall(0.5, 20000));
  model.tissues = test::oneTissue(200, 0.3, 1000);
  return model;
}

// Two teeth 0.6 mm apart, with different voxels.
LoadedObjects twoTeeth() { return {test::block({4, 4, 2}, 0.1), test::block({4, 4, 2}, 0.12, at(4.6, 0.05, 0))}; }

struct Recorded {
  std::uint64_t hash = 0;
  double removed[2] = {0, 0};
};

double removedOf(const CutObject& object) {
  double sum = 0;
  for (const double volume : object.removed_mm3) sum += volume;
  return sum;
}

// A groove across both. Then the second tooth is tilted and moved, and a bur at rest cuts it again. One undo.
Recorded record(const std::filesystem::path& path, const LoadedObjects& objects) {
  auto writer = SessionLogWriter::create(path, describe(Session(ball(), {objects[0]}, at(0, 0, 0.3))));
  EXPECT_TRUE(writer) << writer.error().message();
  LogSink sink(*writer);
  Session session(ball(), objects, at(0, 0, 0.3), &sink);
  session.snapshotEvery(1000);
  StepOutput out;
  const auto go = [&](double x, double z, double pedal) { session.tick(test::sampleAt(at(x, 0, z), pedal), out); };
  for (int n = 0; n < 300; ++n) go(0, 0.3 - 0.002 * n, 1);
  for (int n = 0; n < 1500; ++n) go(0.003 * n, -0.3, 1);
  Recorded recorded;
  for (std::size_t n = 0; n < 2; ++n) recorded.removed[n] = removedOf(session.state().objects[n]);
  for (int n = 0; n < 400; ++n) go(4.5, -0.3 + 0.002 * n, 0);
  EXPECT_TRUE(session.apply(MoveObject{1, {0.3, 0.2, 0.1}, {0.9998000066665778, 0, 0.01999866669333308, 0}}));
  for (int n = 0; n < 700; ++n) go(4.5, 0.5 - 0.0012 * n, 1);
  for (int n = 0; n < 400; ++n) go(4.5, -0.3 + 0.002 * n, 0);
  EXPECT_TRUE(session.apply(Undo{}));
  for (int n = 0; n < 700; ++n) go(4.1, 0.5 - 0.0012 * n, 1);
  session.finish();
  EXPECT_TRUE(sink.close());
  recorded.hash = session.hash();
  return recorded;
}

TEST(Replay, ASessionOfTwoTeethIsTheSameBitForBitCutMovedAndUndone) {
  const TemporaryFile file("session.log", "");
  std::filesystem::remove(file.path());
  const Recorded recorded = record(file.path(), twoTeeth());
  EXPECT_GT(recorded.removed[0], 0.2) << "the groove goes through one";
  EXPECT_GT(recorded.removed[1], 0.2) << "and on into the other";
  const auto log = readSessionLog(file.path());
  ASSERT_TRUE(log) << log.error().message();
  for (const double from : {0.0, 2.3}) {
    const auto again = replay(*log, "teeth.log", ball(), twoTeeth(), {}, 1e9, from);
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_TRUE(again->is_same) << again->differs_at;
    EXPECT_EQ(again->note, "");
    EXPECT_EQ(again->objects, 2u);
    EXPECT_GE(again->checks, 2u);
    EXPECT_EQ(again->state_hash, fmt::format("{:016x}", recorded.hash));
    // The snapshot is at the start of the second stroke: after the move, before the undo.
    EXPECT_EQ(again->first_tick > 0, from > 0);
    EXPECT_EQ(again->commands, from > 0 ? 1u : 2u);
  }
}

TEST(Replay, WithoutTheNeighbourOrWithAnotherItIsNotTheSame) {
  const TemporaryFile file("session.log", "");
  std::filesystem::remove(file.path());
  record(file.path(), twoTeeth());
  const auto log = readSessionLog(file.path());
  ASSERT_TRUE(log) << log.error().message();
  // The move command has no object to move.
  const auto alone = replay(*log, "teeth.log", ball(), {twoTeeth().front()});
  ASSERT_FALSE(alone);
  EXPECT_NE(alone.error().message().find("object.move 1"), std::string::npos) << alone.error().message();
  const auto other =
      replay(*log, "teeth.log", ball(), {twoTeeth().front(), test::block({4, 4, 2}, 0.12, at(4.65, 0.05, 0))});
  ASSERT_TRUE(other) << other.error().message();
  EXPECT_FALSE(other->is_same);
}

}  // namespace
}  // namespace kerf::replay_test
