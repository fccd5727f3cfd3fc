// Datagrams of a bridge against those of Kerf, and the limits of the bridge's force.
#include "bridges/kerf_link.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <thread>

#include "sim/device/frame/device_frame.h"

namespace kerf::kerf_link_test {
namespace {

using bridge::Hand;
using bridge::KerfLink;
using bridge::Vec3;

// Kerf's socket alone: it sends the frames of a test, and no goodbye.
class BridgeLink : public testing::Test {
 protected:
  void SetUp() override {
    sockaddr_in here{};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof here;
    ASSERT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&here), length), 0);
    ASSERT_EQ(::getsockname(socket_, reinterpret_cast<sockaddr*>(&here), &length), 0);
    ASSERT_TRUE(link_.open(ntohs(here.sin_port)));
  }
  void TearDown() override { ::close(socket_); }
  HandFrame hear(const Hand& hand) {
    link_.say(hand);
    std::array<std::uint8_t, 512> bytes{};
    socklen_t length = sizeof bridge_;
    const ssize_t size =
        ::recvfrom(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&bridge_), &length);
    HandFrame out;
    EXPECT_EQ(decode(std::span(bytes).first(static_cast<std::size_t>(size)), out), FrameFault::kNone);
    return out;
  }
  void answer(const ForceFrame& frame, std::size_t size = kForceFrameSize) {
    const auto bytes = encode(frame);
    EXPECT_GT(::sendto(socket_, bytes.data(), size, 0, reinterpret_cast<const sockaddr*>(&bridge_), sizeof bridge_), 0);
  }
  // An enabled 1 N upwards, for the hand of the current frame.
  ForceFrame pushed() {
    ForceFrame out;
    out.number = ++number_;
    out.hand_time_ns = hear({}).time_ns;
    out.force = {0, 0, 1};
    out.is_enabled = true;
    return out;
  }
  int socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in bridge_{};
  KerfLink link_;
  std::uint64_t number_ = 0;
};

constexpr Vec3 kNone{}, kUp{0, 0, 1};

TEST_F(BridgeLink, KerfReadsItsHand) {
  const HandFrame hand = hear({.position = {0.01, -0.02, 0.003},
                               .orientation = {0, 0, 1, 0},
                               .buttons = 3,
                               .is_ready = false,
                               .senses_orientation = true,
                               .most_force = 5,
                               .most_stiffness = 800});
  EXPECT_EQ(hand.number, 1u);
  EXPECT_LT((hand.pose.translation - Vec3d(10, -20, 3)).norm(), 1e-9);
  EXPECT_EQ(hand.pose.rotation.z(), 1);
  EXPECT_EQ(hand.buttons, 3u);
  EXPECT_FALSE(hand.is_ready);
  EXPECT_TRUE(hand.senses_orientation);
  EXPECT_DOUBLE_EQ(hand.most_force, 5);
  EXPECT_NEAR(hand.most_stiffness, 0.8, 1e-6);
}

// A busy machine may stop this program for longer than a force lasts: one success of many is enough.
TEST_F(BridgeLink, AForceCountsUntilItsDeadline) {
  EXPECT_EQ(link_.force(), kNone);
  bool was_felt = false;
  for (int n = 0; n < 50 && !was_felt; ++n) {
    answer(pushed());
    was_felt = link_.force() == kUp;
  }
  EXPECT_TRUE(was_felt);
  std::this_thread::sleep_for(std::chrono::milliseconds(21));
  EXPECT_EQ(link_.force(), kNone) << "no word of Kerf for 20 ms";
}

TEST_F(BridgeLink, WhatIsOldNotEnabledOrMalformedGivesNoForce) {
  ForceFrame waited = pushed();
  answer(waited);
  std::this_thread::sleep_for(std::chrono::milliseconds(21));
  EXPECT_EQ(link_.force(), kNone) << "it waited in the socket";

  ForceFrame disabled = pushed();
  disabled.is_enabled = false;
  answer(disabled);
  EXPECT_EQ(link_.force(), kNone);
  ForceFrame nan = pushed();
  nan.force[0] = std::nan("");
  answer(nan);
  answer(pushed(), kForceFrameSize - 1);
  EXPECT_EQ(link_.force(), kNone);
  ForceFrame older = pushed(), newest = pushed();
  newest.is_enabled = false;
  answer(newest);
  answer(older);
  EXPECT_EQ(link_.force(), kNone) << "a newer one took the force away";
}

TEST_F(BridgeLink, AKerfThatCountsFromOneAgainIsFeltAtOnce) {
  bool was_felt = false;
  for (int n = 0; n < 50 && !was_felt; ++n) {
    number_ = 1'000'000;
    answer(pushed());
    (void)link_.force();
    number_ = 0;
    answer(pushed());
    was_felt = link_.force() == kUp;
    ForceFrame taken = pushed();
    taken.is_enabled = false;
    taken.number = 1;
    answer(taken);
    EXPECT_EQ(link_.force(), kNone);
  }
  EXPECT_TRUE(was_felt);
}

}  // namespace
}  // namespace kerf::kerf_link_test
