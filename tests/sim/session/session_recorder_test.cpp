#include "sim/session/session_recorder.h"

#include <gtest/gtest.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <random>
#include <thread>

#include "tests/sim/session_samples.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/temporary_folder.h"

namespace {
std::atomic<int> sync_error = 0;         // error of fdatasync()
std::atomic<int> sync_milliseconds = 0;  // its duration, for a slow disk
}  // namespace

// Replaces the C library's function, here and in the code under test.
extern "C" int fdatasync(int fd) {
  std::this_thread::sleep_for(std::chrono::milliseconds(sync_milliseconds));
  if (sync_error == 0) return static_cast<int>(::syscall(SYS_fdatasync, fd));
  errno = sync_error;
  return -1;
}

namespace kerf::session_recorder_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

// Data from a child process, read by its parent after the child was killed.
struct Told {
  static constexpr std::size_t kMost = 1 << 14;
  std::atomic<std::uint64_t> recorded;       // samples handed to the recorder; their ticks are 0, 1, ...
  std::atomic<std::uint64_t> bytes_written;  // from the recorder's status
  std::atomic<std::int64_t> times[kMost];    // ns, time of each sample's delivery
};
class SharedMemory {
 public:
  SharedMemory()
      : told_(static_cast<Told*>(
            ::mmap(nullptr, sizeof(Told), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0))) {
    if (told_ == MAP_FAILED) throw std::runtime_error("no shared memory");
  }
  ~SharedMemory() { ::munmap(told_, sizeof(Told)); }
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  Told& operator*() const { return *told_; }
  Told* operator->() const { return told_; }

 private:
  Told* told_;
};

// Runs `work` in a separate process that ends without destructors: nothing is flushed or closed implicitly.
pid_t inChild(const std::function<int()>& work) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(work());
  EXPECT_GT(child, 0);
  return child;
}
int statusOf(pid_t child) {
  int status = -1;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return status;
}

std::int64_t now() { return Clock::now().time_since_epoch().count(); }

// Waits up to a minute for another thread.
bool becomesTrue(const std::function<bool()>& holds) {
  for (int i = 0; i < 6000; ++i) {
    if (holds()) return true;
    std::this_thread::sleep_for(10ms);
  }
  return false;
}

TEST(SessionRecorder, EverythingIsInTheLogInItsOrder) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "s.kerflog";
  auto recorder = SessionRecorder::start(path, kSomeHeader);
  ASSERT_TRUE(recorder) << recorder.error().message();
  constexpr std::uint64_t kTicks = 3000;
  for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
    if (tick % 100 == 0) recorder->record(SelectTool{tick}, tick);
    if (tick % 500 == 10) recorder->record(StrokeMark::kBegin, tick);
    ASSERT_EQ(recorder->record(sampleOf(tick), tick), RecordStatus::kRecorded);
    if (tick % 250 == 0) recorder->record(checkOf(tick), tick);
  }
  ASSERT_TRUE(recorder->close());
  EXPECT_EQ(recorder->status().lost, 0u);
  EXPECT_EQ(recorder->status().recorded, kTicks + 30 + 6 + 12);
  EXPECT_EQ(recorder->status().bytes_written, fs::file_size(path));
  EXPECT_EQ(recorder->status().bytes_synced, fs::file_size(path));
  EXPECT_EQ(recorder->record(sampleOf(kTicks), kTicks), RecordStatus::kFailed) << "after the end";

  const auto log = readSessionLog(path);
  ASSERT_TRUE(log) << log.error().message();
  EXPECT_TRUE(log->is_closed);
  EXPECT_FALSE(log->damage);
  EXPECT_EQ(log->header, kSomeHeader);
  ASSERT_EQ(log->samples.size(), kTicks);
  for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
    ASSERT_EQ(log->samples[tick].tick, tick);
    ASSERT_TRUE(sameBits(log->samples[tick].sample, sampleOf(tick))) << tick;
  }
  std::size_t commands = 0, strokes = 0, checks = 0;
  for (const SessionEvent& event : log->events) {
    if (const auto* command = std::get_if<SessionCommand>(&event.what)) {
      EXPECT_EQ(event.tick, 100 * commands++);
      EXPECT_EQ(command->text, "tool.select " + std::to_string(event.tick));
      EXPECT_EQ(event.samples_before, event.tick) << "it comes before the sample of its tick";
    } else if (const auto* check = std::get_if<StateCheck>(&event.what)) {
      EXPECT_EQ(event.tick, 250 * checks++);
      EXPECT_TRUE(sameBits(*check, checkOf(event.tick)));
      EXPECT_EQ(event.samples_before, event.tick + 1) << "it comes after the sample of its tick";
    } else {
      EXPECT_EQ(std::get<StrokeMark>(event.what), StrokeMark::kBegin);
      EXPECT_EQ(event.tick, 10 + 500 * strokes++);
    }
  }
  EXPECT_EQ(commands, 30u);
  EXPECT_EQ(strokes, 6u);
  EXPECT_EQ(checks, 12u);
}

