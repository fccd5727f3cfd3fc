// The window's force-feedback arm, without a window: a simulated arm behind a bridge leads the workbench's tool,
// through datagrams, mailboxes and the haptic thread. Frame stamps measure the duration of a force.
#include "ui/app/session/arm_lead.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <optional>
#include <thread>

#include "bridges/simulated/arm_simulator.h"
#include "geometry/formats/mesh_writer.h"
#include "sim/device/arm/bridge_device.h"
#include "sim/device/hid/device_driver.h"
#include "sim/run/report/replay.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/script/app_script.h"
#include "ui/app/workbench/force_device.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/strokes.h"

namespace kerf::arm_lead_test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

// Kerf's 20 ms, the arm's next tick, and the transit of a frame. The system may suspend Kerf's thread between clock and
// socket.
constexpr double kForcelessMs = 20 + 2;

CutPath way(const std::vector<std::pair<double, Vec3d>>& points) {
  CutPath path;
  for (const auto& [t, p] : points) path.poses.push_back({t, {Eigen::Quaterniond::Identity(), p}});
  path.cuts.assign(path.poses.size() - 1, 1);
  return path;
}

class ArmLeadTest : public testing::Test {
 protected:
  void SetUp() override {
    const fs::path scan = folder_.path() / "block.ply";
    ASSERT_TRUE(writeMesh(scan, test::blockMesh(true)));
    WorkbenchOptions options;
    options.data_folder = folder_.path() / "data";
    options.tools = {"round-014"};
    options.real_time = {.priority = 0, .lock_memory = false};
    options.device = "udp:0";
    bench_ = std::make_unique<Workbench>(options);
    ASSERT_TRUE(bench_->device->arm().isOpen()) << notices();
    bench_->sessions->open(scan);
    ASSERT_TRUE(until([&] { return bench_->document->isOpen() && !bench_->jobs->running(); }, 120)) << notices();
  }
  bool until(const std::function<bool()>& holds, double most_s = 20) {
    const auto end = steady_clock::now() + std::chrono::duration<double>(most_s);
    while (steady_clock::now() < end) {
      bench_->update();
      if (holds()) return true;
      std::this_thread::sleep_for(milliseconds(1));
    }
    return holds();
  }
  /// Duration of its force after `since`, by frame stamps, ms.
  double forceAfterMs(const ArmSimulator& arm, std::int64_t since) {
    EXPECT_TRUE(until([&] { return !arm.report().is_enabled; }));
    return 1e-6 * static_cast<double>(arm.report().stopped_ns - since);
  }
  std::uint16_t port() { return static_cast<BridgeDevice*>(bench_->device->arm().arm())->port(); }
  // From 1.5 mm over the block down into it, then in circles.
  static CutPath presses() {
    std::vector<std::pair<double, Vec3d>> points{{0, {0, 0, 0}}, {2, {0, 0, 0}}, {3, {0, 0, -6}}};
    for (int n = 1; n < 300; ++n)
      points.push_back({3 + 0.1 * n, {0.5 * std::sin(0.2 * n), 0.5 * std::sin(0.13 * n), -6}});
    return way(points);
  }
  std::unique_ptr<ArmSimulator> press() {
    auto arm = ArmSimulator::start(presses(), {.port = port(), .hand = {}});
    EXPECT_TRUE(arm);
    return std::move(*arm);
  }
  Expected<void> run(const char* id, const std::vector<std::string>& words = {}) {
    return runAppCommand(context_(), id, words);
  }
  std::string notices() const {
    std::string out;
    for (const Notice& notice : bench_->notices->list()) out += notice.text + "\n";
    return out;
  }
  fs::path end() {
    const fs::path out = bench_->document->sessionFolder();
    bench_->sessions->close();
    EXPECT_TRUE(until([&] { return !bench_->jobs->running(); }));
    return out;
  }
  AppContext& context_() {
    if (!context_of_) context_of_.emplace(AppContext{.bench = *bench_, .camera = camera_});
    return *context_of_;
  }

