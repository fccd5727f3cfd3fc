// What takes a force away when Kerf is killed, or cannot do so at its end: the guard by itself, and behind each device
// that would go on. How long it takes: hid_arm_loop_test.cpp.
#include "sim/device/zero_guard.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "sim/device/hid_arm.h"
#include "sim/device/pid_device.h"
#include "sim/device/rumble_pad.h"
#include "sim/device/woody_arm.h"
#include "tests/sim/device/force_scene.h"
#include "tests/sim/device/pid_scene.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/woody_firmware.h"
#include "tests/support/zero_guard_process.h"

namespace kerf::zero_guard_test {
namespace {

using namespace test;
namespace fs = std::filesystem;

Bytes contentOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(in), {});
}

// A file in the place of a node, of a name that a shell would take apart.
class GuardedFile : public testing::Test {
 protected:
  void SetUp() override { std::ofstream(file_) << ""; }
  const TemporaryFolder folder_;
  const fs::path file_ = folder_.path() / "it's a \"node\" of 100% $HOME; *\\n";
  const std::vector<Bytes> reports_{{0, 0x0A, 0xFF, '%', '\\'}, {'n', 0, 0}};
};

TEST_F(GuardedFile, IsWrittenWhenItsProgramIsKilledAndNotBefore) {
  Doomed program([&]() -> std::function<void()> {
    auto guard = ZeroGuard::start(file_, reports_);
    if (!guard) return {};
    std::ofstream(folder_.path() / "begun") << "";
    return [kept = std::make_shared<ZeroGuard>(std::move(*guard))] {};
  });
  // Not before: until its start has returned it may be ended by a signal.
  ASSERT_TRUE(until([&] { return fs::exists(folder_.path() / "begun"); }));
  const pid_t guard = guardOf(program.process());
  ASSERT_GT(guard, 0);
  EXPECT_EQ(::getsid(guard), guard) << "a session of its own: Ctrl-C at a terminal does not reach it";
  for (const int signal : {SIGINT, SIGHUP, SIGTERM, SIGQUIT}) ::kill(guard, signal);
  EXPECT_EQ(contentOf(file_), Bytes());
  program.kill();
  ASSERT_TRUE(until([&] { return !contentOf(file_).empty(); }));
  EXPECT_TRUE(until([&] { return contentOf(file_) == (Bytes{0, 0x0A, 0xFF, '%', '\\', 'n', 0, 0}); }));
  EXPECT_TRUE(until([&] { return ::kill(guard, 0) != 0; })) << "it ends";
}

TEST_F(GuardedFile, IsWrittenWhenItsGuardIsLetGoUnreleased) {
  pid_t process = 0;
  {
    const auto guard = ZeroGuard::start(file_, reports_);
    ASSERT_TRUE(guard) << guard.error().message();
    process = guardOf(::getpid());
    ASSERT_NE(process, 0);
  }
  EXPECT_TRUE(until([&] { return contentOf(file_) == (Bytes{0, 0x0A, 0xFF, '%', '\\', 'n', 0, 0}); }));
  EXPECT_TRUE(until([&] { return guardOf(::getpid()) == 0; })) << "it ends";
}

TEST_F(GuardedFile, IsLeftAloneOnceItsGuardIsReleased) {
  pid_t process = 0;
  {
    auto guard = ZeroGuard::start(file_, reports_);
    ASSERT_TRUE(guard) << guard.error().message();
    process = guardOf(::getpid());
    ASSERT_NE(process, 0);
    EXPECT_TRUE(guard->isThere());
    ZeroGuard moved = std::move(*guard);
    EXPECT_TRUE(moved.isThere());
    EXPECT_FALSE(guard->isThere());
    moved.release();
    EXPECT_FALSE(moved.isThere());
  }
  EXPECT_NE(::kill(process, 0), 0) << "it has ended, and was waited for";
  EXPECT_EQ(contentOf(file_), Bytes());
}

