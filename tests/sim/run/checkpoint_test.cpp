// A killed session starts again from a checkpoint, bit for bit as from the whole log.
#include "sim/session/checkpoint.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "geometry/tool/tool_file.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/files/run_files.h"
#include "sim/run/session/run_branch.h"
#include "sim/run/session/session_run.h"
#include "tests/sim/block_scene.h"
#include "tests/sim/person_at_mouse.h"

namespace kerf::checkpoint_test {
namespace {

namespace fs = std::filesystem;

Rigid3 at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), {x, y, z}}; }

// ---- The state

class CommandLog final : public SessionSink {
 public:
  void sample(const DeviceSample&, std::uint64_t) noexcept override {}
  void command(const Command& command, std::uint64_t tick) noexcept override { done.emplace_back(tick, command); }
  void mark(StrokeMark, std::uint64_t) noexcept override {}
  void check(const StateCheck&, std::uint64_t) noexcept override {}
  std::vector<std::pair<std::uint64_t, Command>> done;
};

// Cuts in two, moves, fills, cuts with another tool, undoes. Contacts in turns: contact_turns_test.cpp.
class Scene {
 public:
  Scene() : session_(model(), loaded_, at(0.3, -1.8, -1.15), &log_) { session_.splitWhenApart(5); }
  static Model model() {
    Model out;
    out.tools = {practiceBall(0.65, 8400), practiceBall(0.4, 840)};
    out.tissues = test::oneTissue(200, 0.3, 1000);
    return out;
  }
  // Input of a tick: commands first.
  static std::vector<Command> commandsOf(int n) {
    if (n == kSawn + 50) return {MoveObject{1, {1, 0, 0.5}, {1, 0, 0, 0}}};
    if (n == kSawn + 100) return {AddMaterial{11, 0}};
    if (n == kSawn + 250) return {StopAdding{}, SelectTool{1}};
    if (n == kUndone) return {Undo{}};
    if (n == kUndone + 50) return {Redo{}};
    return {};
  }
  static DeviceSample sampleOf(int n) {
    if (n < kSawn) return test::sampleAt(at(0.3, -1.8 + 3.6 * n / kSawn, -1.15));
    if (n < kSawn + 100) return test::sampleAt(at(-1, 0, 0.8), 0);
    if (n < kSawn + 250) return test::sampleAt(at(-1, 0.001 * (n - kSawn), -0.2), n < kSawn + 240);
    if (n < kUndone - 50) return test::sampleAt(at(-2, 0, std::max(-0.4, 0.6 - 0.006 * (n - kSawn - 250))));
    return test::sampleAt(at(-2.2, 0, n < kUndone + 150 ? 0.8 : -0.2), n >= kUndone + 100);
  }
  static constexpr int kSawn = 2400, kUndone = 3000, kTicks = 3250;

  CommandLog log_;
  const LoadedObjects loaded_{test::block({6, 2, 1}, 0.1)};
  Session session_;
};

TEST(Checkpoint, AStateGoesOnBitForBitFromAnyTick) {
  std::mt19937 random(7);
  std::vector<int> ticks;
  for (int n = 0; n < 16; ++n) ticks.push_back(std::uniform_int_distribution(1, Scene::kTicks - 10)(random));
  for (const int tick : {20, 2390, 2645, 2945, 2955, 3040}) ticks.push_back(tick);  // running down, undone
  std::sort(ticks.begin(), ticks.end());
  ticks.erase(std::unique(ticks.begin(), ticks.end()), ticks.end());

  const TemporaryFolder folder;
  Scene scene;
  std::vector<std::uint64_t> hashes;  // before the tick
  std::size_t next = 0;
  StepOutput output;
  for (int n = 0; n < Scene::kTicks; ++n) {
    if (next < ticks.size() && ticks[next] == n) {
      ++next;
      const auto written =
          writeCheckpoint(folder.path(), scene.session_, static_cast<std::size_t>(n), scene.log_.done.size());
      ASSERT_TRUE(written) << written.error().message();
    }
    for (const Command& command : Scene::commandsOf(n)) ASSERT_TRUE(scene.session_.apply(command)) << n;
    hashes.push_back(scene.session_.hashNow());
    scene.session_.tick(Scene::sampleOf(n), output);
  }
  EXPECT_EQ(scene.session_.state().objects.size(), 2u);

  const std::vector<fs::path> files = findCheckpoints(folder.path());
  ASSERT_EQ(files.size(), ticks.size());
  std::size_t reached_back = 0;
  for (const fs::path& file : files) {
    auto found = readCheckpoint(file, scene.loaded_);
    ASSERT_TRUE(found) << found.error().message();
    const int from = static_cast<int>(found->samples);
    Session again(std::move(found->state), Scene::model(), scene.loaded_, nullptr, found->rest);
    bool goes_on = true;
    std::size_t command = found->events;
    for (int n = from; n < Scene::kTicks; ++n) {
      const auto& done = scene.log_.done;
      for (; command < done.size() && done[command].first == static_cast<std::uint64_t>(n); ++command)
        goes_on &= again.apply(done[command].second);
      if (!goes_on) break;
      ASSERT_EQ(again.hashNow(), hashes[static_cast<std::size_t>(n)]) << "from " << from << ", at " << n;
      again.tick(Scene::sampleOf(n), output);
    }
    EXPECT_EQ(goes_on, from <= Scene::kSawn + 250 || from > Scene::kUndone + 50)
        << from << ": its undo reaches back before it";
    reached_back += !goes_on;
  }
  EXPECT_GT(reached_back, 1u);
}

