// Haply's bridge: the JSON of the service, and a force from Kerf to a simulated service.
#include <gtest/gtest.h>

#include <cmath>

#include "bridges/haply_state.h"
#include "tests/bridges/bridge_scene.h"
#include "tests/bridges/haply_simulator.h"
#include "tests/support/places.h"

namespace kerf::test {
namespace {

using bridge::haplyForce;
using bridge::HaplyNews;
using bridge::HaplyState;
using bridge::parseHaplyState;

TEST(HaplyJson, PartialStatesKeepWhatTheyDoNotSay) {
  HaplyState state;
  EXPECT_EQ(
      parseHaplyState(
          R"({"session_id":1,"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":0.01,"y":-0.02,"z":0.1}}}],
      "wireless_verse_grip":[{"state":{"orientation":{"x":0,"y":0,"z":0,"w":1},"buttons":{"a":true,"b":false,"c":true}}}]})",
          state),
      HaplyNews::kPlace);
  const bridge::Vec3 place = {0.01, -0.02, 0.1};
  EXPECT_EQ(state.id, "049D");
  EXPECT_EQ(state.hand.position, place);
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
  EXPECT_EQ(state.hand.position, place) << "nothing of them is used";
  EXPECT_EQ(parseHaplyState(std::string(100000, '['), state), HaplyNews::kMalformed);

  EXPECT_EQ(
      haplyForce("049D", {0.5, 0, -1}),
      R"({"inverse3":[{"commands":{"set_cursor_force":{"values":{"x":0.5,"y":0.0,"z":-1.0}}},"device_id":"049D"}]})");
  EXPECT_EQ(haplyForce("a", {std::nan(""), 1, 1}).find("1.0"), std::string::npos) << "no numbers: no force";
}

class HaplyBridge : public testing::Test {
 protected:
  void SetUp() override {
    auto started = HaplySimulator::start({.port = 0});
    ASSERT_TRUE(started) << started.error().message();
    service_ = std::move(*started);
    kerf_ = openKerf();
    bridge_ = std::make_unique<Program>(std::vector<std::string>{std::string(kProgramFolder) + "/kerf-bridge-haply",
                                                                 std::to_string(kerf_->port()),
                                                                 std::to_string(service_->port())});
    pusher_ = std::make_unique<Pusher>(*kerf_, Vec3d(0, 0, 1));
    ASSERT_TRUE(until([&] { return service_->report().force[2] > 0.99; })) << kerf_->counts().trouble;
  }
  bool endsForce() {
    return until([&] { return service_->report().force.isZero(0); });
  }
  std::unique_ptr<HaplySimulator> service_;
  std::unique_ptr<BridgeDevice> kerf_;
  std::unique_ptr<Program> bridge_;
  std::unique_ptr<Pusher> pusher_;
};

TEST_F(HaplyBridge, LeadsAndGivesForceAndNoneWithoutNewsOfEitherSide) {
  HandFrame hand;
  ASSERT_TRUE(kerf_->lastHand(hand));
  EXPECT_GT(hand.pose.translation[2], 0.5) << "pushed up against its spring";

  // The service hangs: the bridge reports no hand to Kerf.
  service_->hang(true);
  EXPECT_TRUE(until([&] { return !pusher_->is_valid; }));
  service_->hang(false);
  ASSERT_TRUE(until([&] { return service_->report().force[2] > 0.5; })) << "it is asked again";

  // The 1 kHz thread stalls.
  pusher_->hangs = true;
  EXPECT_TRUE(endsForce());
  pusher_->hangs = false;
  ASSERT_TRUE(until([&] { return service_->report().force[2] > 0.5; }));
}

TEST_F(HaplyBridge, AnEndedBridgeSendsZero) {
  EXPECT_EQ(bridge_->end(), 0);
  EXPECT_TRUE(endsForce());
}

TEST_F(HaplyBridge, OutlivesItsServiceAndKerf) {
  pusher_.reset();
  const std::uint16_t port = service_->port();
  service_.reset();
  kerf_.reset();
  auto again = HaplySimulator::start({.port = port});
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(until([&] { return (*again)->report().force_frames > 10; })) << "it calls again";
  EXPECT_EQ((*again)->report().most_force, 0);
}

TEST(HaplyBridgeProgram, AWrongPortIsAWrongCommandLine) {
  for (const char* port : {"0", "70000", "192.168.0.1"})
    EXPECT_EQ(Program({std::string(kProgramFolder) + "/kerf-bridge-haply", port}).wait(), 2) << port;
}

}  // namespace
}  // namespace kerf::test