  TemporaryFolder folder_;
  Camera camera_ = *cameraFromView("top");
  std::unique_ptr<Workbench> bench_;
  std::optional<AppContext> context_of_;
};

TEST_F(ArmLeadTest, TheArmLeadsCutsAndIsFeltAndTheLogReplaysBitForBit) {
  const auto arm = press();
  ASSERT_TRUE(until([&] { return bench_->device->isLed(); })) << bench_->device->arm().view().missing;
  EXPECT_FALSE(bench_->device->arm().isArmed()) << "nobody has armed it";
  ASSERT_TRUE(until([&] { return bench_->document->report().output.touching > 0; }));
  EXPECT_EQ(arm->report().most_force, 0) << "no force before it is armed";

  ASSERT_TRUE(run("device.arm")) << bench_->device->arm().view().missing;
  ASSERT_TRUE(until([&] { return arm->report().is_enabled && arm->report().force.norm() > 0.1; }));
  ASSERT_TRUE(until([&] { return bench_->document->removedMm3() > 0.05; }));
  EXPECT_LE(arm->report().most_force, bench_->device->arm().choice().most_force + 1e-9);
  EXPECT_GT(bench_->device->arm().view().age_p50_ms, 0);

  ASSERT_TRUE(run("device.disarm"));
  EXPECT_LE(forceAfterMs(*arm, deviceClock()), kForcelessMs);
  EXPECT_TRUE(bench_->device->isLed()) << "the hand leads on";

  const double removed = bench_->document->removedMm3();
  const fs::path session = end();
  const auto replayed = replayRun(session);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  EXPECT_GE(replayed->removed_mm3, removed - 0.01);
}

TEST_F(ArmLeadTest, UndoAndCloseTakeTheForceAwayAndItFadesInAgain) {
  const auto arm = press();
  ASSERT_TRUE(until([&] { return bench_->device->isLed(); }));
  ASSERT_TRUE(run("device.arm"));
  ASSERT_TRUE(until([&] { return bench_->document->removedMm3() > 0.02 && arm->report().force.norm() > 0.05; }));

  bench_->steps->undo();
  ASSERT_TRUE(until([&] { return bench_->document->report().counts.pauses > 0; }));
  ASSERT_TRUE(until([&] { return arm->report().is_enabled && arm->report().force.norm() > 0.05; })) << "felt again";
  EXPECT_LE(arm->report().most_force, 3 + 1e-9) << "tissue came back around the tool";

  ASSERT_TRUE(run("device.close"));
  EXPECT_FALSE(bench_->device->isLed());
  EXPECT_LE(forceAfterMs(*arm, deviceClock()), kForcelessMs);
  EXPECT_EQ(arm->report().force, Vec3d::Zero());
}

TEST_F(ArmLeadTest, AKilledArmMidCutLosesNothingAndTheMouseGoesOn) {
  const std::uint16_t at = port();
  const CutPath path = presses();
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto arm = ArmSimulator::start(path, {.port = at, .hand = {}});
    std::this_thread::sleep_for(std::chrono::seconds(100));
    ::_exit(arm ? 0 : 1);
  }
  const bool was_led = until([&] { return bench_->device->isLed(); });
  const bool was_armed = was_led && run("device.arm").has_value();
  const bool has_cut = until(
      [&] { return bench_->document->removedMm3() > 0.05 && bench_->device->arm().view().felt.force.norm() > 0.05; });
  const double removed = bench_->document->removedMm3();
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  ASSERT_TRUE(was_led && was_armed && has_cut) << bench_->device->arm().view().missing;
  ASSERT_TRUE(until([&] { return !bench_->device->arm().view().counts.is_enabled; }));
  ASSERT_TRUE(until([&] { return !bench_->device->isLed(); })) << "it is gone: the mouse leads";
  EXPECT_FALSE(bench_->device->arm().isArmed()) << "one that comes back is armed anew";
  EXPECT_NE(notices().find("force off"), std::string::npos) << notices();
  EXPECT_GE(bench_->document->removedMm3(), removed);

  // The mouse continues from the arm's place.
  ASSERT_TRUE(until([&] { return bench_->strokes->press({{-2, 0, 50}, {0, 0, -1}}); }));
  ASSERT_TRUE(until([&] { return bench_->document->removedMm3() > removed + 0.02; }));
  bench_->strokes->release();

  // The arm takes over again.
  const auto arm = press();
  ASSERT_TRUE(until([&] { return bench_->device->isLed(); }));
  EXPECT_FALSE(bench_->strokes->press({{2, 0, 50}, {0, 0, -1}})) << "one hand at a time";

  const fs::path session = end();
  const auto replayed = replayRun(session);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
}

