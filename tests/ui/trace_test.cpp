#include "ui/app/session/trace.h"

#include <gtest/gtest.h>

namespace kerf::trace_test {
namespace {

using Channel = Trace::Channel;

TEST(Trace, KeepsTheLastTwentySecondsAtSixtyASecond) {
  Trace trace;
  // 30 s of reports at 100 a second; the force is the time.
  for (std::uint64_t tick = 0; tick <= 30000; tick += 10)
    trace.add({.tick = tick, .force = 1e-3 * static_cast<double>(tick)});
  const auto& force = trace.values(Channel::kForce);
  const float oldest = force[trace.oldest()], newest = trace.newest(Channel::kForce);
  EXPECT_NEAR(newest, 30, 0.02);
  EXPECT_NEAR(oldest, 10, 0.04);
  EXPECT_EQ(trace.largest(Channel::kForce), newest);
  for (std::size_t n = 1; n < Trace::kCount; ++n) {
    const float step = force[(trace.oldest() + n) % Trace::kCount] - force[(trace.oldest() + n - 1) % Trace::kCount];
    EXPECT_NEAR(step, 1.0 / 60, 0.011) << n;
  }
}

TEST(Trace, KnowsLoadPenetrationAndTemperature) {
  Trace trace;
  trace.add({.tick = 0});
  trace.add({.tick = 100, .load = 40, .penetration = 12, .temperature = 61});
  EXPECT_EQ(trace.newest(Channel::kLoad), 40);
  EXPECT_EQ(trace.newest(Channel::kPenetration), 12);
  EXPECT_EQ(trace.newest(Channel::kTemperature), 61);
  for (const Trace::About& about : Trace::kChannels) EXPECT_GE(trace.scaleTop(about), about.least_top) << about.name;
}

TEST(Trace, SlowReportsFillTheTimeBetweenThem) {
  Trace trace;
  trace.add({.tick = 0});
  trace.add({.tick = 500, .force = 3});
  int threes = 0;
  for (const float f : trace.values(Channel::kForce)) threes += f == 3;
  EXPECT_EQ(threes, 30);
  // A gap longer than the trace fills the trace once.
  trace.add({.tick = 10'000'000, .force = 4});
  for (const float f : trace.values(Channel::kForce)) EXPECT_EQ(f, 4);
}

TEST(Trace, TheRateIsWhatWasCutInATime) {
  Trace trace;
  trace.add({.tick = 1000, .removed_mm3 = 2});
  trace.add({.tick = 1100, .removed_mm3 = 2.05});
  EXPECT_NEAR(trace.newest(Channel::kRate), 0.5, 1e-6);
  // Volume changed by undo or redo is not a cut at that time.
  trace.add({.tick = 1200, .removed_mm3 = 0.1, .jumps = 1});
  EXPECT_EQ(trace.newest(Channel::kRate), 0);
  trace.add({.tick = 1300, .removed_mm3 = 2.05, .jumps = 2});
  EXPECT_EQ(trace.newest(Channel::kRate), 0);
  trace.add({.tick = 1400, .removed_mm3 = 2.15, .jumps = 2});
  EXPECT_NEAR(trace.newest(Channel::kRate), 1, 1e-6);
}

TEST(Trace, AScaleEndsAtARoundNumberAboveAllValues) {
  Trace trace;
  const Trace::About& force = Trace::kChannels[0];
  EXPECT_EQ(trace.scaleTop(force), force.least_top);
  trace.add({.tick = 0});
  trace.add({.tick = 100, .force = 1.3});
  EXPECT_NEAR(trace.scaleTop(force), 2, 1e-12);
  trace.add({.tick = 200, .force = 5});
  EXPECT_NEAR(trace.scaleTop(force), 5, 1e-12);
  trace.add({.tick = 300, .force = 70});
  EXPECT_NEAR(trace.scaleTop(force), 100, 1e-12);
}

TEST(Trace, AnotherSessionBeginsAnew) {
  Trace trace;
  trace.add({.tick = 0});
  trace.add({.tick = 5000, .force = 2});
  trace.add({.tick = 10, .force = 1});
  EXPECT_EQ(trace.largest(Channel::kForce), 0);
}

}  // namespace
}  // namespace kerf::trace_test