TEST(SessionRecorder, AFullQueueIsToldCountedAndWrittenDown) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "s.kerflog";
  RecorderOptions options;
  options.queue_capacity = 10;
  options.write_every = 1h;  // only close() empties the queue
  auto recorder = SessionRecorder::start(path, {}, options);
  for (std::uint64_t tick = 0; tick < 15; ++tick)
    EXPECT_EQ(recorder->record(sampleOf(tick), tick), tick < 10 ? RecordStatus::kRecorded : RecordStatus::kQueueFull);
  EXPECT_EQ(recorder->record(SelectTool{1}, 15), RecordStatus::kQueueFull);
  EXPECT_EQ(recorder->status().lost, 6u);
  ASSERT_TRUE(recorder->close());
  const auto log = readSessionLog(path);
  EXPECT_EQ(log->samples.size(), 10u);
  ASSERT_EQ(log->events.size(), 1u);
  EXPECT_EQ(std::get<SessionGap>(log->events[0].what).lost, 6u);
  EXPECT_EQ(log->events[0].samples_before, 10u);
}

TEST(SessionRecorder, AGapStandsWhereSomethingIsMissing) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "s.kerflog";
  RecorderOptions options;
  options.write_every = 1ms;
  options.queue_capacity = 4;
  auto recorder = SessionRecorder::start(path, {}, options);
  std::uint64_t taken = 0, tick = 0;
  for (int burst = 0; burst < 20; ++burst) {
    for (int i = 0; i < 40; ++i, ++tick) taken += recorder->record(sampleOf(tick), tick) == RecordStatus::kRecorded;
    ASSERT_TRUE(becomesTrue([&] { return recorder->record(StrokeMark::kEnd, tick) == RecordStatus::kRecorded; }));
  }
  const std::uint64_t lost = recorder->status().lost;
  ASSERT_TRUE(recorder->close());
  EXPECT_GT(lost, 0u) << "the queue was never full: nothing was tested";
  const auto log = readSessionLog(path);
  ASSERT_TRUE(log) << log.error().message();
  EXPECT_EQ(log->samples.size(), taken);
  std::uint64_t lost_in_log = 0;
  std::vector<bool> gap_before(log->samples.size() + 1);
  for (const SessionEvent& event : log->events)
    if (const auto* gap = std::get_if<SessionGap>(&event.what)) {
      lost_in_log += gap->lost;
      gap_before[event.samples_before] = true;
    }
  EXPECT_EQ(lost_in_log, lost);
  for (std::size_t i = 0; i + 1 < log->samples.size(); ++i)
    EXPECT_TRUE(gap_before[i + 1] || log->samples[i + 1].tick == log->samples[i].tick + 1) << i;
}

