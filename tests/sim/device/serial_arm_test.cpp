// The serial arm: its lines, and an arm behind a pseudo-terminal.
#include "sim/device/serial_arm.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <utility>

#include "sim/device/woody_arm.h"
#include "tests/sim/device/force_scene.h"

namespace kerf::serial_arm_test {
namespace {

using namespace test;

TEST(SerialArm, LinesAreReadStrictly) {
  SerialLine line;
  ASSERT_TRUE(parseSerialLine("[3,1,-2,30000,0,0,0,0]", line));
  EXPECT_EQ(line.model, 3);
  EXPECT_EQ(line.counts, (std::array{1, -2, 30000, 0, 0, 0}));
  for (const char* bad :
       {"", "[", "[]", "3,1,2,3,0,0,0,0", "[3,1,2,3,0,0,0]", "[3,1,2,3,0,0,0,0,0]", "[3,1,2,3,0,0,0,0] ",
        "[3,1,,3,0,0,0,0]", "[3,1, 2,3,0,0,0,0]", "[3,1,2.5,3,0,0,0,0]", "[3,1,12345678901,3,0,0,0,0]"})
    EXPECT_FALSE(parseSerialLine(bad, line)) << bad;
  EXPECT_EQ(line.counts[2], 30000) << "as it was";

  std::array<char, 64> text{};
  EXPECT_EQ(std::string(text.data(), writeSerialLine({12.4, -3, 9999}, text)), "[12,-3,2000]\n");
  EXPECT_EQ(std::string(text.data(), writeSerialLine({std::nan(""), 0, 0}, text)), "[0,0,0]\n");
}

// An arm at the far end of a pseudo-terminal: answers each line.
class SerialPort : public testing::Test {
 protected:
  void SetUp() override {
    far_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    ASSERT_GE(far_, 0);
    ASSERT_EQ(::grantpt(far_), 0);
    ASSERT_EQ(::unlockpt(far_), 0);
    name_ = std::string("serial:") + ::ptsname(far_);
    firmware_ = std::thread([this] { answer(); });
  }
  void TearDown() override { unplug(); }
  void unplug() {
    is_off_ = true;
    if (firmware_.joinable()) firmware_.join();
    if (far_ >= 0) ::close(far_);
    far_ = -1;
  }
  void answer() {
    std::string heard;
    std::array<char, 256> bytes{};
    while (!is_off_) {
      if (hangs_) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        continue;
      }
      pollfd waits{far_, POLLIN, 0};
      if (::poll(&waits, 1, 5) <= 0 || !(waits.revents & POLLIN)) continue;
      const ssize_t size = ::read(far_, bytes.data(), bytes.size());
      if (size <= 0) continue;
      heard.append(bytes.data(), static_cast<std::size_t>(size));
      const std::lock_guard lock(mutex_);
      for (std::size_t end = heard.find('\n'); end != heard.npos; end = heard.find('\n')) {
        last_ = heard.substr(0, end);
        ++lines_;
        heard.erase(0, end + 1);
        const bool is_told = is_silent_ || ::write(far_, says_.data(), says_.size()) > 0;
        EXPECT_TRUE(is_told);
      }
    }
  }
  void say(const std::string& line) {
    const std::lock_guard lock(mutex_);
    says_ = line + "\n";
  }
  std::string said() {
    const std::lock_guard lock(mutex_);
    return last_;
  }
  int lines() {
    const std::lock_guard lock(mutex_);
    return lines_;
  }
  std::unique_ptr<ForceArm> open() {
    auto opened = openArm(name_, {.limits = {.force = 3, .rate = 500, .ramp_s = 0.1}});
    EXPECT_TRUE(opened) << opened.error().message();
    return opened ? std::move(opened->arm) : nullptr;
  }
  // How often this process has the node open.
  static int openFilesOf(const std::string& node) {
    int out = 0;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
      std::error_code failed;
      out += std::filesystem::read_symlink(entry.path(), failed).string().starts_with(node);
    }
    return out;
  }
  // That it is sent for a force, where its encoders stand at `counts`, counted from its home pose.
  static std::string lineFor(const std::array<int, 6>& counts, const Vec3d& force) {
    HandFrame hand;
    Eigen::Matrix3d jacobian;
    takeSerialLine({.model = kSerialWoody, .counts = counts}, hand, jacobian);
    std::array<char, 64> text{};
    std::string out(text.data(), writeSerialLine(woodyCurrents(serialWoody(), jacobian, force), text));
    out.pop_back();
    return out;
  }

  int far_ = -1;
  std::string name_;
  std::thread firmware_;
  std::atomic<bool> is_off_{false}, is_silent_{false}, hangs_{false};
  std::mutex mutex_;
  std::string says_ = "[3,40,-3000,5000,0,0,0,0]\n", last_;  // guarded by mutex_, as the next
  int lines_ = 0;
};

