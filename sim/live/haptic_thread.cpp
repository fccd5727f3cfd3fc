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

#include "sim/hand/triple_buffer.h"

namespace kerf {
namespace {

constexpr std::int64_t kPeriod = 1'000'000;  // ns
static_assert(kPeriod == static_cast<std::int64_t>(kTick * 1e9 + 0.5));
constexpr int kCommandsATick = 4;
// 2 KiB are copied for each. Undo changes thousands; the mesher has them within some ticks.
constexpr int kEditsATick = 128;
constexpr std::uint64_t kTimesEvery = 100;
// At rest: ticks come in bursts of so many, after so many quiet ones.
constexpr std::int64_t kBurst = 40;
constexpr int kQuietTicks = 500;
constexpr std::size_t kRecords = 4;  // free stroke records an object should have

// Passes everything to the recorder and counts losses.
class RecorderSink final : public SessionSink {
 public:
  void sample(const DeviceSample& sample, std::uint64_t tick) noexcept override { count(sample, tick); }
  void command(const Command& command, std::uint64_t tick) noexcept override { count(command, tick); }
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

tl::unexpected<Error> refuseStart(std::string found, std::string expected, std::string hint) {
  return fail({.code = Error::Code::kBadValue,
               .file = "",
               .place = "starting the haptic thread",
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = std::move(hint)});
}

}  // namespace

void describeScene(const Session& session, HapticReport& report) noexcept {
  report.tick = session.state().tick;
  report.is_latched = session.state().is_latched;
  report.object_count = session.state().objects.size();
  report.removed_by_material.fill(0);
  for (std::size_t n = 0; n < report.object_count; ++n) {
    const CutObject& object = session.state().objects[n];
    const auto loaded = static_cast<std::uint32_t>(session.loadedIndexOf(object));
    double removed = 0;
    for (std::size_t m = 0; m < report.removed_by_material.size(); ++m) {
      const double of_material = object.removed_before_mm3[m] + object.removed_mm3[m];
      if (loaded == 0) report.removed_by_material[m] += of_material;
      removed += of_material;
    }
    report.objects[n] = {object.id, loaded, object.T_world_object, removed};
  }
  report.undo = session.undoList();
}

struct HapticThread::State {
  State(Model model, std::vector<std::shared_ptr<const BakedObject>> objects, const Rigid3& start,
        const HapticOptions& haptic_options)
      : options(haptic_options),
        first_count(objects.size()),
        session(std::move(model), std::move(objects), start, &sink),
        heat(session.model().tools) {
    if (options.begin) {
      begun = options.begin(session);
      session.keepForGood();
    }
    for (std::size_t n = 0; n < session.state().objects.size(); ++n) {
      CutObject& object = session.object(n);
      const std::size_t free = object.freeBricks(), wanted = Session::reserveFor(object);
      if (free < wanted && !object.reserve(wanted - free)) throw std::bad_alloc();
    }
    tellKeeper();
    for (const FeltSource& source : options.felt) vibrations.emplace_back(source, 1 / kTick);
    if (options.pieces.is_wanted) maker.emplace(session, options.pieces);
    report.output.T_world_tool = session.state().body.pose;
  }
  ~State() {
    for (Offer& offer : offers) delete offer.pool.load();
    rooms.consume_all([](Split* room) { delete room; });
  }

  // Haptic thread. No tick after a pause: the schedule restarts.
  void run() noexcept;
  void startUp() noexcept;
  void windDown() noexcept;
  bool prepareTick() noexcept;     // true: there was a pause
  bool waitForBricks() noexcept;   // true: there was a pause
  bool handleCommands() noexcept;  // true: there was a pause
  bool undoOrRedo(const Command& command) noexcept;
  bool deleteObjects(const DeleteObjects& command) noexcept;
  void tick(bool is_stalled) noexcept;
  bool mayRest() noexcept;
  void rest() noexcept;
  void measure(const DeviceSample& sample) noexcept;
  DeviceForce withVibration(const StepOutput& output) noexcept;
  void keepTime(std::int64_t wake) noexcept;
  void restartSchedule() noexcept;
  template <class Work>
  void pauseFor(const Work& work) noexcept;
  bool takePools() noexcept;  // false: not enough for a tick
  void tellKeeper() noexcept;
  std::size_t exportBricks() noexcept;
  void publish() noexcept;
  void publishTimes() noexcept;

  void keepPools();  // the keeper's thread