TEST(SessionRecorder, WhatItRefusesLeavesAGapToo) {
  const TemporaryFolder folder;
  auto recorder = SessionRecorder::start(folder.path() / "s.kerflog", {});
  EXPECT_EQ(recorder->record(sampleOf(5), 5), RecordStatus::kRecorded);
  EXPECT_EQ(recorder->record(sampleOf(5), 5), RecordStatus::kRefused);
  EXPECT_EQ(recorder->record(sampleOf(4), 4), RecordStatus::kRefused);
  ASSERT_TRUE(recorder->close());
  const auto log = readSessionLog(folder.path() / "s.kerflog");
  ASSERT_TRUE(log);
  ASSERT_EQ(log->events.size(), 1u);
  EXPECT_EQ(std::get<SessionGap>(log->events[0].what).lost, 2u);
  EXPECT_EQ(log->events[0].samples_before, 1u);
}

TEST(SessionRecorder, IsWrittenAndSyncedWithoutBeingAsked) {
  const TemporaryFolder folder;
  auto recorder = SessionRecorder::start(folder.path() / "s.kerflog", {});
  const std::uint64_t header = recorder->status().bytes_written;
  EXPECT_EQ(recorder->status().bytes_synced, header) << "what was loaded is on the disk before anything is done";
  recorder->record(sampleOf(0), 0);
  EXPECT_TRUE(becomesTrue([&] { return recorder->status().bytes_written > header; }));
  EXPECT_TRUE(becomesTrue([&] { return recorder->status().bytes_synced > header; }));
  EXPECT_EQ(readSessionLog(folder.path() / "s.kerflog")->samples.size(), 1u);
}

// All calls of the haptic thread in sequence. The queue is full towards the end.
void recordAll(SessionRecorder& recorder, std::uint64_t from, std::uint64_t to) {
  for (std::uint64_t tick = from; tick < to; ++tick) {
    recorder.record(MoveObject{tick, {-1.0 / 3, 1e-300, 0.1}, {1, 0, 0, 1e-12}}, tick);  // a long text
    recorder.record(StrokeMark::kBegin, tick);
    recorder.record(sampleOf(tick), tick);
    recorder.record(checkOf(tick), tick);
  }
}

TEST(SessionRecorder, RecordingNeitherAllocatesNorFrees) {
  const TemporaryFolder folder;
  auto recorder = SessionRecorder::start(folder.path() / "s.kerflog", {});
  {
    const AllocationGuard guard;
    recordAll(*recorder, 0, 4000);  // twice the capacity of the queue
  }
  ASSERT_TRUE(recorder->close());
}

TEST(AllocationGuardDeathTest, AllocatingAndFreeingEndTheProgram) {
  static std::vector<int> numbers;  // static, so that the compiler cannot remove the allocation
  EXPECT_DEATH(
      {
        const AllocationGuard guard;
        numbers.resize(100);
      },
      "operator new under an AllocationGuard");
  numbers.resize(100);
  EXPECT_DEATH(
      {
        const AllocationGuard guard;
        std::vector<int>().swap(numbers);
      },
      "operator delete under an AllocationGuard");
}

// In strict seccomp mode the kernel ends a thread at any system call except read, write and exit: a lock that waits or
// wakes would show.
TEST(SessionRecorder, RecordingMakesNoSystemCall) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizer makes some of its own";
#endif
  const TemporaryFolder folder;
  constexpr int kSurvived = 10, kEnded = 11, kNoSeccomp = 12;
  const auto run = [&](const char* name, bool with_call) {
    return WEXITSTATUS(statusOf(inChild([&]() -> int {
      auto recorder = SessionRecorder::start(folder.path() / name, {});
      std::atomic<int> came_to = kNoSeccomp;
      std::thread haptic([&] {
        if (::prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0) return;
        came_to = kEnded;
        recordAll(*recorder, 0, 4000);
        if (with_call) ::syscall(SYS_getppid);
        came_to = kSurvived;
        ::syscall(SYS_exit, 0);  // of this thread; the library's way out makes other calls
      });
      haptic.join();
      return came_to;
    })));
  };
  const int trapped = run("trapped.kerflog", true);
  if (trapped == kNoSeccomp) GTEST_SKIP() << "seccomp is not allowed here";
  ASSERT_EQ(trapped, kEnded) << "the trap does not work";
  EXPECT_EQ(run("free.kerflog", false), kSurvived);
}

