// What the system grants a thread that must not be late, and what to do about what it refuses.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace kerf {

struct RealTimeRequest {
  /// SCHED_FIFO priority, 1 to 99; 0: not asked for. Above all ordinary threads, below the kernel's own at 99.
  int priority = 80;
  /// Keep all memory of the process, present and future, from being swapped or handed out late.
  bool lock_memory = true;
};

/// One thing that was refused.
struct RealTimeRefusal {
  std::string what;    ///< "SCHED_FIFO, priority 80"
  std::string reason;  ///< the system's words
  std::string hint;    ///< what to do, a sentence
  /// One sentence of all three, for a log or a window.
  std::string message() const;
};

/// What a thread was given. Never an error: without it everything runs, only later at times.
struct RealTimeGrant {
  int priority = 0;                       ///< of SCHED_FIFO; 0: an ordinary thread
  bool is_memory_locked = false;          ///< by this request; of the whole process, until it is released
  std::vector<RealTimeRefusal> refusals;  ///< in the order of the request
  /// "SCHED_FIFO 80, memory locked", "ordinary priority, memory not locked".
  std::string summary() const;
};

/// Asks for the calling thread: SCHED_FIFO, locked memory, a prefaulted stack, and timers as exact as the system has
/// them (an ordinary thread is otherwise woken up to 50 µs late, on purpose). Allocates, makes system calls: once,
/// before the thread's first tick.
///
/// A memory limit (RLIMIT_MEMLOCK) that is smaller than all of memory is taken for a refusal, even where the process
/// would fit now: with memory locked the next allocation beyond the limit would fail.
RealTimeGrant askForRealTime(const RealTimeRequest& request = {});
/// Gives back what the calling thread was granted: ordinary priority, memory unlocked.
void releaseRealTime(const RealTimeGrant& grant) noexcept;

/// ns of the clock that periods are counted by; never goes back.
std::int64_t monotonicNow() noexcept;
/// Sleeps until then (clock_nanosleep, TIMER_ABSTIME on CLOCK_MONOTONIC): no drift, whatever the work in between took.
///
/// Sleeping, not spinning: a thread of SCHED_FIFO that spins owns its core, is throttled by the system for 50 ms of
/// every second (sched_rt_runtime_us), and on two cores takes one from mesher, recorder and window. What a spin would
/// win is the wake-up, 15 to 80 µs of 1000 here, which delays the sample and not the force it gives.
void sleepUntil(std::int64_t monotonic_ns) noexcept;

}  // namespace kerf
