// What is seen of the tissues of the demo molar. Skipped, with a word, where no OpenGL can be had.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <thread>

#include "tests/support/temporary_folder.h"
#include "ui/app/app_commands.h"
#include "ui/app/app_script.h"
#include "ui/app/tissue_display.h"
#include "ui/window/gl_context.h"
#include "ui/window/live_view.h"

namespace kerf {
namespace {

constexpr int kWidth = 320, kHeight = 240;

constexpr Rgba8 kEnamel = {0xf4, 0xf1, 0xe8, 255}, kDentin = {0xe8, 0xcf, 0x9a, 255}, kPulp = {0xc8, 0x43, 0x4b, 255};

/// Pixels within `most` of a colour, in each channel.
int countNear(const Image& image, const Rgba8& colour, int most = 6) {
  int n = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    bool is_near = true;
    for (std::size_t k = 0; k < 3; ++k) is_near &= std::abs(int{image.rgba[i + k]} - int{colour[k]}) <= most;
    n += is_near ? 1 : 0;
  }
  return n;
}
/// As the light leaves them: far more red than green and blue.
int countRed(const Image& image) {
  int n = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4)
    n += image.rgba[i] > 70 && image.rgba[i] > 1.6 * image.rgba[i + 1] && image.rgba[i] > 1.5 * image.rgba[i + 2];
  return n;
}

/// Opened once for all tests: each begins with what is there as loaded.
class TissuePicture : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto made = OffscreenContext::create();
    if (!made) {
      why_ = made.error().message();
      return;
    }
    context_ = std::move(*made);
    view_ = std::move(*LiveView::create());
    folder_ = std::make_unique<TemporaryFolder>();
    WorkbenchOptions options;
    options.data_folder = folder_->path() / "data";
    options.tools = {"round-014"};
    options.voxel_mm = 0.15;
    options.real_time = {.priority = 0, .lock_memory = false};
    bench_ = std::make_unique<Workbench>(options);
    bench_->openDemo("molar");
    while (bench_->job() || (bench_->isOpen() && bench_->scene().triangleCount() == 0)) frame();
  }
  static void TearDownTestSuite() {
    view_.reset();
    bench_.reset();
    context_.reset();
    folder_.reset();
  }
  void SetUp() override {
    if (!context_) GTEST_SKIP() << why_;
    ASSERT_TRUE(bench_->isOpen()) << (bench_->notices().empty() ? "" : bench_->notices().back().text);
    run("view.from front");
  }
  void TearDown() override { bench_->section.reset(); }

  static void frame() {
    view_->update(*bench_);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  /// One line of a script, and what it takes.
  void run(const std::string& line) {
    const auto played = runScript(app_, folder_->write("line.ks", line + "\nwait\n"), frame);
    EXPECT_TRUE(played) << played.error().message();
  }
  Image picture() {
    view_->update(*bench_);
    auto image = view_->picture(*bench_, camera_, kWidth, kHeight);
    EXPECT_TRUE(image) << image.error().message();
    return image ? *image : Image{};
  }

  static inline std::unique_ptr<OffscreenContext> context_;
  static inline std::string why_;
  static inline std::unique_ptr<TemporaryFolder> folder_;
  static inline std::unique_ptr<Workbench> bench_;
  static inline std::unique_ptr<LiveView> view_;
  Camera camera_;
  AppContext app_{.bench = *bench_, .camera = camera_, .width = kWidth, .height = kHeight};
};

TEST_F(TissuePicture, ASectionShowsEnamelDentinAndPulpInTheirColours) {
  const Image whole = picture();
  EXPECT_EQ(countNear(whole, kPulp), 0);
  bench_->section = Plane{bench_->scene().bounds().center(), {0, -1, 0}};
  const Image front = picture();
  EXPECT_GT(countNear(front, kEnamel), 1500);
  EXPECT_GT(countNear(front, kDentin), 4000);
  EXPECT_GT(countNear(front, kPulp), 600);

  // The plane is sampled, not the view: from elsewhere the same tissues are there, a little narrower.
  run("view.from 30,20");
  const Image oblique = picture();
  EXPECT_NEAR(countNear(oblique, kPulp) / (0.8 * countNear(front, kPulp)), 1, 0.3);

  // Where it is in front of the tooth nothing is cut open.
  bench_->section->point[1] = bench_->scene().bounds().min[1] - 1;
  EXPECT_EQ(countNear(picture(), kPulp), 0);
}

TEST_F(TissuePicture, ASectionOfAPieceThatIsMovedShowsWhatIsInThePiece) {
  bench_->section = Plane{bench_->scene().bounds().center(), {0, -1, 0}};
  const int before = countNear(picture(), kPulp);
  const std::uint32_t id = bench_->scene().shown()[0]->id;
  const Vec3d middle = bench_->scene().bounds().center();

  // Turned about the axis of the view, and along the plane: the same section somewhere else.
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5, Vec3d::UnitY()));
  bench_->dragPiece(id, Rigid3{turn, middle - turn * middle + Vec3d(1, 0, 0)});
  EXPECT_NEAR(countNear(picture(), kPulp), before, 0.15 * before);

  // Towards the viewer: another section, in front of the pulp.
  bench_->dragPiece(id, Rigid3{Eigen::Quaterniond::Identity(), {0, 6, 0}});
  EXPECT_LT(countNear(picture(), kPulp), before / 2);
  bench_->dragPiece(id, std::nullopt);
}

}  // namespace
}  // namespace kerf