// ---- Sessions of killed programs

// Copies of the folder of a session while it runs: the program might have been killed then.
class KilledSessions : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    const fs::path block = test::bakedBlock(*folder_), run_folder = folder_->path() / "block.run";
    LiveRunOptions options = test::someTools();
    options.checkpoints.replay_s = 0;  // as often as possible
    auto run = LiveRun::open(block, run_folder, std::move(options));
    ASSERT_TRUE(run) << run.error().message();
    std::mt19937 random(11);
    {
      test::Mouse mouse(**run);
      const auto kill = [&] {
        const fs::path copy = folder_->path() / ("killed-" + std::to_string(killed_.size()) + ".run");
        // A checkpoint may go meanwhile. The log first: its checkpoints may be newer.
        fs::create_directories(copy);
        for (const char* name : {"session.kerflog", "run.toml"}) fs::copy_file(run_folder / name, copy / name);
        fs::copy(run_folder / "tools", copy / "tools", fs::copy_options::recursive);
        for (const fs::path& file : findCheckpoints(run_folder)) {
          std::error_code gone;
          fs::copy_file(file, copy / file.filename(), gone);
        }
        killed_.push_back(copy);
      };
      const auto drill = [&](double x) {
        std::uniform_real_distribution<double> seconds(0.15, 0.6);
        mouse.drill({x, 0, 0}, seconds(random));
        kill();
      };
      for (const double x : {-1.5, -1.0, -0.5}) drill(x);
      mouse.send(Undo{});
      kill();
      mouse.send(SelectTool{1});
      drill(0.5);
      mouse.send(MoveObject{0, {0.2, 0, 0}, {1, 0, 0, 0}});
      drill(1);
      CutPlanes planes;
      planes.count = 1;
      planes.numbers[0] = {1, 0, 0, 2};
      mouse.send(CutByPlanes{0, 0, planes});
      drill(1.5);
      for (int n = 0; n < 3; ++n) mouse.send(Undo{});
      kill();
      drill(-2);
      ASSERT_GT((*run)->checkpoints()->status().written, 10u);
      EXPECT_FALSE((*run)->checkpoints()->status().ended) << *(*run)->checkpoints()->status().ended;
      ASSERT_TRUE((*run)->finish());
      EXPECT_TRUE(findCheckpoints(run_folder).empty()) << "the session has ended";
    }
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  // The same without its checkpoints.
  static fs::path copyOf(const fs::path& run, const std::string& name, bool has_checkpoints) {
    const fs::path copy = folder_->path() / (name + ".run");
    fs::copy(run, copy, fs::copy_options::recursive);
    if (!has_checkpoints) removeCheckpoints(copy);
    return copy;
  }
  static void expectSame(const fs::path& quick, const fs::path& full) {
    EXPECT_EQ(contentOf(quick / "run.toml"), contentOf(full / "run.toml"));
    EXPECT_EQ(contentOf(quick / "run.vdb"), contentOf(full / "run.vdb"));
  }

  static TemporaryFolder* folder_;
  static std::vector<fs::path> killed_;
};
TemporaryFolder* KilledSessions::folder_ = nullptr;
std::vector<fs::path> KilledSessions::killed_;