// In a child, because the limit applies to the whole process.
TEST(SessionRecorder, AFullDiskIsReportedAndTheLogStaysWhole) {
#if defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "ThreadSanitizer takes two threads of a forked child, one after the other, for the same";
#endif
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "s.kerflog";
  const SharedMemory told;
  constexpr std::uint64_t kLimit = 50'000;
  const int status = statusOf(inChild([&] {
    auto recorder = SessionRecorder::start(path, kSomeHeader);
    if (!recorder) return 1;
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{kLimit, kLimit};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) return 2;
    std::uint64_t tick = 0;
    const bool failed = becomesTrue([&] {
      for (int i = 0; i < 20; ++i, ++tick)
        if (recorder->record(sampleOf(tick), tick) == RecordStatus::kFailed) return true;
      return false;
    });
    if (!failed) return 3;
    const RecorderStatus now = recorder->status();
    if (!now.error || now.error->found != "File too large" || now.error->file != path.string()) return 4;
    if (now.error->hint.find("free some space") == std::string::npos) return 5;
    if (now.lost == 0 || now.recorded + now.lost < tick) return 6;
    const auto closed = recorder->close();
    if (closed || closed.error().found != "File too large") return 8;
    told->bytes_written = recorder->status().bytes_written;
    return 0;
  }));
  ASSERT_TRUE(WIFEXITED(status));
  ASSERT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(fs::file_size(path), told->bytes_written) << "what did not fit was cut off";
  EXPECT_LE(fs::file_size(path), kLimit);
  const auto log = readSessionLog(path);
  ASSERT_TRUE(log) << log.error().message();
  EXPECT_FALSE(log->damage);
  EXPECT_FALSE(log->is_closed);
  EXPECT_GT(log->samples.size(), 0u);
  for (std::size_t i = 0; i < log->samples.size(); ++i) EXPECT_TRUE(sameBits(log->samples[i].sample, sampleOf(i)));
}

TEST(SessionRecorder, ASyncThatFailsEndsTheRecordingAndIsReported) {
  const TemporaryFolder folder;
  auto recorder = SessionRecorder::start(folder.path() / "s.kerflog", {});
  recorder->record(sampleOf(0), 0);
  sync_error = EIO;
  EXPECT_TRUE(becomesTrue([&] { return recorder->status().error.has_value(); }));
  sync_error = 0;
  EXPECT_EQ(recorder->status().error->found, "Input/output error");
  EXPECT_EQ(recorder->record(sampleOf(1), 1), RecordStatus::kFailed);
  EXPECT_FALSE(recorder->close());
  const auto log = readSessionLog(folder.path() / "s.kerflog");
  EXPECT_EQ(log->samples.size(), 1u) << "what was written before can be read";
  EXPECT_FALSE(log->is_closed);
}

// A haptic thread in real time, until it is killed.
int recordUntilKilled(const fs::path& path, Told& told) {
  auto recorder = SessionRecorder::start(path, kSomeHeader);
  if (!recorder) return 1;
  timespec next{};
  ::clock_gettime(CLOCK_MONOTONIC, &next);
  for (std::uint64_t tick = 0; tick < Told::kMost; ++tick) {
    if (recorder->record(sampleOf(tick), tick) != RecordStatus::kRecorded) return 2;
    told.times[tick] = now();
    told.recorded = tick + 1;
    if (tick % 8 == 0) told.bytes_written = recorder->status().bytes_written;
    next.tv_nsec += 1'000'000;
    if (next.tv_nsec >= 1'000'000'000) {
      next.tv_nsec -= 1'000'000'000;
      ++next.tv_sec;
    }
    while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, nullptr) == EINTR) {
    }
  }
  return 3;
}

