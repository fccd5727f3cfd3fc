// Haply's service: its JSON, and the way of a force through a simulated one.
#include "sim/device/haply_arm.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "sim/device/haply_simulator.h"
#include "tests/sim/device/force_scene.h"

namespace kerf::haply_arm_test {
namespace {

using namespace test;

TEST(HaplyJson, PartialStatesKeepWhatTheyDoNotSay) {
  HaplyState state;
  EXPECT_EQ(
      parseHaplyState(
          R"({"session_id":1,"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":0.01,"y":-0.02,"z":0.1}}}],
      "wireless_verse_grip":[{"state":{"orientation":{"x":0,"y":0,"z":0,"w":1},"buttons":{"a":true,"b":false,"c":true}}}]})",
          state),
      HaplyNews::kPlace);
  EXPECT_EQ(state.id, "049D");
  EXPECT_LT((state.hand.pose.translation - Vec3d(10, -20, 100)).norm(), 1e-9);
  EXPECT_EQ(state.hand.buttons, 5u);
  EXPECT_TRUE(state.hand.senses_orientation);
  EXPECT_EQ(parseHaplyState(R"({"inverse3":[{"state":{}}]})", state), HaplyNews::kOther);
  EXPECT_EQ(parseHaplyState("{}", state), HaplyNews::kOther);
  EXPECT_EQ(state.id, "049D");
  for (const char* bad : {"", "[]", "null", "{\"inverse3\"", "\xff\xfe",
                          R"({"inverse3":[{"state":{"cursor_position":{"x":1e300,"y":0,"z":0}}}]})",
                          R"({"inverse3":[{"state":{"cursor_position":{"x":"0","y":0,"z":0}}}]})",
                          R"({"inverse3":[{"state":{"cursor_position":{"x":0,"y":0}}}]})"})
    EXPECT_EQ(parseHaplyState(bad, state), HaplyNews::kMalformed) << bad;
  EXPECT_LT((state.hand.pose.translation - Vec3d(10, -20, 100)).norm(), 1e-9) << "nothing of them is used";
  EXPECT_EQ(parseHaplyState(std::string(100000, '['), state), HaplyNews::kMalformed);

  EXPECT_EQ(
      haplyForce("049D", {0.5, 0, -1}),
      R"({"inverse3":[{"commands":{"set_cursor_force":{"values":{"x":0.5,"y":0.0,"z":-1.0}}},"device_id":"049D"}]})");
  EXPECT_EQ(haplyForce("a", {std::nan(""), 1, 1}).find("1.0"), std::string::npos) << "no numbers: no force";
}

// A port of this machine that nobody serves: calls wait in its queue.
class SilentPort {
 public:
  explicit SilentPort(int queue) {
    here_.sin_family = AF_INET;
    here_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof here_;
    EXPECT_EQ(::bind(listening_, reinterpret_cast<const sockaddr*>(&here_), length), 0);
    EXPECT_EQ(::listen(listening_, queue), 0);
    EXPECT_EQ(::getsockname(listening_, reinterpret_cast<sockaddr*>(&here_), &length), 0);
  }
  ~SilentPort() {
    for (const int call : calls_) ::close(call);
    ::close(listening_);
  }
  // Calls it, without waiting for an answer.
  void call() {
    calls_.push_back(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    (void)::connect(calls_.back(), reinterpret_cast<const sockaddr*>(&here_), sizeof here_);
  }
  std::string name() const { return "haply:" + std::to_string(ntohs(here_.sin_port)); }

 private:
  int listening_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  std::vector<int> calls_;
  sockaddr_in here_{};
};

TEST(HaplyArm, APortThatAnswersAndSaysNothingIsNamed) {
  const SilentPort port(4);
  auto opened = openArm(port.name(), {});
  ASSERT_TRUE(opened) << opened.error().message();
  const auto trouble = [&] { return opened->arm->counts().trouble; };
  EXPECT_TRUE(until([&] { return trouble().find("answers but says nothing") != std::string::npos; })) << trouble();
}

TEST(HaplyArm, AServiceWhoseQueueIsFullKeepsNobodyFromTheEnd) {
  SilentPort port(0);
  for (int n = 0; n < 4; ++n) port.call();
  const auto began = std::chrono::steady_clock::now();
  {
    auto opened = openArm(port.name(), {});
    ASSERT_TRUE(opened) << opened.error().message();
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    EXPECT_NE(opened->arm->counts().trouble.find("no service answers"), std::string::npos);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(30)) << "a call would take two minutes";
}

TEST(HaplyArm, ASimulatedServiceClosesTheLoop) {
  auto service = HaplySimulator::start({.port = 0});
  ASSERT_TRUE(service) << service.error().message();
  auto opened =
      openArm("haply:" + std::to_string((*service)->port()), {.limits = {.force = 3, .rate = 500, .ramp_s = 0.1}});
  ASSERT_TRUE(opened) << opened.error().message();
  ForceArm& arm = *opened->arm;
  arm.enable(true);
  {
    Pusher pusher(arm, {0, 0, 1});
    ASSERT_TRUE(until([&] { return pusher.is_valid.load(); })) << arm.counts().trouble;
    ASSERT_TRUE(until([&] { return (*service)->report().force[2] > 0.99; }));
    EXPECT_LE((*service)->report().most_force, 3 + 1e-9);
    HandFrame hand;
    ASSERT_TRUE(arm.lastHand(hand));
    EXPECT_GT(hand.pose.translation[2], 0.5) << "pushed up against its spring";

    // The service hangs, then dies.
    (*service)->hang(true);
    EXPECT_LE(pusher.lastTakenAgeMs(), 1000 * ForceArm::kDeadMan);

    // It is told that there is no force, again and again, and a person what to do.
    EXPECT_TRUE(until([&] { return !arm.counts().is_enabled; }));
    const std::uint64_t sent = arm.counts().forces;
    EXPECT_TRUE(until([&] { return arm.counts().forces >= sent + 2; })) << "who says nothing is not waited for";
    EXPECT_NE(arm.counts().trouble.find("has said nothing for"), std::string::npos) << arm.counts().trouble;
    (*service)->hang(false);
    ASSERT_TRUE(until([&] { return pusher.is_valid.load(); }));
    service->reset();
    EXPECT_LE(pusher.lastTakenAgeMs(), 1000 * ForceArm::kDeadMan);
    EXPECT_TRUE(until([&] { return arm.counts().trouble.find("no service answers") != std::string::npos; }))
        << arm.counts().trouble;
  }
  EXPECT_FALSE(openArm("haply:192.168.0.1", {}));
  EXPECT_FALSE(openArm("haply:70000", {}));
}

}  // namespace
}  // namespace kerf::haply_arm_test
