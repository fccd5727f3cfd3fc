#include "ui/app/session/loop_rate.h"

#include <gtest/gtest.h>

#include <chrono>

namespace kerf::loop_rate_test {
namespace {

using std::chrono::milliseconds;

class LoopRateTest : public testing::Test {
 protected:
  // Window frames and loop ticks at given intervals.
  void frames(int count, milliseconds apart, double hz) {
    for (int n = 0; n < count; ++n) {
      now_ += apart;
      ticks_ += 1e-3 * hz * static_cast<double>(apart.count());
      rate_.add(static_cast<std::uint64_t>(ticks_), now_);
    }
  }
  LoopRate rate_;
  LoopRate::Clock::time_point now_;
  double ticks_ = 5000;
};

TEST_F(LoopRateTest, IsTheMeanOfTheLastSecond) {
  frames(30, milliseconds(16), 1000);
  EXPECT_FALSE(rate_.hz()) << "not a second yet";
  frames(200, milliseconds(16), 1000);
  ASSERT_TRUE(rate_.hz());
  EXPECT_NEAR(*rate_.hz(), 1000, 1.5);
  frames(35, milliseconds(16), 900);
  EXPECT_NEAR(*rate_.hz(), 945, 8) << "half of the second is slower";
  frames(100, milliseconds(16), 900);
  EXPECT_NEAR(*rate_.hz(), 900, 1.5);
}

TEST_F(LoopRateTest, ALoopThatHangsIsSeen) {
  frames(200, milliseconds(16), 1000);
  frames(100, milliseconds(16), 0);
  ASSERT_TRUE(rate_.hz());
  EXPECT_EQ(*rate_.hz(), 0);
}

TEST_F(LoopRateTest, AFrameThatTakesLongCountsWhole) {
  frames(200, milliseconds(16), 1000);
  frames(1, milliseconds(4000), 500);
  ASSERT_TRUE(rate_.hz());
  EXPECT_NEAR(*rate_.hz(), 500, 5);
}

TEST_F(LoopRateTest, AtManyFramesASecondItIsTheSame) {
  frames(5000, milliseconds(1), 1000);
  EXPECT_NEAR(*rate_.hz(), 1000, 1.5);
}

TEST_F(LoopRateTest, AnotherLoopBeginsAnew) {
  frames(200, milliseconds(16), 1000);
  ticks_ = 0;
  frames(10, milliseconds(16), 1000);
  EXPECT_FALSE(rate_.hz());
}

}  // namespace
}  // namespace kerf::loop_rate_test
