#include "sim/live/haptic_thread.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <chrono>
#include <cmath>
#include <optional>
#include <semaphore>
#include <system_error>
#include <thread>

#include "sim/live/triple_buffer.h"

namespace kerf {
namespace {

constexpr std::int64_t kPeriod = 1'000'000;  // ns
static_assert(kPeriod == static_cast<std::int64_t>(kTick * 1e9 + 0.5));
constexpr int kCommandsATick = 4;
// 2 KiB are copied for each. Undo changes thousands; the mesher has them within some ticks.
constexpr int kEditsATick = 128;
constexpr std::uint64_t kTimesEvery = 100;
constexpr std::size_t kRecords = 4;  // of strokes an object should have free

struct CommandText {
  std::array<char, kMaxCommandBytes> text;
  std::size_t size = 0;
};

// Everything to the recorder, and what it did not take is counted.
class RecorderSink final : public SessionSink {
 public:
  void sample(const DeviceSample& sample, std::uint64_t tick) noexcept override { count(sample, tick); }
  void command(std::string_view text, std::uint64_t tick) noexcept override { count(text, tick); }
  void mark(StrokeMark mark, std::uint64_t tick) noexcept override { count(mark, tick); }
  void check(const StateCheck& check, std::uint64_t tick) noexcept override { count(check, tick); }
  SessionRecorder* recorder = nullptr;
  std::uint64_t lost = 0;

 private:
  template <class What>
  void count(const What& what, std::uint64_t tick) noexcept {
    if (recorder) lost += recorder->record(what, tick) != RecordStatus::kRecorded;
  }
};

}  // namespace

struct HapticThread::State {
  State(Model model, std::vector<std::shared_ptr<const BakedObject>> objects, const Rigid3& start,
        const HapticOptions& haptic_options)
      : options(haptic_options),
        first_count(objects.size()),
        session(std::move(model), std::move(objects), start, &sink) {
    for (std::size_t n = 0; n < first_count; ++n) {
      CutObject& object = session.object(n);
      const std::size_t free = object.freeBricks(), wanted = Session::reserveFor(object);
      if (free < wanted && !object.reserve(wanted - free)) throw std::bad_alloc();
    }
    tellKeeper();
    if (options.pieces.is_wanted) maker.emplace(session, options.pieces);
    report.output.T_world_tool = session.state().body.pose;
  }
  ~State() {
    for (Offer& offer : offers) delete offer.pool.load();
  }

  // Haptic thread.
  void run() noexcept;
  void tick(bool is_stalled) noexcept;
  bool handleCommands() noexcept;  // true: there was a pause
  template <class Work>
  void pauseFor(const Work& work) noexcept;
  bool takePool() noexcept;  // false: not enough for a tick
  void tellKeeper() noexcept;
  std::size_t exportBricks() noexcept;
  void publish() noexcept;
  void publishTimes() noexcept;

  void keepPool();  // the keeper's thread

  const HapticOptions options;
  const std::size_t first_count;  // of objects
  RecorderSink sink;
  Session session;
  std::optional<PieceMaker> maker;
  DeviceSource* device = nullptr;
  RealTimeGrant grant;
  std::binary_semaphore is_granted{0};

  // Haptic thread only.
  HapticReport report;
  HapticTimes times;
  std::size_t unsent = 0;  // read after the end

