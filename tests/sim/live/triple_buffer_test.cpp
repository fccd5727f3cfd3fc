#include "sim/hand/triple_buffer.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>

namespace kerf::triple_buffer_test {
namespace {

TEST(TripleBuffer, GivesTheNewestAndNothingTwice) {
  TripleBuffer<int> buffer;
  EXPECT_FALSE(buffer.update());
  EXPECT_EQ(buffer.front(), 0);
  for (int n = 1; n <= 5; ++n) {
    buffer.back() = n;
    buffer.publish();
  }
  ASSERT_TRUE(buffer.update());
  EXPECT_EQ(buffer.front(), 5);
  EXPECT_FALSE(buffer.update());
  EXPECT_EQ(buffer.front(), 5);
}

TEST(TripleBuffer, WhatIsBeingWrittenIsNeverWhatIsBeingRead) {
  TripleBuffer<int> buffer;
  for (int n = 1; n < 100; ++n) {
    buffer.back() = n;
    EXPECT_NE(&buffer.back(), &buffer.front());
    if (n % 3 != 0) buffer.publish();
    EXPECT_NE(&buffer.back(), &buffer.front());
    if (n % 5 != 0) buffer.update();
    EXPECT_NE(&buffer.back(), &buffer.front());
  }
}

TEST(TripleBuffer, BetweenTwoThreadsValuesAreWholeAndGrow) {
  struct Wide {
    std::array<std::uint64_t, 64> words{};
  };
  TripleBuffer<Wide> buffer;
  constexpr std::uint64_t kLast = 200'000;
  std::thread writer([&] {
    for (std::uint64_t n = 1; n <= kLast; ++n) {
      buffer.back().words.fill(n);
      buffer.publish();
    }
  });
  std::uint64_t last = 0, reads = 0;
  while (last < kLast) {
    if (!buffer.update()) {
      std::this_thread::yield();
      continue;
    }
    const std::uint64_t now = buffer.front().words[0];
    ASSERT_GT(now, last);
    for (const std::uint64_t word : buffer.front().words) ASSERT_EQ(word, now);
    last = now;
    ++reads;
  }
  writer.join();
  EXPECT_GT(reads, 0u);
  EXPECT_FALSE(buffer.update());
}

}  // namespace
}  // namespace kerf::triple_buffer_test