TEST_F(GuardedFile, IsKnownToHaveNoGuardWhenThatIsKilled) {
  auto guard = ZeroGuard::start(file_, reports_);
  ASSERT_TRUE(guard) << guard.error().message();
  const pid_t process = guardOf(::getpid());
  ASSERT_GT(process, 0) << "a signal to 0 would end all of this group";
  ::kill(process, SIGKILL);
  EXPECT_TRUE(until([&] { return !guard->isThere(); }));
}

TEST_F(GuardedFile, ThatDoesNotOpenIsRefused) {
  const auto none = ZeroGuard::start(folder_.path() / "none", reports_);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Error::Code::kUnreadable);
  EXPECT_FALSE(fs::exists(folder_.path() / "none")) << "nor made";
  EXPECT_FALSE(ZeroGuard().isThere());
}

// ---- Behind each device

class KilledKerf : public OnTestbed {
 protected:
  static constexpr SimulatedHid woody() {
    return {.vendor = 0x1234, .product = 6, .name = "Woody", .interfaces = {{0xFF00, 1}}};
  }
  void talkAsWoody() {
    talk([firmware = WoodyFirmware(*bed_, 0, {})] { return firmware.report(); });
  }
};

TEST_F(KilledKerf, LeavesNoCurrentInAWoody) {
  bed_->plugIn(woody());
  talkAsWoody();
  Doomed kerf([]() -> std::function<void()> {
    auto opened = openArm(HidTestbed::path(0), {.limits = {.force = 3, .rate = 500, .ramp_s = 0.1}});
    if (!opened || !calibrated(*opened->arm)) return {};
    const std::shared_ptr<ForceArm> arm = std::move(opened->arm);
    arm->enable(true);
    arm->arm();
    return [arm] {
      (void)arm->read();
      arm->write({{0, 0, 1}, Vec3d::Zero()});
    };
  });
  ASSERT_TRUE(until([&] { return !lastWritten().empty() && lastWritten()[5] != 0; }));
  kerf.kill();
  ASSERT_TRUE(until([&] { return lastWritten() == Bytes(15); }));
}

TEST_F(KilledKerf, CouldLeaveAForceInAWoodyWhoseGuardIsGoneSoItGetsNone) {
  bed_->plugIn(woody());
  talkAsWoody();
  auto arm = open();
  ASSERT_TRUE(arm && calibrated(*arm));
  arm->enable(true);
  Pusher pusher(*arm, {0, 0, 1});
  ASSERT_TRUE(until([&] { return lastWritten() != Bytes(15); }));
  EXPECT_EQ(arm->counts().trouble, "");
  const pid_t guard = guardOf(::getpid());
  ASSERT_GT(guard, 0) << "a signal to 0 would end all of this group";
  ::kill(guard, SIGKILL);
  // It needs a processor to die: reports count from when it is seen gone.
  ASSERT_TRUE(until([] { return guardOf(::getpid()) == 0; }));
  EXPECT_LE(forcesAfter([] {}, [](const Bytes& b) { return b != Bytes(15); }), kDeadMan);
  EXPECT_TRUE(until([&] { return arm->counts().trouble.find("guards it is gone") != std::string::npos; }))
      << arm->counts().trouble;
}

// An arm by Kerf's own profile has its deadline.
TEST_F(KilledKerf, NeedsNoGuardForAnArmWithADeadline) {
  bed_->plugIn(raw_);
  auto arm = open();
  ASSERT_TRUE(arm);
  EXPECT_EQ(guardOf(::getpid()), 0);
}

// Else it would come back at another node, and by its path never.
TEST_F(KilledKerf, IsNotWaitedForOnceTheArmIsUnplugged) {
  bed_->plugIn(woody());
  auto arm = open();
  ASSERT_TRUE(arm);
  ASSERT_NE(guardOf(::getpid()), 0);
  bed_->unplug(woody());
  ASSERT_TRUE(until([&] { return arm->isGone(); }));
  EXPECT_TRUE(until([&] { return guardOf(::getpid()) == 0; }));
}

