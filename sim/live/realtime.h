// Real-time privileges of a thread, and remedies for those the system denies.
#pragma once

#include <semaphore.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace kerf {

struct RealTimeRequest {
  /// SCHED_FIFO priority, 1 to 99; 0: ordinary thread. Above all ordinary threads, below the kernel's own at 99.
  int priority = 80;
  /// Lock all memory of the process, present and future: no swapping, no late allocation.
  bool lock_memory = true;
};

/// One denied privilege.
struct RealTimeRefusal {
  std::string what;    ///< "SCHED_FIFO, priority 80"
  std::string reason;  ///< the system's message
  std::string hint;    ///< remedy, a sentence
  /// One sentence of all three, for a log or a window.
  std::string message() const;
};

/// Privileges of a thread. Never an error: without them everything runs, only later at times.
struct RealTimeGrant {
  int priority = 0;                       ///< of SCHED_FIFO; 0: an ordinary thread
  bool is_memory_locked = false;          ///< by this request; of the whole process, until it is released
  std::vector<RealTimeRefusal> refusals;  ///< in the order of the request
  /// "SCHED_FIFO 80, memory locked", "ordinary priority, memory not locked".
  std::string summary() const;
};

/// Requests for the calling thread: SCHED_FIFO, locked memory, a prefaulted stack, and the system's most exact timers
/// (the system wakes an ordinary thread up to 50 µs late, on purpose). Allocates and makes system calls: call once,
/// before the thread's first tick.
///
/// A memory limit (RLIMIT_MEMLOCK) below the whole memory counts as a refusal, even if the process would fit now: with
/// memory locked the next allocation beyond the limit would fail.
RealTimeGrant askForRealTime(const RealTimeRequest& request = {});
/// Gives back the calling thread's privileges: ordinary priority, memory unlocked.
void releaseRealTime(const RealTimeGrant& grant) noexcept;

/// For the calling thread, if it works in the background: it gets what the others leave.
void lowerPriority() noexcept;

/// ns of the clock for periods; never goes back.
std::int64_t monotonicNow() noexcept;
/// Sleeps until then (clock_nanosleep, TIMER_ABSTIME on CLOCK_MONOTONIC): no drift, however long the work took.
///
/// Sleeping, not spinning: a thread of SCHED_FIFO that spins owns its core, is throttled by the system for 50 ms of
/// every second (sched_rt_runtime_us), and on two cores takes one from mesher, recorder and window. Spinning would save
/// the wake-up, 15 to 80 µs of 1000 here, which delays the sample but not the force it gives.
void sleepUntil(std::int64_t monotonic_ns) noexcept;

/// A sleep that another thread can end.
class WakeUp {
 public:
  WakeUp() noexcept { ::sem_init(&wakes_, 0, 0); }
  ~WakeUp() { ::sem_destroy(&wakes_); }
  WakeUp(const WakeUp&) = delete;
  WakeUp& operator=(const WakeUp&) = delete;
  /// Until then, or until wake(): one before the sleep counts, too.
  void sleepUntil(std::int64_t monotonic_ns) noexcept;
  /// Any thread.
  void wake() noexcept { ::sem_post(&wakes_); }

 private:
  ::sem_t wakes_;
};

}  // namespace kerf
