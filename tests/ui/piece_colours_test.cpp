// Piece colours chosen by the user: a command, the session's files, and the continued session.
#include "ui/app/view/piece_colours.h"

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <thread>

#include "geometry/formats/mesh_writer.h"
#include "sim/run/session/session_run.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/script/app_script.h"
#include "ui/app/workbench/sessions.h"

namespace kerf::piece_colours_test {
namespace {

namespace fs = std::filesystem;

// A bar of 6 x 1.6 x 1.2 mm, to be cut through by a disc.
class PieceColoursTest : public testing::Test {
 protected:
  struct Bench {
    explicit Bench(const TemporaryFolder& folder) : folder_(folder), bench(options(folder)) {}
    ~Bench() {
      bench.jobs->cancel();
      while (bench.jobs->running()) bench.update();
      bench.sessions->close();
      while (bench.jobs->running()) bench.update();
    }
    static WorkbenchOptions options(const TemporaryFolder& folder) {
      WorkbenchOptions out;
      out.data_folder = folder.path() / "data";
      out.tools = {"disc-22"};
      out.real_time = {.priority = 0, .lock_memory = false};
      return out;
    }
    Expected<void> run(const std::string& script) {
      return runScript(context, folder_.write("script.ks", script), [&] { bench.update(); });
    }
    void mustRun(const std::string& script) {
      const auto played = run(script);
      ASSERT_TRUE(played) << played.error().message();
    }
    // Pieces arrive with a delay.
    void waitForPieces(std::size_t count) {
      const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(2);
      while (bench.document->scene().pieceCount() != count && std::chrono::steady_clock::now() < end) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        bench.update();
      }
      ASSERT_EQ(bench.document->scene().pieceCount(), count);
    }
    std::map<std::string, std::string> colours() const {
      std::map<std::string, std::string> out;
      for (const SceneObject* piece : bench.document->scene().shown()) out[piece->name] = piece->colour;
      return out;
    }

    const TemporaryFolder& folder_;
    Workbench bench;
    Camera camera = *cameraFromView("top");
    AppContext context{.bench = bench, .camera = camera, .width = 400, .height = 300};
  };
  using Colours = std::map<std::string, std::string>;

  void SetUp() override { ASSERT_TRUE(writeMesh(bar_, test::blockMesh(true, {6, 1.6, 1.2}))); }
  void cutThrough(Bench& bench) const {
    bench.mustRun("file.open \"" + bar_.string() +
                  "\"\nwait\nview.fit\ncut.force 3\ncut.depth 2.2\ncut.press 200 150\nwait 5\ncut.release\n");
    bench.waitForPieces(2);
  }

  TemporaryFolder folder_;
  fs::path bar_ = folder_.path() / "bar.ply";
};

TEST_F(PieceColoursTest, TheyAreKeptWithTheRunAndComeBackWithIt) {
  fs::path first;
  {
    Bench now(folder_);
    ASSERT_NO_FATAL_FAILURE(cutThrough(now));
    now.mustRun("piece.choose 1\npiece.colour sky\npiece.choose 2\npiece.rename \"the left\"\npiece.colour\n");
    EXPECT_EQ(now.colours(), (Colours{{"piece 1", "sky"}, {"the left", "orange"}})) << "the first of the palette";
    now.mustRun("piece.colour purple\n");
    now.mustRun("piece.colour\n");
    EXPECT_EQ(now.colours()["the left"], "") << "behind the last one there is none";
    now.mustRun("piece.colour vermilion\n");

    const auto refused = now.run("piece.colour pink\n");
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message().find("orange, sky, green"), std::string::npos) << refused.error().message();
    first = now.bench.document->sessionFolder();
  }
  const auto manifest = readRunManifest(first);
  ASSERT_TRUE(manifest) << manifest.error().message();
  ASSERT_EQ(manifest->pieces.size(), 2u);
  EXPECT_EQ(manifest->pieces[0].colour, "sky");
  EXPECT_EQ(manifest->pieces[1].colour, "vermilion");

  Bench again(folder_);
  again.mustRun("file.open \"" + first.string() + "\"\nwait\n");
  ASSERT_NO_FATAL_FAILURE(again.waitForPieces(2));
  EXPECT_EQ(again.colours(), (Colours{{"piece 1", "sky"}, {"the left", "vermilion"}}));
  again.mustRun("replay.open \"" + first.string() + "\"\nwait\nreplay.end\nwait\n");
  EXPECT_EQ(again.colours()["the left"], "vermilion") << "also while it is watched";
}

TEST_F(PieceColoursTest, ThatOfAnObjectInOnePieceComesBack) {
  fs::path first;
  {
    Bench now(folder_);
    now.mustRun("file.open \"" + bar_.string() +
                "\"\nwait\nview.fit\npiece.choose 1\npiece.colour sky\ncut.force 2\ncut.depth 0.2\ncut.press 200 150\n"
                "wait 1\ncut.release\nwait 0.5\nexpect pieces 1 1\n");
    first = now.bench.document->sessionFolder();
  }
  ASSERT_TRUE(readRunManifest(first)->pieces.empty());

  Bench again(folder_);
  again.mustRun("file.open \"" + first.string() + "\"\nwait\n");
  ASSERT_EQ(again.colours().size(), 1u);
  EXPECT_EQ(again.colours().begin()->second, "sky");
  again.mustRun("replay.open \"" + first.string() + "\"\nwait\nreplay.end\nwait\n");
  EXPECT_EQ(again.colours().begin()->second, "sky") << "also while it is watched";
}

TEST_F(PieceColoursTest, ASessionWhoseProgramIsGoneKeepsThem) {
  fs::path run;
  {
    Bench now(folder_);
    ASSERT_NO_FATAL_FAILURE(cutThrough(now));
    now.mustRun("piece.choose 2\npiece.colour green\n");
    run = now.bench.document->sessionFolder();
  }
  // As left by a killed program: the log, and the files beside it.
  auto manifest = readRunManifest(run);
  ASSERT_TRUE(manifest);
  manifest->is_open = true;
  manifest->pieces.clear();
  ASSERT_TRUE(writeRunManifest(run, *manifest));

  const auto recovered = recoverRun(run);
  ASSERT_TRUE(recovered) << recovered.error().message();
  ASSERT_EQ(recovered->manifest.pieces.size(), 2u);
  EXPECT_EQ(recovered->manifest.pieces[0].colour, "");
  EXPECT_EQ(recovered->manifest.pieces[0].name, "piece 1");
  EXPECT_EQ(recovered->manifest.pieces[1].colour, "green");
}

TEST(PieceColours, ChangeTheHueAndLeaveLightShadeAndGloss) {
  const Rgba8 bright = {232, 222, 200, 90}, dark = {116, 111, 100, 90};
  for (const PieceColour& colour : pieceColours()) {
    std::vector<Rgba8> of{bright, dark};
    tint(of, colour);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(of[0][k], 0.33 * bright[k] + 0.66 * colour.colour[k], 8) << colour.name;
      EXPECT_NEAR(of[1][k], 0.5 * of[0][k], 2) << "half as bright: half as bright in another hue";
    }
    EXPECT_EQ(of[0][3], 90);
  }
  EXPECT_EQ(findPieceColour("sky")->colour[2], 233);
  EXPECT_FALSE(findPieceColour("none"));
}

}  // namespace
}  // namespace kerf::piece_colours_test