// ---- At an end whose last report is lost

class ClosedKerf : public KilledKerf {};

TEST_F(ClosedKerf, LeavesNoCurrentInAWoodyThatTakesNoReportFromIt) {
  bed_->plugIn(woody());
  talkAsWoody();
  auto arm = open();
  ASSERT_TRUE(arm && calibrated(*arm));
  arm->enable(true);
  {
    Pusher pusher(*arm, {0, 0, 1});
    ASSERT_TRUE(until([&] { return lastWritten() != Bytes(15); }));
    bed_->refuseWriters(0);
    bed_->forgetWritten(0);
  }
  EXPECT_TRUE(bed_->written(0).empty());
  arm.reset();
  EXPECT_TRUE(until([&] { return bed_->written(0) == (std::vector{Bytes(15), Bytes(15)}); })) << "by its guard";
}

TEST_F(ClosedKerf, LetsAPadThatTakesNoReportFromItStandStill) {
  bed_->plugIn({.vendor = 0x054c, .product = 0x0ce6, .name = "Pad", .interfaces = {{1, 5}}});
  auto pad = RumblePad::open(0x054c, 0x0ce6);
  ASSERT_TRUE(pad) << pad.error().message();
  ASSERT_TRUE(until([&] {
    (*pad)->set({1, 1});
    return !bed_->written(0).empty();
  }));
  bed_->refuseWriters(0);
  bed_->forgetWritten(0);
  ASSERT_TRUE(until([&] {
    (*pad)->set({});
    return !(*pad)->isConnected();
  }));
  const std::vector<std::uint8_t> rest = rumbleReport(PadKind::kDualSense, {}, 0);
  EXPECT_TRUE(until([&] { return bed_->written(0) == (std::vector<Bytes>{rest}); })) << "by its guard, once";
}

class ClosedPid : public PidDevices {};

TEST_F(ClosedPid, StopsAllEffectsOfADeviceThatTakesNoReportFromIt) {
  plugIn(3);
  auto device = PidDevice::open(listHid().front());
  ASSERT_TRUE(device) << device.error().message();
  bed_->refuseWriters(0);
  bed_->forgetWritten(0);
  device->reset();
  EXPECT_TRUE(until([&] { return bed_->written(0) == (std::vector<Bytes>{{0x0C, 4}, {0x0C, 2}}); })) << "by its guard";
}

struct Pad {
  const char* name;
  std::uint16_t vendor, product;
  bool is_bluetooth;
  Bytes rest;  // all of its bytes
};
Bytes padded(Bytes head, std::size_t size, const Bytes& tail = {}) {
  head.resize(size - tail.size());
  head.insert(head.end(), tail.begin(), tail.end());
  return head;
}

class KilledPad : public OnTestbed, public testing::WithParamInterface<Pad> {};

TEST_P(KilledPad, StandsStill) {
  const Pad& what = GetParam();
  bed_->plugIn({.vendor = what.vendor,
                .product = what.product,
                .name = "Pad",
                .interfaces = {{1, 5}},
                .is_bluetooth = what.is_bluetooth});
  Doomed kerf([&]() -> std::function<void()> {
    auto opened = RumblePad::open(what.vendor, what.product);
    if (!opened) return {};
    return [pad = std::shared_ptr<RumblePad>(std::move(*opened))] { pad->set({0.5, 0.5}); };
  });
  // A child that was kept waiting may have sent rest again since.
  ASSERT_TRUE(until([&] {
    const auto reports = bed_->written(0);
    return std::any_of(reports.begin(), reports.end(), [&](const Bytes& report) { return report != what.rest; });
  })) << "it shakes";
  kerf.kill();
  EXPECT_TRUE(until([&] { return lastWritten() == what.rest; }));
}

