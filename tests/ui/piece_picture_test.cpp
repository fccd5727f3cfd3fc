// Pieces drawn in separate colours. Skipped, with a message, if OpenGL is missing.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <thread>

#include "geometry/formats/mesh_writer.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "tests/ui/picture_compare.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/document/view_state.h"
#include "ui/app/script/app_script.h"
#include "ui/app/view/piece_colours.h"
#include "ui/app/view/tissue_display.h"
#include "ui/app/workbench/sessions.h"
#include "ui/window/draw/live_view.h"
#include "ui/window/gl/gl_context.h"

namespace kerf::piece_picture_test {
namespace {

/// In a picture of 400 x 300 pixels: bluish and reddish pixels in its left or right half.
struct Hues {
  int blue = 0, red = 0;
};
Hues huesOf(const Image& image, bool is_left) {
  Hues out;
  for (int y = 0; y < 300; ++y)
    for (int x = is_left ? 0 : 200; x < (is_left ? 200 : 400); ++x) {
      const std::uint8_t* const p = &image.rgba[4 * static_cast<std::size_t>(400 * y + x)];
      out.blue += p[2] > p[0] + 60;
      out.red += p[0] > p[2] + 90;
    }
  return out;
}

TEST(PiecePicture, TwoPiecesHaveTwoHues) {
  const auto opengl = OffscreenContext::create();
  if (!opengl) GTEST_SKIP() << opengl.error().message();
  auto view = LiveView::create();
  ASSERT_TRUE(view) << view.error().message();

  const TemporaryFolder folder;
  const auto bar = folder.path() / "bar.ply";
  ASSERT_TRUE(writeMesh(bar, test::blockMesh(true, {6, 1.6, 1.2})));
  WorkbenchOptions options;
  options.data_folder = folder.path() / "data";
  options.tools = {"disc-22"};
  options.real_time = {.priority = 0, .lock_memory = false};
  Workbench bench(options);
  Camera camera = *cameraFromView("top");
  AppContext context{.bench = bench, .camera = camera, .width = 400, .height = 300};
  const auto frame = [&] {
    (*view)->update(bench);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  };
  const auto run = [&](const std::string& script) {
    const auto played = runScript(context, folder.write("script.ks", script), frame);
    ASSERT_TRUE(played) << played.error().message();
  };
  const auto picture = [&] {
    frame();
    (*view)->hover({});
    auto image = (*view)->picture(bench, camera, 400, 300);
    EXPECT_TRUE(image);
    return *image;
  };

  run("file.open \"" + bar.string() +
      "\"\nwait\nview.fit\ncut.force 3\ncut.depth 2.2\ncut.press 200 150\nwait 5\ncut.release\nwait 1\n");
  // Pieces arrive with a delay.
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  while (bench.document->scene().pieceCount() != 2 && std::chrono::steady_clock::now() < end) frame();
  ASSERT_EQ(bench.document->scene().pieceCount(), 2u);
  // The disc stands in the gap between the pieces.
  const bool is_first_left = bench.document->scene().shown()[0]->surface.bounds().center()[0] < 0;
  const Hues before = huesOf(picture(), true), before_right = huesOf(picture(), false);
  run("piece.choose 1\npiece.colour blue\npiece.choose 2\npiece.colour vermilion\n");
  const Image coloured = picture();
  const Hues first = huesOf(coloured, is_first_left), second = huesOf(coloured, !is_first_left);
  EXPECT_GT(first.blue, before.blue + before_right.blue + 3000);
  EXPECT_GT(second.red, before.red + before_right.red + 3000);
  EXPECT_LT(first.red, second.red / 10);
  EXPECT_LT(second.blue, first.blue / 10);

  // A map shows values and has no other hue.
  run("view.colours depth\nwait\n");
  while (bench.views->tissues().isBusy()) frame();
  const Image map = picture();
  run("piece.colour none\npiece.choose 1\npiece.colour none\n");
  EXPECT_LT(test::pictureDifference(map, picture()), 0.5);
  run("view.colours tissue\n");
  EXPECT_LT(huesOf(picture(), is_first_left).blue, before.blue + before_right.blue + 300);

  bench.sessions->close();
  while (bench.jobs->running()) bench.update();
}

// View of a person without the red or the green cones: Vienot, Brettel & Mollon, Color Res Appl 1999;24:243.
TEST(PiecePicture, NoTwoColoursArePutTogetherByTheColourBlind) {
  const Eigen::Matrix3d protan{{0.11238, 0.88762, 0}, {0.11238, 0.88762, 0}, {0.00401, -0.00401, 1}};
  const Eigen::Matrix3d deutan{{0.29275, 0.70725, 0}, {0.29275, 0.70725, 0}, {-0.02234, 0.02234, 1}};
  const auto seen = [](const Eigen::Matrix3d& eye, const PieceColour& colour) {
    std::vector<Rgba8> tissue{{232, 222, 200, 90}};
    tint(tissue, colour);
    Vec3d linear;
    for (int k = 0; k < 3; ++k) linear[k] = std::pow(tissue[0][static_cast<std::size_t>(k)] / 255.0, 2.2);
    linear = (eye * linear).cwiseMax(0).cwiseMin(1);
    std::array<std::uint8_t, 3> out{};
    for (int k = 0; k < 3; ++k)
      out[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(std::lround(255 * std::pow(linear[k], 1 / 2.2)));
    return test::labOf(out.data());
  };
  constexpr double kSeen = 6;  // steps of CIELAB: a difference visible at a glance is 2 to 3
  for (const Eigen::Matrix3d& eye : {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), protan, deutan})
    for (const PieceColour& a : pieceColours())
      for (const PieceColour& b : pieceColours()) {
        if (&a == &b) continue;
        EXPECT_GT((seen(eye, a) - seen(eye, b)).norm(), kSeen) << a.name << " and " << b.name;
      }
}

}  // namespace
}  // namespace kerf::piece_picture_test