  const HapticOptions options;
  const std::size_t first_count;  // of objects
  RecorderSink sink;
  Session session;
  std::vector<Command> begun;  // by HapticOptions::begin
  std::optional<PieceMaker> maker;
  LiveHeat heat;
  StrokePeaks peaks;
  DeviceSource* device = nullptr;
  RealTimeGrant grant;
  std::binary_semaphore is_granted{0};

  // Haptic thread only.
  HapticReport report;
  HapticTimes times;
  std::int64_t due = 0;                   // when the next tick begins, ns
  std::int64_t last_wake = 0;             // of the previous tick; 0: none, or a pause
  int quiet_ticks = 0;                    // without a break
  std::size_t unsent = 0;                 // bricks; read after the end
  std::vector<FeltVibration> vibrations;  // of the model's tools, or none

  TripleBuffer<HapticReport> reports;
  TripleBuffer<HapticTimes> newest_times;
  boost::lockfree::spsc_queue<Command, boost::lockfree::capacity<kMostCommands>> commands;
  boost::lockfree::spsc_queue<Split*, boost::lockfree::capacity<kMostCommands>> rooms;  // for deletions, before them
  // For the object of that number: made by the keeper, taken by the haptic thread.
  struct Offer {
    std::atomic<std::size_t> wanted{0};  // bricks; 0: no such object
    std::atomic<BrickPool*> pool{nullptr};
  };
  std::array<Offer, kMostObjects> offers;
  std::atomic<bool> is_stopping{false};
  std::atomic<bool> is_resting{false};
  WakeUp wake;  // by a command
  std::thread keeper, haptic;
};

void HapticThread::State::keepPools() {
  while (!is_stopping.load(std::memory_order_acquire)) {
    for (Offer& offer : offers) {
      const std::size_t wanted = offer.wanted.load(std::memory_order_relaxed);
      if (wanted > 0 && !offer.pool.load(std::memory_order_relaxed))  // no memory: try again soon
        offer.pool.store(BrickPool::make(wanted).release(), std::memory_order_release);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(is_resting.load(std::memory_order_relaxed) ? 20 : 2));
  }
}

// Call when objects come and go.
void HapticThread::State::tellKeeper() noexcept {
  const std::vector<CutObject>& objects = session.state().objects;
  for (std::size_t n = 0; n < offers.size(); ++n)
    offers[n].wanted.store(n < objects.size() ? Session::reserveFor(objects[n]) : 0, std::memory_order_relaxed);
}

bool HapticThread::State::takePools() noexcept {
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

  // No force while the hand waits.
  if (was_latched) {
    device->write({});
  } else {
    DeviceSample none;
    none.T_world_device = session.state().device.pose;
    none.is_valid = 0;
    session.step(none, report.output);
    device->write(report.output.force);
    measure(none);
  }

  work();

  if (!was_latched) session.applyWithin(ClearLatch{});
  ++report.counts.pauses;
  report.counts.longest_pause_ms =
      std::max(report.counts.longest_pause_ms, 1e-6 * static_cast<double>(monotonicNow() - begin));
}

bool HapticThread::State::handleCommands() noexcept {
  if (maker && maker->isBusy()) return false;  // they wait
  if (maker)
    if (const auto is_cut = maker->takeAnswer())
      ++(*is_cut ? report.counts.commands_done : report.counts.commands_refused);
  bool has_paused = false;
  Command next;
  for (int n = 0; n < kCommandsATick && commands.pop(next); ++n) {
    bool is_done = false;
    if (std::holds_alternative<Undo>(next) || std::holds_alternative<Redo>(next)) {
      is_done = undoOrRedo(next);
      has_paused |= is_done;
    } else if (const auto* const cut = std::get_if<CutByPlanes>(&next)) {
      if (maker && maker->order(session, *cut)) break;  // the others wait for it
    } else if (const auto* const deletion = std::get_if<DeleteObjects>(&next)) {
      is_done = deleteObjects(*deletion);
      has_paused |= is_done;
    } else if (rowOf(next).maySend(CommandSender::kUser)) {
      is_done = session.applyWithin(next);
      if (is_done && std::holds_alternative<PlaceTool>(next)) device->placed(session.state().body.pose);
    }
    ++(is_done ? report.counts.commands_done : report.counts.commands_refused);
  }
  return has_paused;
}

bool HapticThread::State::undoOrRedo(const Command& command) noexcept {
  const bool can_be_done = std::holds_alternative<Undo>(command) ? session.canUndo() : session.canRedo();
  if (!can_be_done) return false;  // no reason to pause

  pauseFor([&] {
    session.applyWithin(command);
    tellKeeper();
    while (!session.repair() && !is_stopping.load(std::memory_order_relaxed)) {
      sleepUntil(monotonicNow() + kPeriod);
      takePools();
    }
  });
  return true;
}

bool HapticThread::State::deleteObjects(const DeleteObjects& command) noexcept {
  Split* room = nullptr;
  if (!session.hasRoom() && rooms.pop(room)) session.offerRoom(std::unique_ptr<Split>(room));
  if (!session.hasRoom() || !session.canDelete(command)) return false;
  pauseFor([&] {
    session.applyWithin(command);
    tellKeeper();
  });
  return true;
}

std::size_t HapticThread::State::exportBricks() noexcept {
  std::size_t left = 0;
  for (std::size_t n = 0; n < session.state().objects.size(); ++n) {
    CutObject& object = session.object(n);
    const auto changes = object.changes(BrickSubscriber::kMesher);
    if (!changes.feed()) continue;
    int left_this_tick = kEditsATick;
    changes.take([&](const CutObject::Slot& slot) {
      BrickValues values;
      std::copy_n(slot.phi, kBrickNodes, values.begin());
      if (left_this_tick-- == 0 || !changes.feed()->tryPush(slot.brick, values)) return false;
      ++report.counts.edits_pushed;
      return true;
    });
    left += changes.count();
  }
  return left;
}

void HapticThread::State::publish() noexcept {
  report.counts.records_lost = sink.lost;
  if (maker) report.counts.pieces = maker->counts();
  describeScene(session, report);
  report.heat = heat.report();
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
  device->write(withVibration(report.output));
  measure(sample);
  report.counts.out_of_bricks += (report.output.status & (kStepBricksRanOut | kStepNearRanOut)) != 0;
  report.counts.edits_waiting = exportBricks();
  if (maker) maker->afterTick(session, report.output);
}

// Nobody acts, nothing turns, and all changes are where they belong.
bool HapticThread::State::mayRest() noexcept {
  const kerf::State& now = session.state();
  const bool is_quiet = device->isAtRest() && isAtRest(session.model().tools[now.tool], now.speed) &&
                        report.output.bricks_cut == 0 && report.counts.edits_waiting == 0 &&
                        commands.read_available() == 0 && !(maker && (maker->isBusy() || maker->wantsTick()));
  quiet_ticks = is_quiet ? std::min(quiet_ticks + 1, kQuietTicks) : 0;
  const bool rests = quiet_ticks == kQuietTicks;
  if (is_resting.exchange(rests, std::memory_order_relaxed) != rests && maker) maker->rest(rests);
  return rests;
}

// Sleeps for a burst, or until a command comes, then ticks for the time that went by: the session's clock, its log and
// its heat go on.
void HapticThread::State::rest() noexcept {
  wake.sleepUntil(due + kBurst * kPeriod);
  sleepUntil(due);  // an old command has ended the sleep
  const std::int64_t all = (monotonicNow() - due) / kPeriod;
  std::int64_t owed = std::min(all, 2 * kBurst);
  for (; owed > 0 && !is_stopping.load(std::memory_order_relaxed) && takePools(); --owed) {
    tick(false);
    if (!device->isAtRest()) break;
  }
  due = owed == 0 && all <= 2 * kBurst ? due + all * kPeriod : monotonicNow();
  last_wake = 0;
}

// Measures the last tick: heat and peaks.
void HapticThread::State::measure(const DeviceSample& sample) noexcept {
  ++report.counts.ticks;
  heat.tick(session.state().tool, sample, report.output, session.state().objects);
  const HeatReport& now = heat.report();
  StrokePeaks::Distances distances;
  distances.fill(HeatReport::kFarOff);
  std::copy(now.kept_mm.begin(), now.kept_mm.end(), distances.begin());
  peaks.tick(sample, report.output, session.undoList(), session.state().tick - 1,
             now.is_known ? now.surface : HeatReport::kFarOff, distances);
}

// The force of a tick with the vibration of the tool in use.
DeviceForce HapticThread::State::withVibration(const StepOutput& output) noexcept {
  const kerf::State& now = session.state();
  report.vibration = 0;
  if (now.is_latched || now.tool >= vibrations.size()) return output.force;

  FeltVibration& felt = vibrations[now.tool];
  const Vec3d direction = output.T_world_tool.rotation * felt.source().direction_in_tool;
  DeviceForce force = output.force;
  const double most = session.model().settings.coupling.force_limit;
  report.vibration = now.ramp * felt.next({output.speed, output.normal_load, output.material});
  force.force += report.vibration * direction;
  if (const double size = force.force.norm(); size > most) force.force *= most / size;
  return force;
}

void HapticThread::State::run() noexcept {
  startUp();
  const auto stall = static_cast<std::int64_t>(1e6 * options.stall_ms);
  while (!is_stopping.load(std::memory_order_acquire)) {
    mayRest() ? rest() : sleepUntil(due);
    const std::int64_t woke = monotonicNow();
    if (prepareTick()) {
      restartSchedule();
      publish();
      continue;
    }
    tick(last_wake != 0 && woke - last_wake > stall);
    publish();
    keepTime(woke);
  }
  windDown();
}

void HapticThread::State::startUp() noexcept {
  grant = askForRealTime(options.real_time);
  is_granted.release();
  device->arm();
  restartSchedule();
}

void HapticThread::State::restartSchedule() noexcept {
  due = monotonicNow() + kPeriod;
  last_wake = 0;
  quiet_ticks = 0;
}

// All work between two ticks.
bool HapticThread::State::prepareTick() noexcept {
  if (maker && maker->beforeTick(session)) tellKeeper();
  bool has_paused = waitForBricks();
  has_paused |= handleCommands();
  return has_paused;
}

bool HapticThread::State::waitForBricks() noexcept {
  if (takePools()) return false;
  pauseFor([&] {
    report.is_waiting_for_bricks = true;
    while (!takePools() && !is_stopping.load(std::memory_order_relaxed)) {
      publish();
      sleepUntil(monotonicNow() + kPeriod);
    }
    report.is_waiting_for_bricks = false;
  });
  return true;
}

// Records the times of the last tick, and schedules the next one.
void HapticThread::State::keepTime(std::int64_t wake) noexcept {
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

void HapticThread::State::windDown() noexcept {
  device->write({});
  device->disarm();
  releaseRealTime(grant);
  if (maker) maker->abandon(session);
  session.finish();
  peaks.follow(session.undoList());
  report.output.force = {};
  // A subscriber gets its whole feed; there is a limit in case it is gone.
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
    return refuseStart(fmt::format("{} feeds", feeds.size()),
                       fmt::format("at most one for each of {} objects", s.first_count),
                       "pass one feed an object, or none");
  if (s.haptic.joinable() || s.is_stopping) return refuseStart("a second start", "one", "make another");

  s.device = &device;
  for (std::size_t n = 0; n < feeds.size(); ++n)
    if (feeds[n]) s.session.object(n).changes(BrickSubscriber::kMesher).setFeed(feeds[n]);
  s.sink.recorder = recorder;
  for (const Command& command : s.begun) s.sink.command(command, 0);
  try {
    if (s.maker) s.maker->start();
    s.keeper = std::thread([&s] { s.keepPools(); });
    s.haptic = std::thread([&s] { s.run(); });
  } catch (const std::system_error& e) {
    stop();
    return refuseStart(e.what(), "three threads", "close other programs, or raise the limit nproc");
  }
  s.is_granted.acquire();
  return {};
}

const RealTimeGrant& HapticThread::grant() const noexcept { return state_->grant; }

void HapticThread::watchHeatOf(std::shared_ptr<const Structures> structures) {
  state_->heat.watch(std::move(structures));
}

void HapticThread::heatBy(std::size_t tool, const ToolSamples& samples, const HeatSource& source) {
  state_->heat.add(tool, samples, source);
}

bool HapticThread::send(const Command& command) noexcept {
  if (std::holds_alternative<DeleteObjects>(command))
    if (auto room = prepareDeletion(); state_->rooms.push(room.get())) static_cast<void>(room.release());
  if (!state_->commands.push(command)) return false;
  state_->wake.wake();
  return true;
}

bool HapticThread::update() noexcept { return state_->reports.update(); }
const HapticReport& HapticThread::report() const noexcept { return state_->reports.front(); }
bool HapticThread::updateTimes() noexcept { return state_->newest_times.update(); }
const HapticTimes& HapticThread::times() const noexcept { return state_->newest_times.front(); }

SessionPeaks HapticThread::peaks() const {
  SessionPeaks out{state_->peaks.standing(), state_->peaks.takenBack(), {}, state_->heat.report().alarms};
  if (const Structures* const structures = state_->heat.structures())
    for (const Structures::Structure& structure : structures->all()) out.kept.push_back(structure.id);
  return out;
}

void HapticThread::stop() {
  state_->is_stopping.store(true, std::memory_order_release);
  state_->wake.wake();
  if (state_->haptic.joinable()) state_->haptic.join();
  if (state_->keeper.joinable()) state_->keeper.join();
  if (state_->maker) state_->maker->stop();
}

std::size_t HapticThread::unsentBricks() const noexcept { return state_->unsent; }

}  // namespace kerf
