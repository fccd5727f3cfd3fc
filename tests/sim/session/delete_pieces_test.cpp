// Pieces deleted from a session: volumes, undo and redo among cuts and splits, replay.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <numeric>
#include <random>

#include "sim/run/files/log_sink.h"
#include "sim/run/report/replay.h"
#include "sim/session/session.h"
#include "sim/session/state_bytes.h"
#include "tests/sim/block_scene.h"
#include "tests/support/temporary_file.h"

namespace kerf::delete_pieces_test {
namespace {

Rigid3 at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), {x, y, z}}; }

Model ball() {
  Model model;
  model.tools = {practiceBall(0.65, 8400)};
  model.tissues = test::oneTissue(200, 0.3, 1000);
  model.settings.rendering = Rendering::kRigid;
  model.settings.geometry_only = true;
  return model;
}

DeleteObjects without(std::initializer_list<std::size_t> objects) {
  DeleteObjects out;
  for (const std::size_t n : objects) out.objects.bits |= std::uint64_t{1} << n;
  return out;
}

CutByPlanes across(double x, std::size_t object = 0) {
  CutByPlanes out{object, 0, {}};
  out.planes.add({{x, 0, 0}, {1, 0, 0}});
  return out;
}

double sum(const std::array<double, 256>& volumes) { return std::accumulate(volumes.begin(), volumes.end(), 0.0); }
double volumeOf(const CutObject& object) { return sum(object.bricks().countVolumes()); }

void dab(Session& session, double x) {
  StepOutput out;
  for (int n = 0; n < 60; ++n) session.tick(test::sampleAt(at(x, 0, 0.6 - 0.01 * n), 1), out);
  session.tick(test::sampleAt(at(x, 0, 3), 0), out);
}

// Objects in their order: numbers, values, places.
std::string sceneOf(const Session& session) {
  std::string out;
  for (const CutObject& object : session.state().objects)
    out += fmt::format("{} {:x} {} {:.6f}; ", object.id, object.stateHash(), object.T_world_object.translation[2],
                       sum(object.removed_before_mm3));
  return out;
}

class DeletePieces : public testing::Test {
 protected:
  Session session_{ball(), {test::block({6, 2, 1}, 0.1)}, at(0, 0, 3)};
  const std::vector<CutObject>& objects_ = session_.state().objects;
};

TEST_F(DeletePieces, TheirVolumeCountsAsRemovedAndOneUndoBringsAllBack) {
  const double whole = volumeOf(objects_[0]);
  dab(session_, -2);
  ASSERT_TRUE(session_.apply(across(-0.52)));
  ASSERT_TRUE(session_.apply(across(1.02)));
  ASSERT_EQ(objects_.size(), 3u);
  const double gone = volumeOf(objects_[0]) + volumeOf(objects_[2]);
  const std::uint32_t kept = objects_[1].id;
  const std::string before = sceneOf(session_);

  ASSERT_TRUE(session_.apply(without({0, 2})));
  ASSERT_EQ(objects_.size(), 1u);
  EXPECT_EQ(objects_[0].id, kept);
  EXPECT_NEAR(volumeOf(objects_[0]) + sum(objects_[0].removed_before_mm3) + sum(objects_[0].removed_mm3), whole, 0.01);
  const UndoStep step = session_.undoList().newest[session_.undoList().newest_count - 1];
  EXPECT_EQ(step.kind, UndoStep::Kind::kDelete);
  EXPECT_EQ(step.deleted, 2u);
  EXPECT_NEAR(step.removed_mm3, gone, 1e-9);
  const std::string after = sceneOf(session_);

  ASSERT_TRUE(session_.apply(Undo{}));
  EXPECT_EQ(sceneOf(session_), before);
  ASSERT_TRUE(session_.apply(Redo{}));
  EXPECT_EQ(sceneOf(session_), after);
}

TEST_F(DeletePieces, TheLastPieceStaysAndOtherNumbersAreRefused) {
  EXPECT_FALSE(session_.apply(without({0}))) << "the only object";
  EXPECT_FALSE(session_.canUndo());
  ASSERT_TRUE(session_.apply(across(0.03)));
  const std::string before = sceneOf(session_);
  for (const DeleteObjects& bad : {without({}), without({0, 1}), without({2}), without({0, 63})})
    EXPECT_FALSE(session_.apply(bad)) << printCommand(bad);
  EXPECT_EQ(sceneOf(session_), before);

  const auto block = test::block({2, 2, 1}, 0.1), other = test::block({1, 1, 1}, 0.1);
  Session two(ball(), {block, other}, at(0, 0, 3));
  ASSERT_TRUE(two.apply(across(0.03)));
  EXPECT_FALSE(two.apply(without({1}))) << "the neighbour";
  EXPECT_FALSE(two.apply(without({0, 1}))) << "pieces of two objects";
  EXPECT_TRUE(two.apply(without({2})));
}

