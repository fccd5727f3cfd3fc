#include "sim/live/realtime.h"

#include <gtest/gtest.h>
#include <linux/capability.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <random>
#include <thread>

#include "sim/live/time_histogram.h"

namespace kerf::realtime_test {
namespace {

TEST(RealTime, WhatIsNotAskedForIsNotRefused) {
  const RealTimeGrant grant = askForRealTime({.priority = 0, .lock_memory = false});
  EXPECT_TRUE(grant.refusals.empty());
  EXPECT_EQ(grant.priority, 0);
  EXPECT_FALSE(grant.is_memory_locked);
  EXPECT_EQ(grant.summary(), "ordinary priority, memory not locked");
}

TEST(RealTime, APriorityThatDoesNotExistIsRefusedInWords) {
  const RealTimeGrant grant = askForRealTime({.priority = 200, .lock_memory = false});
  ASSERT_EQ(grant.refusals.size(), 1u);
  EXPECT_EQ(grant.priority, 0);
  EXPECT_NE(grant.refusals[0].message().find("from 1 to 99"), std::string::npos) << grant.refusals[0].message();
}

// Returns all grants, so that the next test runs as an ordinary thread.
TEST(RealTime, EverythingAskedForIsGrantedOrRefusedWithAHint) {
  std::thread([] {
    const RealTimeGrant grant = askForRealTime();
    EXPECT_EQ((grant.priority == 80) + grant.is_memory_locked + grant.refusals.size(), 2u);
    for (const RealTimeRefusal& refusal : grant.refusals) EXPECT_FALSE(refusal.hint.empty()) << refusal.message();
    releaseRealTime(grant);
  }).join();
}

// In a separate process, which first gives up its privileges.
TEST(RealTime, WithoutPermissionItSaysWhichLimitToRaise) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const rlimit no_priority{0, 0}, little_memory{65536, 65536};
    __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
    const __user_cap_data_struct none[_LINUX_CAPABILITY_U32S_3] = {};
    if (::setrlimit(RLIMIT_RTPRIO, &no_priority) != 0 || ::setrlimit(RLIMIT_MEMLOCK, &little_memory) != 0 ||
        ::syscall(SYS_capset, &header, none) != 0)
      ::_exit(1);
    const RealTimeGrant grant = askForRealTime();
    if (grant.priority != 0 || grant.is_memory_locked || grant.refusals.size() != 2) ::_exit(2);
    const std::string first = grant.refusals[0].message(), second = grant.refusals[1].message();
    const auto says = [](const std::string& text, const char* what) { return text.find(what) != std::string::npos; };
    if (!says(first, "SCHED_FIFO, priority 80") || !says(first, "rtprio 95") || !says(first, "cap_sys_nice"))
      ::_exit(3);
    if (!says(second, "65536 bytes") || !says(second, "memlock unlimited") || !says(second, "cap_ipc_lock")) ::_exit(4);
    ::_exit(0);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(RealTime, ASleepEndsNotBeforeItsTime) {
  for (const std::int64_t wait : {-1'000'000, 0, 300'000, 2'000'000}) {
    const std::int64_t until = monotonicNow() + wait;
    sleepUntil(until);
    EXPECT_GE(monotonicNow(), until);
  }
}

TEST(TimeHistogram, PercentilesAreThoseOfASortedListToThreePercent) {
  std::mt19937_64 random(3);
  std::lognormal_distribution<double> times(11, 2);  // median 60 us, some above 10 ms
  TimeHistogram histogram;
  std::vector<double> all;
  EXPECT_EQ(histogram.percentileMs(0.5), 0);
  for (int n = 0; n < 20'000; ++n) {
    const auto ns = static_cast<std::int64_t>(times(random));
    histogram.add(ns);
    all.push_back(1e-6 * static_cast<double>(ns));
  }
  std::sort(all.begin(), all.end());
  EXPECT_EQ(histogram.count(), all.size());
  EXPECT_DOUBLE_EQ(histogram.maxMs(), all.back());
  EXPECT_DOUBLE_EQ(histogram.percentileMs(1), all.back());
  for (const double p : {0.01, 0.5, 0.99, 0.999}) {
    const double exact = all[static_cast<std::size_t>(p * static_cast<double>(all.size()))];
    EXPECT_GE(histogram.percentileMs(p), exact);
    EXPECT_LE(histogram.percentileMs(p), exact * (1 + 1.0 / 31));
  }
}

TEST(TimeHistogram, TakesAnyNumber) {
  TimeHistogram histogram;
  for (const std::int64_t ns : {std::int64_t{-5}, std::int64_t{0}, std::int64_t{31}, std::int64_t{32},
                                (std::int64_t{1} << 34) - 1, std::int64_t{1} << 34, std::int64_t{1} << 62})
    histogram.add(ns);
  EXPECT_EQ(histogram.count(), 7u);
  EXPECT_DOUBLE_EQ(histogram.percentileMs(0), 32e-6);
  EXPECT_NEAR(histogram.percentileMs(0.6), 17179.869, 0.001);
  EXPECT_DOUBLE_EQ(histogram.percentileMs(0.99), 1e-6 * static_cast<double>(std::int64_t{1} << 62));
}

}  // namespace
}  // namespace kerf::realtime_test
