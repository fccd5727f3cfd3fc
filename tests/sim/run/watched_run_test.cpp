#include "sim/run/session/watched_run.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <thread>

#include "sim/monitor/heat.h"
#include "sim/monitor/structures.h"
#include "sim/run/files/run_output.h"
#include "sim/run/report/replay.h"
#include "tests/sim/person_at_mouse.h"
#include "tests/support/temporary_folder.h"

namespace kerf::watched_run_test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

// The newest chunk of each brick: the content of the picture.
class Picture {
 public:
  void add(const std::vector<ObjectChunks>& objects) {
    for (const ObjectChunks& object : objects)
      for (const MeshChunkPtr& chunk : object.chunks) {
        const auto key = std::pair(object.id, coordKey(chunk->brick));
        if (chunk->isEmpty())
          chunks_.erase(key);
        else
          chunks_[key] = chunk;
      }
  }
  std::size_t size() const { return chunks_.size(); }
  bool operator==(const Picture& other) const {
    return std::equal(chunks_.begin(), chunks_.end(), other.chunks_.begin(), other.chunks_.end(),
                      [](const auto& one, const auto& two) {
                        return one.first == two.first && one.second->vertices == two.second->vertices &&
                               one.second->triangles == two.second->triangles;
                      });
  }

 private:
  std::map<std::pair<std::uint32_t, std::uint64_t>, MeshChunkPtr> chunks_;
};

// A session of three strokes with two tools. The first two strokes are undone.
class WatchedRunTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder();
    live_ = new Picture();
    const fs::path block = test::bakedBlock(*folder_);
    auto run = LiveRun::open(block, runFolder(), test::someTools());
    ASSERT_TRUE(run) << run.error().message();
    const auto tools = (*run)->tools();
    for (std::size_t n = 0; n < tools.size(); ++n)
      (*run)->thread().heatBy(n, ToolSamples((*run)->model().tools[n].cut, kToolSamples), heatSource(tools[n].tool));
    test::Mouse mouse(**run);
    mouse.drill({-1, 0, 0}, 2);
    mouse.drill({0, 0.5, 0}, 2);
    mouse.send(Undo{});
    mouse.send(Undo{});
    mouse.send(SelectTool{1});
    mouse.drill({1, 0, 0}, 2);
    (*run)->thread().stop();  // the last bricks are sent
    (*run)->thread().update();
    live_heat_ = (*run)->thread().report().heat;
    const auto manifest = (*run)->finish();
    ASSERT_TRUE(manifest) << manifest.error().message();
    live_->add((*run)->takeChunks());
  }
  static void TearDownTestSuite() {
    delete live_;
    delete folder_;
  }
  static fs::path runFolder() { return folder_->path() / "block.run"; }

  static std::unique_ptr<WatchedRun> watch(const fs::path& run_folder, double keep_every_s = 1,
                                           bool is_looked_at = false) {
    WatchOptions options;
    options.is_looked_at = is_looked_at;
    options.mesher.remesher.is_parallel = false;
    options.keep_every_s = keep_every_s;
    auto run = WatchedRun::open(run_folder, options);
    EXPECT_TRUE(run) << run.error().message();
    return run ? std::move(*run) : nullptr;
  }
  // Waits for a condition, at most two minutes.
  template <class IsSo>
  static bool becomes(WatchedRun& run, Picture& seen, const IsSo& is_so) {
    for (int n = 0; n < 60000; ++n) {
      run.update();
      seen.add(run.takeChunks());
      if (is_so()) {
        seen.add(run.takeChunks());  // chunks meshed since the last look
        return true;
      }
      std::this_thread::sleep_for(milliseconds(2));
    }
    return false;
  }
  static bool settles(WatchedRun& run, Picture& seen) {
    return becomes(run, seen, [&] { return run.isSettled() && !run.moment().is_playing; });
  }

  static inline TemporaryFolder* folder_ = nullptr;
  static inline Picture* live_ = nullptr;
  static inline HeatReport live_heat_;  // at the end
};