TEST_F(DeletePieces, AddedMaterialKeepsItsObject) {
  ASSERT_TRUE(session_.apply(across(-0.52)));
  ASSERT_TRUE(session_.apply(across(1.02)));
  const std::uint32_t id = objects_[2].id;
  ASSERT_TRUE(session_.apply(AddMaterial{static_cast<std::uint8_t>(Material::kDentin), 2}));
  ASSERT_TRUE(session_.apply(without({0})));
  EXPECT_EQ(objects_[session_.state().adds_to].id, id);
  ASSERT_TRUE(session_.apply(Undo{}));
  EXPECT_EQ(objects_[session_.state().adds_to].id, id);
  EXPECT_EQ(session_.state().adds, Material::kDentin);
  ASSERT_TRUE(session_.apply(without({2})));
  EXPECT_EQ(session_.state().adds, Material::kNone) << "rather none than another one";
}

// Strokes, cuts, moves, deletions, undo and redo in any order: every scene comes back as it was.
TEST(DeletePiecesAtRandom, EveryUndoAndRedoLeadsToTheSceneThatWasThere) {
  std::mt19937 random(7);
  const auto pick = [&](std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(random); };
  Session session(ball(), {test::block({6, 2, 1}, 0.1)}, at(0, 0, 3));
  const auto& objects = session.state().objects;
  std::vector<std::string> line{sceneOf(session)};
  std::size_t now = 0, deletions = 0, undone = 0;
  for (int n = 0; n < 160; ++n) {
    const std::string before = sceneOf(session);
    const std::size_t what = pick(10);
    bool is_step = false;
    if (what < 4) {
      const bool is_undo = what < 2 || what == 3;
      const bool is_done = is_undo ? session.apply(Undo{}) : session.apply(Redo{});
      ASSERT_EQ(is_done, is_undo ? now > 0 : now + 1 < line.size()) << n;
      if (is_done) now += is_undo ? std::size_t(-1) : 1;
      undone += is_done;
      ASSERT_EQ(sceneOf(session), line[now]) << "step " << n;
      continue;
    }
    if (what < 6) {
      dab(session, -2.7 + 0.1 * static_cast<double>(pick(55)));
      is_step = sceneOf(session) != before;
    } else if (what < 8) {
      is_step = session.apply(across(-2.98 + 0.1 * static_cast<double>(pick(60)), pick(objects.size())));
    } else if (what == 8) {
      is_step = session.apply(MoveObject{pick(objects.size()), {0, 0, -0.1 * n}, {1, 0, 0, 0}});
    } else {
      DeleteObjects command;
      for (std::size_t k = 0; k < objects.size(); ++k) command.objects.bits |= std::uint64_t{pick(3) == 0} << k;
      is_step = session.apply(command);
      deletions += is_step;
    }
    if (!is_step) continue;
    line.resize(++now);
    line.push_back(sceneOf(session));
  }
  EXPECT_GE(deletions, 5u);
  EXPECT_GE(undone, 20u);
}

TEST(DeletePiecesLog, ReplayAndSnapshotGiveTheSameBits) {
  const TemporaryFile file("session.log", "");
  std::filesystem::remove(file.path());
  const LoadedObjects objects{test::block({6, 2, 1}, 0.1)};
  std::string hash;
  {
    auto writer = SessionLogWriter::create(file.path(), describe(Session(ball(), objects, at(-2, 0, 3))));
    ASSERT_TRUE(writer) << writer.error().message();
    LogSink sink(*writer);
    Session session(ball(), objects, at(-2, 0, 3), &sink);
    dab(session, -2);
    ASSERT_TRUE(session.apply(across(-0.52)));
    ASSERT_TRUE(session.apply(across(1.02)));
    ASSERT_TRUE(session.apply(without({0, 2})));
    dab(session, 0.1);
    ASSERT_TRUE(session.apply(Undo{}));
    ASSERT_TRUE(session.apply(Undo{}));
    dab(session, 2);
    ASSERT_TRUE(session.apply(without({1})));
    dab(session, -1);
    const auto bytes = session.snapshot();
    const auto state = unpackState(bytes, objects, "snapshot");
    ASSERT_TRUE(state) << state.error().message();
    EXPECT_EQ(state->hash(), session.hash());
    session.finish();
    hash = fmt::format("{:016x}", session.hash());
    ASSERT_TRUE(sink.close());
  }
  const auto log = readSessionLog(file.path());
  ASSERT_TRUE(log) << log.error().message();
  const auto again = replay(*log, file.path().string(), ball(), objects);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->is_same) << again->differs_at;
  EXPECT_EQ(again->state_hash, hash);
}

}  // namespace
}  // namespace kerf::delete_pieces_test
