// The bridge of WoodenHaptics: its kinematics, and an arm behind a pseudo-terminal.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <numbers>

#include "bridges/serial_writer.h"
#include "bridges/woody_arm.h"
#include "tests/bridges/bridge_scene.h"
#include "tests/support/places.h"

namespace kerf::test {
namespace {

using bridge::Counts;
using bridge::kSerialWoody;
using bridge::Vec3;
using bridge::woodyCurrents;
using bridge::WoodyModel;
using bridge::woodyPose;
using bridge::WoodyPose;

TEST(WoodyArm, TheTorquesOfAForceAreThoseOfItsWorkAlongEachMotor) {
  const WoodyModel model;
  for (const Counts& counts : {Counts{0, 0, 6000}, Counts{500, 3000, 5000}, Counts{-900, 5000, 8000}}) {
    const WoodyPose pose = woodyPose(model, counts);
    const Vec3 force = {0.3, -0.7, 1.1};
    const Vec3 currents = woodyCurrents(pose, force);
    for (std::size_t motor = 0; motor < 3; ++motor) {
      Counts more = counts, less = counts;
      more[motor] += 5;
      less[motor] -= 5;
      const double radians = 10 * 2 * std::numbers::pi / WoodyModel::kCountsPerTurn;
      const Vec3 from = woodyPose(model, less).position, to = woodyPose(model, more).position;
      double work = 0;
      for (std::size_t n = 0; n < 3; ++n) work += force[n] * (to[n] - from[n]) / radians;
      EXPECT_NEAR(currents[motor] * WoodyModel::kNewtonMetrePerAmpere / 1000, work, 1e-6) << motor;
    }
  }
}

// An upright link and a level link: 245 - 220 mm ahead, 80 + 205 - 80 mm up.
TEST(WoodyArm, AtHomeItStandsAsItIsBuiltWhicheverWayItsMotorsCount) {
  for (const WoodyModel& model : {WoodyModel{}, kSerialWoody}) {
    const WoodyPose pose = woodyPose(model, model.home);
    EXPECT_NEAR(pose.position[0], 0.025, 1e-12);
    EXPECT_NEAR(pose.position[1], 0, 1e-12);
    EXPECT_NEAR(pose.position[2], 0.205, 1e-12);
  }
}

TEST(WoodyArm, NoCurrentIsLargerThanTheMotorsBear) {
  const WoodyPose pose = woodyPose({}, {0, 3000, 5000});
  const Vec3 huge = woodyCurrents(pose, {0, 0, 1e4}), little = woodyCurrents(pose, {0, 0, 1});
  EXPECT_NEAR(std::max({std::abs(huge[0]), std::abs(huge[1]), std::abs(huge[2])}), WoodyModel::kMostCurrent, 1e-9);
  EXPECT_NEAR(huge[1] / huge[2], little[1] / little[2], 1e-9) << "its direction is kept";
  EXPECT_EQ(woodyCurrents(pose, {std::nan(""), 0, 1}), Vec3{});
}

// An arm at the far end of a pseudo-terminal: answers each line.
class WoodySerial : public testing::Test {
 protected:
  void SetUp() override {
    far_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    ASSERT_GE(far_, 0);
    ASSERT_EQ(::grantpt(far_), 0);
    ASSERT_EQ(::unlockpt(far_), 0);
    firmware_ = std::thread([this] { answer(); });
    kerf_ = openKerf();
    bridge_ = std::make_unique<Program>(std::vector<std::string>{std::string(kProgramFolder) + "/kerf-bridge-woody",
                                                                 ::ptsname(far_), std::to_string(kerf_->port())});
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
        EXPECT_TRUE(is_silent_ || ::write(far_, says_.data(), says_.size()) > 0);
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
  bool isReady() const {
    HandFrame hand;
    return kerf_->lastHand(hand) && hand.is_ready;
  }
  // The line for a force with encoders at `counts` from the home pose.
  static std::string lineFor(const Counts& counts, const Vec3& force) {
    Counts all = kSerialWoody.home;
    for (std::size_t n = 0; n < 3; ++n) all[n] += counts[n];
    const Vec3 currents = woodyCurrents(woodyPose(kSerialWoody, all), force);
    return fmt::format("[{},{},{}]", std::lround(currents[0]), std::lround(currents[1]), std::lround(currents[2]));
  }

  int far_ = -1;
  std::thread firmware_;
  std::atomic<bool> is_off_{false}, is_silent_{false};
  std::mutex mutex_;
  std::string says_ = "[3,40,-3000,5000,0,0,0,0]\n", last_;  // guarded by mutex_, as the next
  int lines_ = 0;
  std::unique_ptr<BridgeDevice> kerf_;
  std::unique_ptr<Program> bridge_;
};

TEST_F(WoodySerial, GivesForceOnceItStoodInItsHomePose) {
  const Vec3 force = {0.2, 0.1, 1};
  Pusher pusher(*kerf_, {force[0], force[1], force[2]});
  ASSERT_TRUE(until([&] { return lines() > 100 && kerf_->counts().hands > 100; }));
  EXPECT_FALSE(isReady());
  EXPECT_EQ(said(), "[0,0,0]") << "where it stands is not known";

  // The start of the encoder counts is the home pose.
  bridge_->pressEnter();
  const std::string at_home = lineFor({}, force);
  EXPECT_TRUE(until([&] { return said() == at_home; })) << said() << " for " << at_home;
  HandFrame hand;
  ASSERT_TRUE(kerf_->lastHand(hand));
  EXPECT_LT((hand.pose.translation - Vec3d(25, 0, 205)).norm(), 1e-9) << hand.pose.translation.transpose();

  say("[3,40,-2960,5030,0,0,0,0]");
  const std::string moved = lineFor({0, 40, 30}, force);
  ASSERT_NE(moved, at_home);
  EXPECT_TRUE(until([&] { return said() == moved; })) << said() << " for " << moved;

  // First the arm falls silent, then Kerf.
  is_silent_ = true;
  EXPECT_LE(pusher.lastTakenAgeMs(), 1000 * ForceArm::kDeadMan);
  EXPECT_TRUE(until([&] { return said() == "[0,0,0]"; }));
  is_silent_ = false;
  EXPECT_TRUE(until([&] { return pusher.is_valid && said() == moved; })) << "it is asked again";
  pusher.hangs = true;
  EXPECT_TRUE(until([&] { return said() == "[0,0,0]"; }));
  pusher.hangs = false;
  EXPECT_TRUE(until([&] { return said() == moved; }));
  EXPECT_EQ(bridge_->end(), 0);
  EXPECT_TRUE(until([&] { return said() == "[0,0,0]"; })) << "no current at the end";
}

TEST_F(WoodySerial, CalibratingAgainIsNotReadyForLongEnoughToDisarmKerf) {
  const Pusher pusher(*kerf_, {0, 0, 1});
  ASSERT_TRUE(until([&] { return kerf_->counts().hands > 10; }));
  bridge_->pressEnter();
  ASSERT_TRUE(until([&] { return said() == lineFor({}, {0, 0, 1}); })) << said();

  const auto begin = std::chrono::steady_clock::now();
  bridge_->pressEnter();
  EXPECT_TRUE(until([&] { return !isReady() && !pusher.is_valid && said() == "[0,0,0]"; }));
  const std::uint64_t hands = kerf_->counts().hands;
  EXPECT_TRUE(until([&] { return isReady(); }));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(1500));
  EXPECT_GT(kerf_->counts().hands, hands + 50) << "it says so all the time";
  EXPECT_TRUE(until([&] { return said() == lineFor({}, {0, 0, 1}); })) << said();
}

// The frame that waited in the socket of a stopped bridge is old.
TEST_F(WoodySerial, AStoppedBridgeGivesNoOldForceWhenItGoesOn) {
  std::optional<Pusher> pusher(std::in_place, *kerf_, Vec3d(0, 0, 1));
  ASSERT_TRUE(until([&] { return kerf_->counts().hands > 10; }));
  bridge_->pressEnter();
  ASSERT_TRUE(until([&] { return said() == lineFor({}, {0, 0, 1}); })) << said();
  bridge_->signal(SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  pusher.reset();
  const int before = lines();
  bridge_->signal(SIGCONT);
  ASSERT_TRUE(until([&] { return lines() > before + 1; }));
  EXPECT_EQ(said(), "[0,0,0]");
}

TEST_F(WoodySerial, AnErrorOrAnotherModelTakesTheForceAway) {
  const Pusher pusher(*kerf_, {0, 0, 1});
  ASSERT_TRUE(until([&] { return kerf_->counts().hands > 10; }));
  bridge_->pressEnter();
  ASSERT_TRUE(until([&] { return said() != "[0,0,0]"; }));
  for (const char* line : {"[3,40,-3000,5000,0,0,0,7]", "[1,40,-3000,5000,0,0,0,0]"}) {
    say(line);
    EXPECT_TRUE(until([&] { return said() == "[0,0,0]" && !isReady(); })) << line;
    say("[3,40,-3000,5000,0,0,0,0]");
    EXPECT_TRUE(until([&] { return said() != "[0,0,0]"; })) << "fades in again";
  }
  const std::uint64_t hands = kerf_->counts().hands;
  for (const char* bad : {"", "[3,1,2,3,0,0,0]", "[3,1,2,3,0,0,0,0] ", "[3,1, 2,3,0,0,0,0]", "[3,1,2.5,3,0,0,0,0]"}) {
    say(bad);
    const int before = lines();
    EXPECT_TRUE(until([&] { return lines() > before + 10; }));
    const std::uint64_t then = kerf_->counts().hands;
    EXPECT_TRUE(until([&] { return lines() > before + 20; }));
    EXPECT_EQ(kerf_->counts().hands, then) << bad;
  }
  EXPECT_GE(kerf_->counts().hands, hands);
}

TEST_F(WoodySerial, AnUnpluggedArmEndsIt) {
  ASSERT_TRUE(until([&] { return lines() > 10; }));
  unplug();
  EXPECT_EQ(bridge_->wait(), 1);
}

TEST(SerialWriter, ALineThatAFullPortTookInPartIsFinished) {
  const int far = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(far, 0);
  ASSERT_EQ(::grantpt(far), 0);
  ASSERT_EQ(::unlockpt(far), 0);
  const int near = ::open(::ptsname(far), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(near, 0);
  termios line{};
  ASSERT_EQ(::tcgetattr(near, &line), 0);
  ::cfmakeraw(&line);
  ASSERT_EQ(::tcsetattr(near, TCSANOW, &line), 0);

  // Lines of 251 bytes, more than any port buffers; then the buffered bytes, and more lines.
  bridge::SerialWriter writer(near);
  const std::string text = '[' + std::string(248, '1') + "]\n";
  std::string heard;
  for (int round = 0; round < 4; ++round) {
    for (int n = 0; n < 2000; ++n) ASSERT_TRUE(writer.write(text));
    std::array<char, 4096> bytes{};
    const auto hasBytes = [&] {
      pollfd waits{far, POLLIN, 0};
      return ::poll(&waits, 1, 50) > 0;
    };
    while (hasBytes()) {
      const ssize_t size = ::read(far, bytes.data(), bytes.size());
      if (size <= 0) break;
      heard.append(bytes.data(), static_cast<std::size_t>(size));
    }
  }
  ::close(near);
  ::close(far);
  EXPECT_GT(heard.size(), 4 * text.size());
  std::size_t torn = 0;
  for (std::size_t at = 0; at + text.size() <= heard.size(); at += text.size())
    torn += heard.compare(at, text.size(), text) != 0;
  EXPECT_EQ(torn, 0u);
}

TEST(WoodyBridge, ANodeThatIsNoArmIsRefused) {
  EXPECT_EQ(Program({std::string(kProgramFolder) + "/kerf-bridge-woody", "/dev/null"}).wait(), 1);
  EXPECT_EQ(Program({std::string(kProgramFolder) + "/kerf-bridge-woody", "/dev/ttyACM-none"}).wait(), 1);
  EXPECT_EQ(Program({std::string(kProgramFolder) + "/kerf-bridge-woody"}).wait(), 2);
}

}  // namespace
}  // namespace kerf::test