// Kills children after these times, `at_once` of them in parallel, and reads their logs.
void killAndRead(const std::vector<std::chrono::milliseconds>& lives, std::size_t at_once) {
  const TemporaryFolder folder;
  std::uint64_t samples = 0, most_missing = 0;
  for (std::size_t begin = 0; begin < lives.size(); begin += at_once) {
    const std::size_t end = std::min(lives.size(), begin + at_once);
    std::vector<SharedMemory> told(end - begin);
    std::vector<std::thread> killers;
    std::vector<std::int64_t> killed(end - begin);
    std::vector<pid_t> children;
    const auto path = [&](std::size_t i) { return folder.path() / (std::to_string(begin + i) + ".kerflog"); };
    for (std::size_t i = 0; i < told.size(); ++i)
      children.push_back(inChild([&] { return recordUntilKilled(path(i), *told[i]); }));
    for (std::size_t i = 0; i < told.size(); ++i)
      killers.emplace_back([&, i] {
        // From the first sample on, so that a slow start does not count as lifetime.
        becomesTrue([&] { return told[i]->recorded > 0; });
        std::this_thread::sleep_for(lives[begin + i]);
        killed[i] = now();
        ::kill(children[i], SIGKILL);
      });
    for (std::thread& killer : killers) killer.join();
    for (std::size_t i = 0; i < told.size(); ++i) {
      const int status = statusOf(children[i]);
      ASSERT_TRUE(WIFSIGNALED(status)) << "ended by itself with " << WEXITSTATUS(status);
      const auto log = readSessionLog(path(i));
      ASSERT_TRUE(log) << log.error().message();
      EXPECT_EQ(log->header, kSomeHeader);
      EXPECT_TRUE(log->events.empty());
      EXPECT_GE(fs::file_size(path(i)), told[i]->bytes_written) << "said to be written, and is not there";
      const std::size_t read = log->samples.size();
      const std::uint64_t recorded = told[i]->recorded;
      ASSERT_LE(read, recorded + 1) << "more than was sent; one may have been sent and not counted";
      for (std::size_t k = 0; k < read; ++k)
        ASSERT_TRUE(log->samples[k].tick == k && sameBits(log->samples[k].sample, sampleOf(k))) << k;
      EXPECT_TRUE(read >= recorded || told[i]->times[read] > killed[i] - 1'000'000'000)
          << "older than a second, and lost";
      samples += recorded;
      most_missing = std::max<std::uint64_t>(most_missing, recorded - std::min<std::uint64_t>(read, recorded));
    }
  }
  std::printf("%zu killed, %llu samples recorded, at most %llu of one child missing\n", lives.size(),
              static_cast<unsigned long long>(samples), static_cast<unsigned long long>(most_missing));
}

TEST(SessionRecorder, KilledAtAHundredMomentsItLeavesAWholeLog) {
  std::mt19937 random(20261121);
  std::vector<std::chrono::milliseconds> lives;
  for (int i = 0; i < 100; ++i) lives.emplace_back(50 + random() % 351);
  killAndRead(lives, 4);
}

TEST(SessionRecorder, KilledItLosesNothingOlderThanASecond) { killAndRead({1300ms, 1450ms, 1600ms, 1750ms}, 4); }

TEST(SessionRecorder, ADiskThatTakesItsTimeToSyncCostsNoMore) {
  // Seconds per sync, as for a busy hard disk or a memory card: a kill must not lose the queue.
  sync_milliseconds = 3000;
  killAndRead({1500ms, 1700ms}, 2);
  sync_milliseconds = 0;
}

}  // namespace
}  // namespace kerf::session_recorder_test