TEST_F(WatchedRunTest, AtAnySpeedTheEndIsThatOfTheSessionBitForBit) {
  for (const double speed : {4.0, 16.0, WatchedRun::kFastest}) {
    const auto run = watch(runFolder());
    ASSERT_TRUE(run);
    Picture seen;
    run->setSpeed(speed);
    run->play();
    ASSERT_TRUE(becomes(*run, seen, [&] { return run->moment().is_at_end && run->isSettled(); }));
    const auto& verdict = run->moment().verdict;
    ASSERT_TRUE(verdict);
    EXPECT_TRUE(verdict->is_same && verdict->is_whole) << verdict->text;
    EXPECT_NE(verdict->text.find(run->manifest().state_hash), std::string::npos) << verdict->text;
    EXPECT_GT(seen.size(), 20u);
    EXPECT_TRUE(seen == *live_) << "at speed " << speed;
    EXPECT_EQ(run->moment().tool, 1u);
    EXPECT_EQ(run->moment().steps, 5u) << "three strokes and two undos";
    run->jumpTo(10);
    ASSERT_TRUE(settles(*run, seen));
    EXPECT_EQ(run->moment().sample, 10u) << "nobody has asked to play on";
    run->jumpTo(run->samples());
    ASSERT_TRUE(settles(*run, seen));
    EXPECT_TRUE(seen == *live_);
    EXPECT_NEAR(run->moment().report.objects[0].removed_mm3, replayRun(runFolder())->removed_mm3, 1e-9);
  }
}

TEST_F(WatchedRunTest, TheTemperatureIsThatOfTheSessionWhereverOneJumps) {
  ASSERT_TRUE(live_heat_.is_known);
  const auto run = watch(runFolder(), 1, true);
  ASSERT_TRUE(run);
  Picture seen;
  ASSERT_TRUE(settles(*run, seen));
  EXPECT_EQ(run->moment().report.heat.surface, kBodyCelsius) << "nothing was cut yet";

  // In the middle of the last stroke, forwards, and backwards from a kept state.
  std::size_t middle = 0;
  for (const WatchedStep& step : run->steps())
    if (step.kind == WatchedStep::Kind::kStroke) middle = (step.begin + step.end) / 2;
  run->jumpTo(middle);
  ASSERT_TRUE(settles(*run, seen));
  const double warm = run->moment().report.heat.surface;
  EXPECT_GT(std::abs(warm - kBodyCelsius), 0.1) << "the drive heats it, the spray cools it";
  run->jumpTo(run->samples());
  ASSERT_TRUE(settles(*run, seen));
  EXPECT_NEAR(run->moment().report.heat.surface, live_heat_.surface, 0.01);
  EXPECT_NE(run->moment().report.heat.surface, warm);
  run->jumpTo(middle);
  ASSERT_TRUE(settles(*run, seen));
  EXPECT_EQ(run->moment().report.heat.surface, warm);
  run->jumpTo(0);
  ASSERT_TRUE(settles(*run, seen));
  EXPECT_EQ(run->moment().report.heat.surface, kBodyCelsius);
}

TEST_F(WatchedRunTest, TheSceneCanBeCopiedAsWhileItIsCut) {
  const auto run = watch(runFolder());
  ASSERT_TRUE(run);
  Picture seen;
  ASSERT_TRUE(settles(*run, seen));
  run->jumpTo(run->samples());
  ASSERT_TRUE(settles(*run, seen));
  const auto view = run->viewScene();
  ASSERT_TRUE(view);
  ASSERT_EQ(view->objects.size(), 1u);
  const auto copy = LiveRun::copyOf(*view);
  ASSERT_TRUE(copy) << copy.error().message();
  EXPECT_GT(copy->objects[0].changed.brickCount(), 0u) << "what was cut";
}

TEST_F(WatchedRunTest, ItIsPacedByTheClockAndPauseHolds) {
  const auto run = watch(runFolder());
  ASSERT_TRUE(run);
  Picture seen;
  ASSERT_TRUE(settles(*run, seen));
  EXPECT_EQ(run->moment().sample, 0u);
  const auto begin = std::chrono::steady_clock::now();
  run->play();
  ASSERT_TRUE(becomes(*run, seen, [&] { return run->moment().sample >= 1000; }));
  run->pause();
  EXPECT_GE(std::chrono::steady_clock::now() - begin, milliseconds(980)) << "a second takes a second";
  ASSERT_TRUE(settles(*run, seen));
  const std::size_t held = run->moment().sample;
  const Picture then = seen;
  std::this_thread::sleep_for(milliseconds(200));
  ASSERT_TRUE(settles(*run, seen));
  EXPECT_EQ(run->moment().sample, held);
  EXPECT_TRUE(seen == then);
  EXPECT_FALSE(run->moment().verdict) << "nobody knows yet";
}

