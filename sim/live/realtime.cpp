#include "sim/live/realtime.h"

#include <fmt/format.h>
#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace kerf {
namespace {

bool hasCapability(unsigned capability) {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct data[_LINUX_CAPABILITY_U32S_3] = {};
  if (::syscall(SYS_capget, &header, data) != 0) return false;
  return data[CAP_TO_INDEX(capability)].effective & CAP_TO_MASK(capability);
}

std::string limitOf(int resource, const char* unit) {
  rlimit limit{};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0) return "unknown";
  return limit.rlim_cur == RLIM_INFINITY ? "none" : fmt::format("{}{}", limit.rlim_cur, unit);
}

std::string programName() {
  std::array<char, 4096> path{};
  const auto length = ::readlink("/proc/self/exe", path.data(), path.size());
  return length > 0 ? std::string(path.data(), static_cast<std::size_t>(length)) : "PROGRAM";
}

std::string hintFor(const char* limit, const char* value, bool is_privileged) {
  if (is_privileged)
    return "a container or a control group forbids it: start the container with the capability and a real-time budget";
  return fmt::format(
      "add \"@USERS - {} {}\" for a group of yours to /etc/security/limits.d/kerf.conf and log in again, or: sudo "
      "setcap cap_sys_nice,cap_ipc_lock+ep {}",
      limit, value, programName());
}

// Touches the pages once, so that the first deep call finds them.
void prefaultStack() noexcept {
  constexpr std::size_t kBytes = 256 * 1024, kPage = 4096;
  char stack[kBytes];
  for (std::size_t n = 0; n < kBytes; n += kPage) static_cast<volatile char*>(stack)[n] = 0;
}

}  // namespace

std::string RealTimeRefusal::message() const { return fmt::format("{} denied ({}); {}", what, reason, hint); }

std::string RealTimeGrant::summary() const {
  return fmt::format("{}, memory {}", priority > 0 ? fmt::format("SCHED_FIFO {}", priority) : "ordinary priority",
                     is_memory_locked ? "locked" : "not locked");
}

RealTimeGrant askForRealTime(const RealTimeRequest& request) {
  RealTimeGrant out;
  ::prctl(PR_SET_TIMERSLACK, 1UL);  // cannot be refused; SCHED_FIFO has none anyway
  if (request.priority > 0) {
    sched_param wanted{};
    wanted.sched_priority = request.priority;
    if (const int error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &wanted); error == 0)
      out.priority = request.priority;
    else
      out.refusals.push_back(
          {fmt::format("SCHED_FIFO, priority {}", request.priority),
           fmt::format("{}; limit rtprio: {}", std::strerror(error), limitOf(RLIMIT_RTPRIO, "")),
           error == EINVAL ? "choose a priority from 1 to 99" : hintFor("rtprio", "95", hasCapability(CAP_SYS_NICE))});
  }

  if (request.lock_memory) {
    rlimit limit{};
    const bool may_all =
        hasCapability(CAP_IPC_LOCK) || (::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
    const int error = !may_all ? EPERM : ::mlockall(MCL_CURRENT | MCL_FUTURE) == 0 ? 0 : errno;
    if (error == 0)
      out.is_memory_locked = true;
    else
      out.refusals.push_back(
          {"locking memory",
           fmt::format("{}; limit memlock: {}", std::strerror(error), limitOf(RLIMIT_MEMLOCK, " bytes")),
           error == ENOMEM ? "close other programs: the process does not fit into memory"
                           : hintFor("memlock", "unlimited", hasCapability(CAP_IPC_LOCK))});
  }

  prefaultStack();
  return out;
}

void releaseRealTime(const RealTimeGrant& grant) noexcept {
  if (grant.priority > 0) {
    const sched_param ordinary{};
    ::pthread_setschedparam(::pthread_self(), SCHED_OTHER, &ordinary);
  }
  if (grant.is_memory_locked) ::munlockall();
}

// On Linux a thread has a nice value of its own.
void lowerPriority() noexcept { (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), 5); }

std::int64_t monotonicNow() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

namespace {

timespec timeOf(std::int64_t monotonic_ns) {
  timespec out{};
  out.tv_sec = static_cast<time_t>(monotonic_ns / 1'000'000'000);
  out.tv_nsec = static_cast<long>(monotonic_ns % 1'000'000'000);
  return out;
}

}  // namespace

void WakeUp::sleepUntil(std::int64_t monotonic_ns) noexcept {
  const timespec until = timeOf(monotonic_ns);
  while (::sem_clockwait(&wakes_, CLOCK_MONOTONIC, &until) != 0 && errno == EINTR) {
  }
}

void sleepUntil(std::int64_t monotonic_ns) noexcept {
  const timespec until = timeOf(monotonic_ns);
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace kerf