TEST_F(ArmLeadTest, ASessionForAStifferHandIsNotFeltUntilItFits) {
  auto arm = ArmSimulator::start(presses(), {.port = port(), .hand = {}, .most_stiffness = 0.2});
  ASSERT_TRUE(arm);
  ASSERT_TRUE(until([&] { return bench_->device->isLed(); }));
  const auto refused = run("device.arm");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("device.fit"), std::string::npos) << refused.error().message();
  EXPECT_FALSE(bench_->device->arm().isArmed());

  ASSERT_TRUE(run("device.fit"));
  ASSERT_TRUE(
      until([&] { return !bench_->jobs->running() && bench_->document->isOpen() && bench_->device->isLed(); }, 60))
      << notices();
  EXPECT_LE(bench_->document->run()->model().settings.coupling.stiffness, 0.2 + 1e-9);
  EXPECT_TRUE(run("device.arm"));
}

TEST_F(ArmLeadTest, ATestForceIsGentleAndNeedsAnArmedDeviceInTheAir) {
  auto arm = ArmSimulator::start(way({{0, {0, 0, 0}}, {100, {0, 0, 0}}}), {.port = port(), .hand = {}});
  ASSERT_TRUE(arm);
  ASSERT_TRUE(until([&] { return bench_->device->isLed(); }));
  EXPECT_FALSE(run("device.test")) << "not armed";
  ASSERT_TRUE(run("device.arm"));
  EXPECT_FALSE(run("device.test", {"2"})) << "too much";
  ASSERT_TRUE(until([&] { return bench_->device->arm().view().felt.ramp >= 1; }));
  ASSERT_TRUE(run("device.test", {"0.5", "1", "0", "0"}));
  ASSERT_TRUE(until([&] { return (*arm)->report().force[0] > 0.45; }));
  ASSERT_TRUE(until([&] { return (*arm)->report().force.norm() < 1e-9; }));
  EXPECT_LE((*arm)->report().most_force, ForceArm::kMostTestForce)
      << "with what the coupling feels of it, more of it where threads wait";
}

TEST_F(ArmLeadTest, ScaleAndTurnLeaveTheToolWhereItIs) {
  auto arm = ArmSimulator::start(way({{0, {0, 0, 0}}, {100, {0, 0, 0}}}), {.port = port(), .hand = {}});
  ASSERT_TRUE(arm);
  ASSERT_TRUE(until([&] { return bench_->device->isLed(); }));
  const Vec3d before = bench_->document->report().output.T_world_tool.translation;
  ASSERT_TRUE(run("device.scale", {"0.25"}));
  ASSERT_TRUE(run("device.turn", {"90"}));
  const auto ticks = bench_->document->report().tick + 200;
  ASSERT_TRUE(until([&] { return bench_->document->report().tick > ticks; }));
  EXPECT_LT((bench_->document->report().output.T_world_tool.translation - before).norm(), 0.1);

  ASSERT_TRUE(run("device.place", {"1", "2", "9"}));
  ASSERT_TRUE(until(
      [&] { return (bench_->document->report().output.T_world_tool.translation - Vec3d(1, 2, 9)).norm() < 0.1; }));
}

}  // namespace
}  // namespace kerf::arm_lead_test
