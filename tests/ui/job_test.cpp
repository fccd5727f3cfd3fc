#include "ui/app/base/job.h"

#include <gtest/gtest.h>

#include <chrono>
#include <new>
#include <thread>

namespace kerf::job_test {
namespace {

// Waits for a condition.   @return  false: not within a minute.
template <class Truth>
bool comesTrue(const Truth& is_true) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!is_true() && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  return is_true();
}

// Reports a progress and waits for its end.
Job<int> heldAt(double done, const std::atomic<bool>& may_end) {
  return Job<int>("held", [done, &may_end](const Progress& progress) -> Expected<int> {
    while (!may_end)
      if (!progress(done, "halfway")) return cancelled();
    return 7;
  });
}

TEST(Job, TheTimeLeftIsThatOfItsPaceAndNotGuessedTooEarly) {
  std::atomic<bool> may_end{false};
  Job<int> job = heldAt(0.25, may_end);
  ASSERT_TRUE(comesTrue([&] { return job.status().done > 0; }));
  const JobStatus early = job.status();
  EXPECT_EQ(early.step, "halfway");
  EXPECT_TRUE(!early.left_s || early.seconds > 1) << early.seconds;

  ASSERT_TRUE(comesTrue([&] { return job.status().seconds > 1; }));
  const JobStatus now = job.status();
  ASSERT_TRUE(now.left_s);
  EXPECT_NEAR(*now.left_s, 3 * now.seconds, 1e-9) << "a quarter is done";
  may_end = true;
  EXPECT_EQ(*job.take(), 7);
  EXPECT_TRUE(job.isOver());

  // A job that has just begun gives no estimate.
  std::atomic<bool> other_may_end{false};
  Job<int> begun = heldAt(0.01, other_may_end);
  ASSERT_TRUE(comesTrue([&] { return begun.status().seconds > 1; }));
  EXPECT_FALSE(begun.status().left_s);
}

TEST(Job, CancelledItEndsAtItsNextReport) {
  std::atomic<bool> never{false};
  Job<int> job = heldAt(0.5, never);
  EXPECT_FALSE(job.status().is_cancelling);
  job.cancel();
  EXPECT_TRUE(job.status().is_cancelling);
  const auto result = job.take();
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Error::Code::kCancelled);
}

TEST(Job, WithoutMemoryItIsAnErrorThatSaysWhatHelps) {
  Job<int> job("preparing a scan", [](const Progress&) -> Expected<int> { throw std::bad_alloc(); });
  const auto result = job.take();
  ASSERT_FALSE(result);
  const std::string text = result.error().message();
  for (const char* const words : {"preparing a scan", "not enough memory", "larger voxels"})
    EXPECT_NE(text.find(words), std::string::npos) << text;
}

TEST(Job, WhatALibraryThrowsIsAnErrorToo) {
  Job<void> job("reading", [](const Progress&) -> Expected<void> { throw std::runtime_error("no such grid"); });
  const auto result = job.take();
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().message().find("no such grid"), std::string::npos) << result.error().message();
}

}  // namespace
}  // namespace kerf::job_test
