// The window's pad on a simulated one: what it is told through a cut, a pause, a latch, another pad, and the end.
// Skipped where umockdev is not preloaded.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "tests/support/hid_testbed.h"
#include "tests/support/zero_guard_process.h"
#include "ui/app/pad_rumble.h"

namespace kerf::pad_rumble_wire_test {
namespace {

template <class Condition>
bool until(const Condition& holds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < end) {
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return holds();
}

class PadWhileItDrills : public testing::Test {
 protected:
  void SetUp() override {
    if (!HidTestbed::isThere()) GTEST_SKIP() << "umockdev is not preloaded: run umockdev-wrapper kerf_led_tests";
    bed_ = std::make_unique<HidTestbed>();
    bed_->plugIn({.vendor = 0x054c, .product = 0x0ce6, .name = "Pad", .interfaces = {{1, 5}}});
    cuts_.output.normal_load = 3;
  }
  // As the window does, once a frame.   @return  it was told so.
  bool isTold(const std::optional<PadId>& pad, const Rumble& wanted, const Bytes& expected) {
    return until([&] {
      EXPECT_EQ(rumble_->update(pad, wanted), std::nullopt);
      return bed_->lastWritten(0) == expected;
    });
  }
  static Bytes report(std::uint8_t weak, std::uint8_t strong) {
    Bytes out(48);
    out[0] = 0x02;
    out[1] = 0x03;
    out[3] = weak;
    out[4] = strong;
    return out;
  }
  const Bytes rest_ = report(0, 0), shakes_ = report(191, 255);  // a quarter and half of the contact
  const PadId pad_{0x054c, 0x0ce6};
  HapticReport cuts_;
  std::unique_ptr<HidTestbed> bed_;
  std::unique_ptr<PadRumble> rumble_ = std::make_unique<PadRumble>();
};

TEST_F(PadWhileItDrills, IsLeftAloneUntilThereIsSomethingToFeel) {
  for (int n = 0; n < 20; ++n) EXPECT_EQ(rumble_->update(pad_, {}), std::nullopt);
  EXPECT_EQ(rumble_->update({}, {1, 1}), std::nullopt) << "none is in use";
  EXPECT_TRUE(bed_->written(0).empty());
}

TEST_F(PadWhileItDrills, StandsStillInAPauseAndGoesOn) {
  ASSERT_TRUE(isTold(pad_, rumbleOf(cuts_, 1), shakes_));
  EXPECT_TRUE(isTold(pad_, {}, rest_)) << "paused, or out of focus";
  EXPECT_TRUE(isTold(pad_, rumbleOf(cuts_, 1), shakes_));
}

TEST_F(PadWhileItDrills, StandsStillWhenTheSessionIsLatched) {
  ASSERT_TRUE(isTold(pad_, rumbleOf(cuts_, 1), shakes_));
  cuts_.is_latched = true;
  EXPECT_TRUE(isTold(pad_, rumbleOf(cuts_, 1), rest_));
}

TEST_F(PadWhileItDrills, StandsStillWhenItIsNotInUseAnyMore) {
  ASSERT_TRUE(isTold(pad_, rumbleOf(cuts_, 1), shakes_));
  EXPECT_TRUE(isTold(PadId{0x045e, 0x0b13}, rumbleOf(cuts_, 1), rest_)) << "another one";
  ASSERT_TRUE(isTold(pad_, rumbleOf(cuts_, 1), shakes_));
  EXPECT_TRUE(isTold({}, rumbleOf(cuts_, 1), rest_)) << "none";
}

TEST_F(PadWhileItDrills, StandsStillWhenTheWindowHangsAndAtTheEnd) {
  ASSERT_TRUE(isTold(pad_, rumbleOf(cuts_, 1), shakes_));
  EXPECT_TRUE(until([&] { return bed_->lastWritten(0) == rest_; })) << "nobody tells it any more";
  ASSERT_TRUE(isTold(pad_, rumbleOf(cuts_, 1), shakes_));
  rumble_.reset();
  EXPECT_EQ(bed_->lastWritten(0), rest_);
}

TEST_F(PadWhileItDrills, StandsStillWithoutItsGuardAndThatIsToldOnce) {
  ASSERT_TRUE(isTold(pad_, rumbleOf(cuts_, 1), shakes_));
  ::kill(test::guardOf(::getpid()), SIGKILL);
  std::optional<std::string> told;
  ASSERT_TRUE(until([&] { return (told = rumble_->update(pad_, rumbleOf(cuts_, 1))).has_value(); }));
  EXPECT_NE(told->find("guards it is gone"), std::string::npos) << *told;
  EXPECT_EQ(rumble_->trouble().find("the process that guards it is gone"), 0u) << "for the panel";
  EXPECT_TRUE(isTold(pad_, rumbleOf(cuts_, 1), rest_));
}

TEST_F(PadWhileItDrills, ThatTakesNoReportForAWhileIsOpenedAgain) {
  ASSERT_TRUE(isTold(pad_, rumbleOf(cuts_, 1), shakes_));
  bed_->refuseWriters(0);
  EXPECT_TRUE(isTold(pad_, {}, rest_)) << "by its guard";
  EXPECT_TRUE(isTold(pad_, rumbleOf(cuts_, 1), shakes_)) << "who opens it now is heard";
}

TEST_F(PadWhileItDrills, ThatIsPluggedOutIsForgotten) {
  ASSERT_TRUE(isTold(pad_, rumbleOf(cuts_, 1), shakes_));
  bed_->unplug({.vendor = 0x054c, .product = 0x0ce6, .name = "Pad", .interfaces = {{1, 5}}});
  for (int n = 0; n < 50; ++n) {
    EXPECT_EQ(rumble_->update(pad_, {1, 1}), std::nullopt);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_EQ(rumble_->update({}, {}), std::nullopt);
}

}  // namespace
}  // namespace kerf::pad_rumble_wire_test