  TripleBuffer<HapticReport> reports;
  TripleBuffer<HapticTimes> newest_times;
  boost::lockfree::spsc_queue<CommandText, boost::lockfree::capacity<kMostCommands>> commands;
  struct Offer {                         // to the object of that number: made by the keeper, taken by the haptic thread
    std::atomic<std::size_t> wanted{0};  // bricks; 0: there is no such object
    std::atomic<BrickPool*> pool{nullptr};
  };
  std::array<Offer, kMostObjects> offers;
  std::atomic<bool> is_stopping{false};
  std::thread keeper, haptic;
};

void HapticThread::State::keepPool() {
  while (!is_stopping.load(std::memory_order_acquire)) {
    for (Offer& offer : offers) {
      const std::size_t wanted = offer.wanted.load(std::memory_order_relaxed);
      if (wanted > 0 && !offer.pool.load(std::memory_order_relaxed))  // without memory: again in a moment
        offer.pool.store(BrickPool::make(wanted).release(), std::memory_order_release);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

// When objects come and go.
void HapticThread::State::tellKeeper() noexcept {
  const std::vector<CutObject>& objects = session.state().objects;
  for (std::size_t n = 0; n < offers.size(); ++n)
    offers[n].wanted.store(n < objects.size() ? Session::reserveFor(objects[n]) : 0, std::memory_order_relaxed);
}

bool HapticThread::State::takePool() noexcept {
  bool is_enough = true;
  for (std::size_t n = 0; n < session.state().objects.size(); ++n) {
    CutObject& object = session.object(n);
    const std::size_t wanted = Session::reserveFor(object);
    const bool wants_pool = object.freeBricks() < wanted || object.memory().freeRecords() < kRecords;
    if (wants_pool && offers[n].pool.load(std::memory_order_relaxed)) {
      object.memory().take(std::unique_ptr<BrickPool>(offers[n].pool.exchange(nullptr, std::memory_order_acq_rel)));
      ++report.counts.pools_taken;
    }
    is_enough &= object.freeBricks() >= wanted / 2 && object.memory().freeRecords() > 1;  // undo ends a stroke, too
  }
  return is_enough;
}

template <class Work>
void HapticThread::State::pauseFor(const Work& work) noexcept {
  const std::int64_t begin = monotonicNow();
  const bool was_latched = session.state().is_latched;
  if (was_latched) {
    device->write({});
  } else {
    DeviceSample none;
    none.T_world_device = session.state().device.pose;
    none.is_valid = 0;
    session.step(none, report.output);
    ++report.counts.ticks;
    device->write(report.output.force);
  }
  work();
  if (!was_latched) session.applyWithin("latch.clear");
  ++report.counts.pauses;
  report.counts.longest_pause_ms =
      std::max(report.counts.longest_pause_ms, 1e-6 * static_cast<double>(monotonicNow() - begin));
}

bool HapticThread::State::handleCommands() noexcept {
  bool has_paused = false;
  if (maker && maker->hasFrozen()) return false;  // they wait
  CommandText next;
  for (int n = 0; n < kCommandsATick && commands.pop(next); ++n) {
    const std::string_view text(next.text.data(), next.size);
    bool is_done = false;
    if (text == "undo" || text == "redo") {
      is_done = text == "undo" ? session.canUndo() : session.canRedo();
      if (is_done) {
        pauseFor([&] {
          session.applyWithin(text);
          tellKeeper();
          while (!session.repair() && !is_stopping.load(std::memory_order_relaxed)) {
            sleepUntil(monotonicNow() + kPeriod);
            takePool();
          }
        });
        has_paused = true;
      }
    } else if (!text.starts_with("pieces.") && text != "object.hold" && !text.starts_with("object.hold ") &&
               !text.starts_with("object.release")) {  // the maker's
      is_done = session.applyWithin(text);
    }
    ++(is_done ? report.counts.commands_done : report.counts.commands_refused);
  }
  return has_paused;
}

std::size_t HapticThread::State::exportBricks() noexcept {
  std::size_t left = 0;
  for (std::size_t n = 0; n < session.state().objects.size(); ++n) {
    CutObject& object = session.object(n);
    const auto changes = object.changes(BrickSubscriber::kMesher);
    if (!changes.feed()) continue;
    int room = kEditsATick;
    changes.take([&](const CutObject::Slot& slot) {
      BrickValues values;
      std::copy_n(slot.phi, kBrickNodes, values.begin());
      if (room-- == 0 || !changes.feed()->tryPush(slot.brick, values)) return false;
      ++report.counts.edits_pushed;
      return true;
    });
    left += changes.count();
  }
  return left;
}

void HapticThread::State::publish() noexcept {
  report.tick = session.state().tick;
  report.is_latched = session.state().is_latched;
  report.counts.records_lost = sink.lost;
  if (maker) report.counts.pieces = maker->counts();
  report.object_count = session.state().objects.size();
  for (std::size_t n = 0; n < report.object_count; ++n) {
    const CutObject& object = session.state().objects[n];
    report.objects[n] = {object.id, object.T_world_object};
  }
  reports.back() = report;
  reports.publish();
}

void HapticThread::State::publishTimes() noexcept {
  newest_times.back() = times;
  newest_times.publish();
}

void HapticThread::State::tick(bool is_stalled) noexcept {
  DeviceSample sample = device->read();
  if (is_stalled) {
    sample.is_valid = 0;
    ++report.counts.stalls;
  }
  session.step(sample, report.output);
  device->write(report.output.force);
  ++report.counts.ticks;
  report.counts.out_of_bricks += (report.output.status & (kStepBricksRanOut | kStepNearRanOut)) != 0;
  exportBricks();
  if (maker) maker->afterTick(session, report.output);
  publish();
}

void HapticThread::State::run() noexcept {
  grant = askForRealTime(options.real_time);
  is_granted.release();
  device->arm();
  const auto stall = static_cast<std::int64_t>(1e6 * options.stall_ms);
  std::int64_t due = monotonicNow() + kPeriod, last_wake = 0;
  while (!is_stopping.load(std::memory_order_acquire)) {
    sleepUntil(due);
    const std::int64_t wake = monotonicNow();
    bool has_paused = false;
    if (maker && maker->beforeTick(session)) tellKeeper();
    if (!takePool()) {
      pauseFor([&] {
        report.is_waiting_for_bricks = true;
        while (!takePool() && !is_stopping.load(std::memory_order_relaxed)) {
          publish();
          sleepUntil(monotonicNow() + kPeriod);
        }
        report.is_waiting_for_bricks = false;
      });
      has_paused = true;
    }
    has_paused |= handleCommands();
    if (has_paused) {  // the schedule begins anew
      due = monotonicNow() + kPeriod;
      last_wake = 0;
      publish();
      continue;
    }
    tick(last_wake != 0 && wake - last_wake > stall);
    const std::int64_t end = monotonicNow();
    times.lateness.add(wake - due);
    if (last_wake != 0) times.jitter.add(std::abs(wake - last_wake - kPeriod));
    times.cost.add(end - wake);
    last_wake = wake;
    due += kPeriod;
    if (end > due) {
      const std::int64_t missed = (end - due + kPeriod - 1) / kPeriod;
      ++report.counts.overruns;
      report.counts.missed_periods += static_cast<std::uint64_t>(missed);
      due += missed * kPeriod;
    }
    if (times.cost.count() % kTimesEvery == 0) publishTimes();
  }
  device->write({});
  device->disarm();
  releaseRealTime(grant);
  if (maker) maker->abandon(session);
  session.finish();
  report.output.force = {};
  // Whoever follows a feed shall have all of it; but a follower that is gone is not waited for.
  for (int n = 0; n < 2000 && (unsent = exportBricks()) > 0; ++n) sleepUntil(monotonicNow() + kPeriod);
  publish();
  publishTimes();
}

HapticThread::HapticThread(Model model, std::vector<std::shared_ptr<const BakedObject>> objects, const Rigid3& start,
                           const HapticOptions& options)
    : state_(std::make_unique<State>(std::move(model), std::move(objects), start, options)) {}

HapticThread::~HapticThread() { stop(); }

const Session& HapticThread::session() const noexcept { return state_->session; }

Expected<void> HapticThread::start(DeviceSource& device, std::span<BrickFeed* const> feeds, SessionRecorder* recorder) {
  State& s = *state_;
  if (feeds.size() > s.first_count)
    return fail({Error::Code::kBadValue, "", "starting the haptic thread", fmt::format("{} feeds", feeds.size()),
                 fmt::format("at most one for each of {} objects", s.first_count), "pass one feed an object, or none"});
  if (s.haptic.joinable() || s.is_stopping)
    return fail({Error::Code::kBadValue, "", "starting the haptic thread", "a second start", "one", "make another"});
  s.device = &device;
  for (std::size_t n = 0; n < feeds.size(); ++n)
    s.session.object(n).changes(BrickSubscriber::kMesher).setFeed(feeds[n]);
  s.sink.recorder = recorder;
  try {
    if (s.maker) s.maker->start();
    s.keeper = std::thread([&s] { s.keepPool(); });
    s.haptic = std::thread([&s] { s.run(); });
  } catch (const std::system_error& e) {
    stop();
    return fail({Error::Code::kBadValue, "", "starting the haptic thread", e.what(), "three threads",
                 "close other programs, or raise the limit nproc"});
  }
  s.is_granted.acquire();
  return {};
}

const RealTimeGrant& HapticThread::grant() const noexcept { return state_->grant; }

bool HapticThread::send(std::string_view command) noexcept {
  if (command.size() > kMaxCommandBytes) return false;
  CommandText text;
  std::copy(command.begin(), command.end(), text.text.begin());
  text.size = command.size();
  return state_->commands.push(text);
}

bool HapticThread::update() noexcept { return state_->reports.update(); }
const HapticReport& HapticThread::report() const noexcept { return state_->reports.front(); }
bool HapticThread::updateTimes() noexcept { return state_->newest_times.update(); }
const HapticTimes& HapticThread::times() const noexcept { return state_->newest_times.front(); }

void HapticThread::stop() {
  state_->is_stopping.store(true, std::memory_order_release);
  if (state_->haptic.joinable()) state_->haptic.join();
  if (state_->keeper.joinable()) state_->keeper.join();
  if (state_->maker) state_->maker->stop();
}

std::size_t HapticThread::unsentBricks() const noexcept { return state_->unsent; }

}  // namespace kerf