TEST_F(KilledSessions, AreRecoveredFromACheckpointBitForBitAsFromTheWholeLog) {
  std::mt19937 random(5);
  std::size_t from_checkpoints = 0;
  for (std::size_t n = 0; n < killed_.size(); ++n) {
    SCOPED_TRACE(n);
    const fs::path quick = copyOf(killed_[n], "quick-" + std::to_string(n), true);
    // The power fails: the log ends anywhere.
    if (n % 2 == 1) {
      const auto size = fs::file_size(quick / "session.kerflog");
      fs::resize_file(quick / "session.kerflog", std::uniform_int_distribution(size * 2 / 3, size)(random));
    }
    const fs::path full = copyOf(quick, "full-" + std::to_string(n), false);
    const auto by_checkpoint = recoverRun(quick), by_log = recoverRun(full);
    ASSERT_TRUE(by_log) << by_log.error().message();
    ASSERT_TRUE(by_checkpoint) << by_checkpoint.error().message();
    EXPECT_TRUE(by_checkpoint->replay.is_same || by_log->replay.checks == 0) << by_checkpoint->replay.note;
    EXPECT_EQ(by_checkpoint->manifest.state_hash, by_log->manifest.state_hash);
    EXPECT_DOUBLE_EQ(by_checkpoint->replay.removed_mm3, by_log->replay.removed_mm3);
    EXPECT_EQ(by_log->replay.first_tick, 0u);
    from_checkpoints += by_checkpoint->replay.first_tick > 0;
    EXPECT_TRUE(findCheckpoints(quick).empty());
    expectSame(quick, full);
  }
  EXPECT_GE(from_checkpoints, killed_.size() / 2);
}

TEST_F(KilledSessions, ADamagedCheckpointGivesWayToAnOlderOneAndThenToTheWholeLog) {
  const fs::path run = copyOf(killed_.back(), "damaged", true), full = copyOf(run, "of-the-log", false);
  ASSERT_TRUE(recoverRun(full));
  const std::vector<fs::path> files = findCheckpoints(run);
  ASSERT_GE(files.size(), 2u);
  std::string bytes = contentOf(files[0]);
  bytes[bytes.size() / 2] ^= 1;
  std::ofstream(files[0], std::ios::binary) << bytes;

  const fs::path all = copyOf(run, "all-damaged", true);
  const auto older = recoverRun(run);
  ASSERT_TRUE(older) << older.error().message();
  EXPECT_TRUE(older->replay.is_same) << older->replay.note;
  EXPECT_NE(older->replay.note.find(files[0].filename().string()), std::string::npos) << older->replay.note;
  expectSame(run, full);

  for (const fs::path& file : findCheckpoints(all)) fs::resize_file(file, fs::file_size(file) / 2);
  const auto whole = recoverRun(all);
  ASSERT_TRUE(whole) << whole.error().message();
  EXPECT_EQ(whole->replay.first_tick, 0u);
  EXPECT_NE(whole->replay.note.find("left out"), std::string::npos) << whole->replay.note;
  expectSame(all, full);
}

// Recovery of an open session writes the run; a branch of it does not end it.
TEST_F(KilledSessions, ABranchOfAnOpenSessionStartsFromItsCheckpoint) {
  const fs::path run = copyOf(killed_.back(), "open", true), full = copyOf(run, "open-of-the-log", false);
  const auto quick = branchRun(run, {}, folder_->path() / "branch.run"),
             slow = branchRun(full, {}, folder_->path() / "branch-of-the-log.run");
  ASSERT_TRUE(quick) << quick.error().message();
  ASSERT_TRUE(slow) << slow.error().message();
  EXPECT_EQ(quick->state_hash, slow->state_hash);
  EXPECT_FALSE(findCheckpoints(run).empty());
  const auto replayed = replayRun(folder_->path() / "branch.run");
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same) << replayed->note;
}

TEST_F(KilledSessions, ACheckpointOfAnotherSessionIsLeftOut) {
  const fs::path run = copyOf(killed_[1], "foreign", false);
  const fs::path other = findCheckpoints(killed_.back()).front();
  fs::copy_file(other, run / other.filename());
  const fs::path full = copyOf(run, "not-foreign", false);
  const auto recovered = recoverRun(run);
  ASSERT_TRUE(recovered) << recovered.error().message();
  EXPECT_NE(recovered->replay.note.find("left out"), std::string::npos) << recovered->replay.note;
  ASSERT_TRUE(recoverRun(full));
  expectSame(run, full);
}

}  // namespace
}  // namespace kerf::checkpoint_test