TEST_F(SerialPort, GivesForceOnceItStoodInItsHomePoseAndAnswersEachLine) {
  {
    const auto arm = open();
    ASSERT_TRUE(arm);
    arm->enable(true);
    const Vec3d force(0.2, 0.1, 1);
    Pusher pusher(*arm, force);
    ASSERT_TRUE(until([&] { return pusher.is_valid && lines() > 100; }));
    EXPECT_TRUE(arm->needsCalibration());
    EXPECT_EQ(said(), "[0,0,0]") << "where it stands is not known";

    // Wherever its encoders began to count: there it is at home.
    ASSERT_TRUE(calibrated(*arm));
    const std::string at_home = lineFor({}, force);
    EXPECT_TRUE(until([&] { return said() == at_home; })) << said() << " for " << at_home;
    HandFrame hand;
    ASSERT_TRUE(arm->lastHand(hand));
    EXPECT_LT((hand.pose.translation - Vec3d(25, 0, 205)).norm(), 1e-9) << hand.pose.translation.transpose();

    say("[3,40,-2960,5030,0,0,0,0]");
    const std::string moved = lineFor({0, 40, 30, 0, 0, 0}, force);
    ASSERT_NE(moved, at_home);
    EXPECT_TRUE(until([&] { return said() == moved; })) << said() << " for " << moved;

    is_silent_ = true;
    EXPECT_LE(pusher.lastTakenAgeMs(), 1000 * ForceArm::kDeadMan);
    EXPECT_TRUE(until([&] { return said() == "[0,0,0]"; }));
    is_silent_ = false;
    EXPECT_TRUE(until([&] { return pusher.is_valid && said() == moved; })) << "it is asked again";
  }
  EXPECT_TRUE(until([&] { return said() == "[0,0,0]"; })) << "no current at the end";
}

// It takes nothing any more, and the system's buffer is full: the zero of the end does not fit.
TEST_F(SerialPort, ItsGuardBringsTheZeroThatDidNotFitAtTheEnd) {
  auto arm = open();
  ASSERT_TRUE(arm && calibrated(*arm));
  arm->enable(true);
  const std::string node = name_.substr(std::string("serial:").size());
  {
    Pusher pusher(*arm, {0, 0, 1});
    ASSERT_TRUE(until([&] { return said() != "[0,0,0]"; }));
    hangs_ = true;
    is_silent_ = true;  // nobody reads its answers any more
    const int more = ::open(node.c_str(), O_WRONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    ASSERT_GE(more, 0);
    constexpr std::string_view kForce = "[9,9,9]\n";
    // The system takes it out of the buffer by a thread of its own: full is what stays full.
    int full = 0;
    EXPECT_TRUE(until([&] {
      const bool is_taken = ::write(more, kForce.data(), kForce.size()) > 0;
      full = is_taken ? 0 : full + 1;
      return full > 100;
    }));
    ::close(more);
  }
  // It goes on once this process has closed the port.
  std::thread wakes([&] {
    EXPECT_TRUE(until([&] { return openFilesOf(node) == 0; }));
    hangs_ = false;
  });
  arm.reset();
  wakes.join();
  int heard = 0, quiet = 0;
  EXPECT_TRUE(until([&] {
    const int before = std::exchange(heard, lines());
    quiet = heard == before && said() == "[0,0,0]" ? quiet + 1 : 0;
    return quiet > 100;
  })) << "the last line: "
      << said();
}

TEST_F(SerialPort, AnErrorThatTheArmTellsOfTakesTheForceAway) {
  const auto arm = open();
  ASSERT_TRUE(arm && calibrated(*arm));
  arm->enable(true);
  Pusher pusher(*arm, {0, 0, 1});
  ASSERT_TRUE(until([&] { return said() != "[0,0,0]"; }));
  say("[3,40,-3000,5000,0,0,0,7]");
  EXPECT_TRUE(until([&] { return said() == "[0,0,0]"; }));
  EXPECT_TRUE(until([&] { return arm->counts().trouble == "it tells of error 7"; })) << arm->counts().trouble;
  EXPECT_FALSE(arm->isGone());
  say("[3,40,-3000,5000,0,0,0,0]");
  EXPECT_TRUE(until([&] { return said() != "[0,0,0]"; })) << "fades in again";
}

TEST_F(SerialPort, AModelWhoseArmIsNotKnownLeadsNothing) {
  say("[1,0,0,0,0,0,0,0]");
  const auto arm = open();
  ASSERT_TRUE(arm);
  EXPECT_TRUE(until([&] { return arm->counts().trouble.find("model 1") != std::string::npos; }))
      << arm->counts().trouble;
  HandFrame hand;
  EXPECT_FALSE(arm->lastHand(hand));
  EXPECT_EQ(arm->counts().hands, 0u);
  EXPECT_EQ(said(), "[0,0,0]");
}

TEST_F(SerialPort, AnUnpluggedOneIsKnown) {
  const auto arm = open();
  ASSERT_TRUE(arm && calibrated(*arm));
  arm->enable(true);
  Pusher pusher(*arm, {0, 0, 1});
  ASSERT_TRUE(until([&] { return said() != "[0,0,0]"; }));
  const std::string node = name_.substr(std::string("serial:").size());
  EXPECT_GT(openFilesOf(node), 0);
  unplug();
  ASSERT_TRUE(until([&] { return arm->isGone(); }));
  EXPECT_TRUE(until([&] { return openFilesOf(node) == 0; })) << "else it would come back at another one";
  EXPECT_LE(pusher.lastTakenAgeMs(), 1000 * ForceArm::kDeadMan);
  EXPECT_EQ(arm->counts().trouble, "it was unplugged: plug it in");
}

TEST(SerialArm, WhatDoesNotOpenSaysWhatToDo) {
  const auto none = openArm("serial:/dev/null", {});
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message().find("no serial port"), std::string::npos) << none.error().message();
  const auto missing = openArm("serial:/dev/ttyACM-none", {});
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, Error::Code::kNotFound);
  EXPECT_NE(missing.error().message().find("70-kerf-hid.rules"), std::string::npos) << missing.error().message();
  EXPECT_NE(missing.error().message().find("group dialout"), std::string::npos) << missing.error().message();
}

}  // namespace
}  // namespace kerf::serial_arm_test
