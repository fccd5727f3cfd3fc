#include "ui/app/pad_rumble.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <thread>

namespace kerf::pad_rumble_test {
namespace {

TEST(PadRumble, TheIdsOfAPadAreInItsGuid) {
  EXPECT_EQ(padIdOf("030000004c050000e60c000011810000"), (PadId{0x054c, 0x0ce6}));
  EXPECT_EQ(padIdOf("050000005e040000130b000009050000"), (PadId{0x045e, 0x0b13}));
  for (const char* none : {"", "xinput01000000000000000000000000", "78696e70757401000000000000000000x",
                           "03000000000000000000000000000000", "03000000zz050000e60c000011810000"})
    EXPECT_FALSE(padIdOf(none)) << none;
}

TEST(PadRumble, ContactIsHeavyTheDriveIsFineAndALatchIsRest) {
  HapticReport report;
  EXPECT_EQ(rumbleOf(report, 0), Rumble{}) << "nothing turns";
  const Rumble air = rumbleOf(report, 1);
  EXPECT_EQ(air.strong, 0);
  EXPECT_GT(air.weak, 0.1);
  report.output.normal_load = 1.5;
  const Rumble cuts = rumbleOf(report, -1);
  EXPECT_GT(cuts.strong, 0.4) << "backwards, too";
  EXPECT_GT(cuts.weak, air.weak);
  report.output.normal_load = 100;
  EXPECT_LE(rumbleOf(report, 1).strong, 1);
  report.is_latched = true;
  EXPECT_EQ(rumbleOf(report, 1), Rumble{});
}

// ---- Opening

constexpr PadId kPad{0x054c, 0x0ce6}, kOther{0x045e, 0x0b13};
using NoPad = Expected<std::unique_ptr<RumblePad>>;

template <class Condition>
bool until(const Condition& holds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < end) {
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return holds();
}

TEST(PadRumble, TheWindowDoesNotWaitForAPadThatOpens) {
  std::promise<void> opens;
  std::atomic<int> tries{0};
  PadRumble rumble([&, is_open = opens.get_future().share()](const PadId&) -> NoPad {
    ++tries;
    is_open.wait();
    return fail({.code = Error::Code::kUnreadable, .found = "no permission"});
  });
  for (int n = 0; n < 20; ++n) EXPECT_EQ(rumble.update(kPad, {}), std::nullopt);
  EXPECT_EQ(tries, 0) << "nothing is to be felt";
  for (int n = 0; n < 20; ++n) EXPECT_EQ(rumble.update(kPad, {1, 1}), std::nullopt);
  opens.set_value();

  std::optional<std::string> told;
  ASSERT_TRUE(until([&] { return (told = rumble.update(kPad, {1, 1})).has_value(); }));
  EXPECT_NE(told->find("does not shake: "), std::string::npos) << *told;
  EXPECT_NE(told->find("no permission"), std::string::npos) << *told;
  for (int n = 0; n < 20; ++n) EXPECT_EQ(rumble.update(kPad, {1, 1}), std::nullopt) << "once";
  EXPECT_EQ(tries, 1);
  EXPECT_NE(rumble.trouble().find("no permission"), std::string::npos) << "for the panel";
  EXPECT_EQ(rumble.update({}, {}), std::nullopt);
  EXPECT_EQ(rumble.trouble(), "") << "none is in use";
}

TEST(PadRumble, WhatKeepsAPadFromShakingIsToldButNotThatItCannot) {
  using Code = Error::Code;
  for (const Code code : {Code::kNotFound, Code::kBadValue, Code::kUnreadable}) {
    PadRumble rumble([&](const PadId&) -> NoPad { return fail({.code = code, .found = "no guard"}); });
    EXPECT_TRUE(until([&] { return rumble.update(kPad, {1, 1}).has_value(); }));
  }
  std::atomic<int> tries{0};
  PadRumble rumble([&](const PadId& pad) -> NoPad {
    ++tries;
    return fail({.code = pad == kPad ? Code::kUnsupported : Code::kNotFound, .found = "no motors"});
  });
  ASSERT_TRUE(until([&] {
    EXPECT_EQ(rumble.update(kPad, {1, 1}), std::nullopt);
    return tries == 1;
  }));
  for (int n = 0; n < 50; ++n) {
    EXPECT_EQ(rumble.update(kPad, {1, 1}), std::nullopt);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(tries, 1);
  EXPECT_TRUE(until([&] { return rumble.update(kOther, {1, 1}).has_value(); })) << "another one is tried";
}

TEST(PadRumble, APadThatIsNotInUseAnyMoreWhenItOpensIsLetGo) {
  std::promise<void> opens;
  PadRumble rumble([is_open = opens.get_future().share()](const PadId& pad) -> NoPad {
    if (pad == kPad) is_open.wait();
    return fail({.code = Error::Code::kUnreadable, .found = pad == kPad ? "first" : "second"});
  });
  EXPECT_EQ(rumble.update(kPad, {1, 1}), std::nullopt);
  EXPECT_EQ(rumble.update(kOther, {1, 1}), std::nullopt);
  opens.set_value();
  std::optional<std::string> told;
  ASSERT_TRUE(until([&] { return (told = rumble.update(kOther, {1, 1})).has_value(); }));
  EXPECT_NE(told->find("second"), std::string::npos) << *told;
}

}  // namespace
}  // namespace kerf::pad_rumble_test