TEST_F(WatchedRunTest, BackAndForthEndsInTheSameStateAndPicture) {
  const auto run = watch(runFolder());
  ASSERT_TRUE(run);
  ASSERT_EQ(run->steps().size(), 5u);
  EXPECT_EQ(run->steps()[2].kind, WatchedStep::Kind::kUndo);
  const std::size_t places[] = {run->steps()[0].end, run->steps()[1].end, run->steps()[3].end, run->steps()[4].end};

  // Each place through others, and each alone in a fresh replay. From the first to the second, the replay takes a state
  // kept between them. The second undo reaches back behind that state, which the replay discovers on the way.
  Picture seen;
  std::map<std::size_t, Picture> at;
  std::map<std::size_t, double> removed;
  for (const int n : {1, 0, 1, 2, 3, 0, 2, 1, 3, 0}) {
    run->jumpTo(places[n]);
    ASSERT_TRUE(settles(*run, seen));
    ASSERT_EQ(run->moment().sample, places[n]);
    if (!at.contains(places[n])) {
      const auto alone = watch(runFolder(), 1e6);
      ASSERT_TRUE(alone);
      alone->jumpTo(places[n]);
      ASSERT_TRUE(settles(*alone, at[places[n]]));
      removed[places[n]] = alone->moment().report.objects[0].removed_mm3;
    }
    EXPECT_TRUE(seen == at[places[n]]) << "place " << n;
    EXPECT_EQ(run->moment().report.objects[0].removed_mm3, removed[places[n]]);
  }
  EXPECT_FALSE(at[places[0]] == at[places[1]]) << "a stroke is seen";

  run->jumpTo(run->samples());
  ASSERT_TRUE(settles(*run, seen));
  ASSERT_TRUE(run->moment().verdict);
  EXPECT_TRUE(run->moment().verdict->is_same) << run->moment().verdict->text;
  EXPECT_TRUE(seen == *live_);
  run->jumpTo(0);
  ASSERT_TRUE(settles(*run, seen));
  EXPECT_FALSE(run->moment().verdict);
  EXPECT_EQ(run->moment().report.objects[0].removed_mm3, 0);
}

TEST_F(WatchedRunTest, ALogThatIsCutShortSaysSo) {
  const fs::path copy = folder_->path() / "short.run";
  fs::copy(runFolder(), copy, fs::copy_options::recursive);
  const fs::path log = copy / internal::kRunLog;
  fs::resize_file(log, fs::file_size(log) * 2 / 3);
  const auto run = watch(copy);
  ASSERT_TRUE(run);
  Picture seen;
  run->setSpeed(WatchedRun::kFastest);
  run->play();
  ASSERT_TRUE(becomes(*run, seen, [&] { return run->moment().is_at_end && run->isSettled(); }));
  ASSERT_TRUE(run->moment().verdict);
  EXPECT_FALSE(run->moment().verdict->is_same);
  EXPECT_FALSE(run->moment().verdict->is_whole);
  EXPECT_NE(run->moment().verdict->text.find("cut off"), std::string::npos) << run->moment().verdict->text;
}

TEST_F(WatchedRunTest, WhatDiffersIsSaid) {
  const fs::path copy = folder_->path() / "other.run";
  fs::copy(runFolder(), copy, fs::copy_options::recursive);
  auto manifest = readRunManifest(copy);
  ASSERT_TRUE(manifest);
  manifest->state_hash = "0123456789abcdef";
  ASSERT_TRUE(writeRunManifest(copy, *manifest));
  const auto run = watch(copy);
  ASSERT_TRUE(run);
  Picture seen;
  run->jumpTo(run->samples());
  ASSERT_TRUE(settles(*run, seen));
  ASSERT_TRUE(run->moment().verdict);
  EXPECT_FALSE(run->moment().verdict->is_same);
  EXPECT_TRUE(run->moment().verdict->is_whole);
  EXPECT_NE(run->moment().verdict->text.find("0123456789abcdef"), std::string::npos) << run->moment().verdict->text;
}

TEST_F(WatchedRunTest, ASessionThatIsOpenIsRefused) {
  const fs::path copy = folder_->path() / "open.run";
  fs::copy(runFolder(), copy, fs::copy_options::recursive);
  auto manifest = readRunManifest(copy);
  ASSERT_TRUE(manifest);
  manifest->is_open = true;
  ASSERT_TRUE(writeRunManifest(copy, *manifest));
  const auto run = WatchedRun::open(copy, {});
  ASSERT_FALSE(run);
  EXPECT_NE(run.error().hint.find("kerf recover"), std::string::npos) << run.error().message();
}

}  // namespace
}  // namespace kerf::watched_run_test