// Checksums by zlib's crc32.
INSTANTIATE_TEST_SUITE_P(
    Pads, KilledPad,
    testing::Values(Pad{"DualSense", 0x054c, 0x0ce6, false, padded({0x02, 0x03}, 48)},
                    Pad{"DualSenseBluetooth", 0x054c, 0x0ce6, true,
                        padded({0x31, 0x00, 0x10, 0x03}, 78, {0xCC, 0x64, 0x2E, 0x96})},
                    Pad{"DualShock4", 0x054c, 0x09cc, false, padded({0x05, 0x01}, 32)},
                    Pad{"DualShock4Bluetooth", 0x054c, 0x09cc, true,
                        padded({0x11, 0xC0, 0x00, 0x01}, 78, {0x8D, 0xF5, 0x2D, 0xE0})},
                    Pad{"XboxBluetooth", 0x045e, 0x0b13, true, {0x03, 0x0F, 0, 0, 0, 0, 0xFF, 0x00, 0xEB}}),
    [](const auto& tested) { return tested.param.name; });

class KilledPid : public PidDevices {};

TEST_F(KilledPid, StopsAllEffectsAndItsActuators) {
  plugIn(3);
  Doomed kerf([]() -> std::function<void()> {
    auto opened = PidDevice::open(listHid().front());
    if (!opened) return {};
    return [device = std::shared_ptr<PidDevice>(std::move(*opened))] { device->set({.right = 0.5}); };
  });
  const auto all = [&] { return bed_->written(0); };
  ASSERT_TRUE(until([&] {
    const auto reports = all();
    return std::find(reports.begin(), reports.end(), Bytes{5, 1, 0x00, 0x40}) != reports.end();
  })) << "it is pushed";
  kerf.kill();
  ASSERT_TRUE(until([&] { return all().back() == (Bytes{0x0C, 2}); })) << "actuators off";
  EXPECT_EQ(*(all().end() - 2), (Bytes{0x0C, 4})) << "all stopped";
}

// ---- On a serial port

TEST(KilledSerial, LeavesNoCurrentInTheArm) {
  const int far = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  ASSERT_GE(far, 0);
  ASSERT_EQ(::grantpt(far), 0);
  ASSERT_EQ(::unlockpt(far), 0);
  const std::string port = std::string("serial:") + ::ptsname(far);
  Doomed kerf([&]() -> std::function<void()> {
    auto opened = openArm(port, {.limits = {.force = 3, .rate = 500, .ramp_s = 0.1}});
    if (!opened) return {};
    const std::shared_ptr<ForceArm> arm = std::move(opened->arm);
    arm->calibrate();
    arm->enable(true);
    arm->arm();
    return [arm] {
      (void)arm->read();
      arm->write({{0, 0, 1}, Vec3d::Zero()});
    };
  });

  // Its firmware: an answer to each line. In its home pose a force upwards is the third motor's.
  std::string heard, last;
  const auto step = [&] {
    pollfd waits{far, POLLIN, 0};
    std::array<char, 256> bytes{};
    if (::poll(&waits, 1, 1) <= 0 || !(waits.revents & POLLIN)) return;
    const ssize_t size = ::read(far, bytes.data(), bytes.size());
    if (size > 0) heard.append(bytes.data(), static_cast<std::size_t>(size));
    for (std::size_t end = heard.find('\n'); end != heard.npos; end = heard.find('\n')) {
      last = heard.substr(0, end);
      heard.erase(0, end + 1);
      constexpr std::string_view kAnswer = "[3,0,0,0,0,0,0,0]\n";
      (void)!::write(far, kAnswer.data(), kAnswer.size());
    }
  };
  const auto holds = [&](const std::function<bool()>& condition) {
    return until([&] {
      step();
      return condition();
    });
  };
  EXPECT_TRUE(holds([&] { return !last.empty() && last != "[0,0,0]"; })) << last;
  EXPECT_TRUE(holds([&] { return last.starts_with("[0,0,-"); })) << last;
  kerf.kill();
  EXPECT_TRUE(holds([&] { return last == "[0,0,0]"; })) << last;
  ::close(far);
}

}  // namespace
}  // namespace kerf::zero_guard_test
