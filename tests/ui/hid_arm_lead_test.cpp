// The window's HID arm, through the system's hidapi: it leads the workbench's tool, is unplugged during a cut, and
// returns. Skipped where umockdev is not preloaded.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "geometry/formats/mesh_writer.h"
#include "sim/device/arm/force_arm.h"
#include "sim/run/report/replay.h"
#include "tests/sim/device/simulated_arm.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/script/app_script.h"
#include "ui/app/session/arm_lead.h"
#include "ui/app/workbench/force_device.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/strokes.h"

namespace kerf::hid_arm_lead_test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr int kForceless = 20 + 2;  // steps of an arm: its deadline, the current step, a frame in transit

// From 1.5 mm over the block down into it, then in circles.
CutPath presses() {
  CutPath path;
  const auto go = [&](double t, const Vec3d& p) { path.poses.push_back({t, {Eigen::Quaterniond::Identity(), p}}); };
  go(0, {0, 0, 0});
  go(2, {0, 0, 0});
  go(3, {0, 0, -6});
  for (int n = 1; n < 600; ++n) go(3 + 0.1 * n, {0.5 * std::sin(0.2 * n), 0.5 * std::sin(0.13 * n), -6});
  path.cuts.assign(path.poses.size() - 1, 1);
  return path;
}

// A plugged-in arm with its own clock.
class PluggedArm {
 public:
  PluggedArm(HidTestbed& bed, const SimulatedHid& what) : bed_(bed), what_(what) {
    bed_.plugIn(what);
    body_.emplace(bed, presses(), DeviceHand::Options{}, what.first_node);
    thread_ = std::thread([this] {
      while (!is_over_) {
        std::this_thread::sleep_for(milliseconds(1));
        const std::lock_guard lock(mutex_);
        if (is_plugged_) body_->step();
      }
    });
  }
  ~PluggedArm() {
    is_over_ = true;
    thread_.join();
  }
  Vec3d force() const {
    const std::lock_guard lock(mutex_);
    return body_->force();
  }
  double mostForce() const {
    const std::lock_guard lock(mutex_);
    return body_->mostForce();
  }
  /// @return  number of its steps with continued force.
  int unplug() {
    const std::lock_guard lock(mutex_);
    is_plugged_ = false;
    bed_.unplug(what_);
    int steps = 0;
    for (; steps < 1000 && !body_->force().isZero(0); ++steps) body_->step();
    return steps;
  }

 private:
  HidTestbed& bed_;
  const SimulatedHid what_;
  mutable std::mutex mutex_;
  std::optional<test::SimulatedArm> body_;  // guarded by mutex_, as the next
  bool is_plugged_ = true;
  std::atomic<bool> is_over_{false};
  std::thread thread_;
};

class HidArmLead : public testing::Test {
 protected:
  void SetUp() override {
    if (!HidTestbed::isThere()) GTEST_SKIP() << "umockdev is not preloaded: run umockdev-wrapper kerf_led_tests";
    bed_ = std::make_unique<HidTestbed>();
  }
  void openBlock(const std::string& device) {
    const fs::path scan = folder_.path() / "block.ply";
    ASSERT_TRUE(writeMesh(scan, test::blockMesh(true)));
    WorkbenchOptions options;
    options.data_folder = folder_.path() / "data";
    options.tools = {"round-014"};
    options.real_time = {.priority = 0, .lock_memory = false};
    options.device = device;
    bench_ = std::make_unique<Workbench>(options);
    context_.emplace(AppContext{.bench = *bench_, .camera = camera_});
    ASSERT_TRUE(bench_->device->arm().isOpen()) << notices();
    ASSERT_TRUE(run("device.pedal", {"on"}));
    bench_->sessions->open(scan);
    ASSERT_TRUE(until([&] { return bench_->document->isOpen() && !bench_->jobs->running(); }, 120)) << notices();
  }
  bool until(const std::function<bool()>& holds, double most_s = 30) {
    const auto end = steady_clock::now() + std::chrono::duration<double>(most_s);
    while (steady_clock::now() < end) {
      bench_->update();
      if (holds()) return true;
      std::this_thread::sleep_for(milliseconds(1));
    }
    return holds();
  }
  Expected<void> run(const char* id, const std::vector<std::string>& words = {}) {
    return runAppCommand(*context_, id, words);
  }
  std::string notices() const {
    std::string out;
    for (const Notice& notice : bench_->notices->list()) out += notice.text + "\n";
    return out;
  }

  SimulatedHid raw_{.vendor = 0xCAFE,
                    .product = 0x4004,
                    .maker = "Me",
                    .name = "My arm",
                    .serial = "R-1",
                    .interfaces = {{0xFF4B, 1}}};
  TemporaryFolder folder_;
  Camera camera_ = *cameraFromView("top");
  std::unique_ptr<HidTestbed> bed_;
  std::unique_ptr<Workbench> bench_;
  std::optional<AppContext> context_;
};

TEST_F(HidArmLead, UnpluggedMidCutLosesNothingAndLeadsAgainWhenItIsPluggedIn) {
  PluggedArm first(*bed_, raw_);
  openBlock("R-1");
  ASSERT_TRUE(until([&] { return bench_->device->isLed(); })) << bench_->device->arm().view().missing;
  ASSERT_TRUE(run("device.arm")) << bench_->device->arm().view().missing;
  ASSERT_TRUE(until([&] { return bench_->document->removedMm3() > 0.05 && first.force().norm() > 0.05; }));

  // Unplugged during a cut with force.
  const double removed = bench_->document->removedMm3();
  EXPECT_LE(first.unplug(), kForceless);
  ASSERT_TRUE(until([&] { return !bench_->device->isLed(); })) << "it is gone: the mouse leads";
  EXPECT_FALSE(bench_->device->arm().isArmed());
  EXPECT_NE(notices().find("force off; arm the device again when it is back"), std::string::npos) << notices();
  EXPECT_NE(bench_->device->arm().view().missing.find("unplugged"), std::string::npos)
      << bench_->device->arm().view().missing;
  EXPECT_GE(bench_->document->removedMm3(), removed);

  ASSERT_TRUE(until([&] { return bench_->strokes->press({{-2, 0, 50}, {0, 0, -1}}); }));
  ASSERT_TRUE(until([&] { return bench_->document->removedMm3() > removed + 0.02; })) << "by the mouse";
  bench_->strokes->release();

  // Plugged in again, at another node: its serial number identifies it.
  SimulatedHid again = raw_;
  again.port = 2;
  again.first_node = 1;
  PluggedArm second(*bed_, again);
  ASSERT_TRUE(until([&] { return bench_->device->isLed(); })) << bench_->device->arm().view().missing;
  EXPECT_FALSE(bench_->device->arm().isArmed());
  const double by_mouse = bench_->document->removedMm3();
  ASSERT_TRUE(until([&] { return bench_->document->removedMm3() > by_mouse + 0.02; })) << "it leads, and cuts";
  EXPECT_EQ(second.mostForce(), 0) << "nobody has armed it since";
  ASSERT_TRUE(run("device.arm")) << bench_->device->arm().view().missing;
  ASSERT_TRUE(until([&] { return second.force().norm() > 0.05; }));

  const double in_all = bench_->document->removedMm3();
  const fs::path session = bench_->document->sessionFolder();
  bench_->sessions->close();
  ASSERT_TRUE(until([&] { return !bench_->jobs->running(); }));
  const auto replayed = replayRun(session);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  EXPECT_GE(replayed->removed_mm3, in_all - 0.01);
}

}  // namespace
}  // namespace kerf::hid_arm_lead_test
