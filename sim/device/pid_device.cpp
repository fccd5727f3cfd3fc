#include "sim/device/pid_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <system_error>
#include <thread>

#include "sim/device/device_driver.h"
#include "sim/device/zero_guard.h"
#include "sim/hand/triple_buffer.h"

namespace kerf {
namespace {

constexpr auto kPause = std::chrono::milliseconds(4);
constexpr int kLoadTries = 60;    // as Linux's own driver asks
constexpr int kMostFailures = 3;  // rounds in which no report arrives, one after the other
constexpr double kTurned = 0.02;  // rad: a smaller turn of the force is not worth a report

}  // namespace

bool hasForceFeedback(const HidInfo& info) {
  constexpr std::uint16_t kGenericDesktop = 1, kJoystick = 4, kWheel = 8;
  if (info.usage_page != kGenericDesktop || info.usage < kJoystick || info.usage > kWheel) return false;
  const auto descriptor = readHidDescriptor(info.path);
  if (!descriptor) return false;
  auto layout = parseHidDescriptor(*descriptor);
  return layout && PidReports::of(std::move(*layout)).has_value();
}

struct PidDevice::State {
  State(HidPort opened, PidReports what) : port(std::move(opened)), reports(std::move(what)) {}

  Expected<void> begin();
  Expected<std::uint8_t> load(PidEffect effect);
  void write();
  void update(const PidWish& wish);
  void startAgain();
  void end();
  bool send(const PidReports::Report& report) {
    const bool is_taken = port.write(report);
    (is_taken ? has_sent : has_lost) = true;
    return is_taken;
  }
  void countRound();

  struct Wish {
    PidWish wish;
    std::int64_t wished_ns = 0;
  };
  HidPort port;
  const PidReports reports;
  ZeroGuard guard;                                  // of the thread, once that runs
  std::uint8_t constant = 0, damper = 0, sine = 0;  // blocks; 0: it has none
  TripleBuffer<Wish> wishes;
  std::atomic<bool> is_stopping{false}, is_connected{true}, is_guarded{true};

  // The thread alone.
  PidWish last;
  double angle = 0;
  std::int64_t started_ns = 0, sine_started_ns = 0;
  bool has_sent = false, has_lost = false;  // this round
  bool is_unsure = false;                   // the round before lost a report: all is said again
  int failures = 0;
  std::thread thread;
};

Expected<std::uint8_t> PidDevice::State::load(PidEffect effect) {
  PidLoad loaded;
  if (port.setFeature(reports.create(effect))) {
    for (int n = 0; n < kLoadTries; ++n) {
      PidReports::Report answer = reports.askLoad();
      const int size = port.getFeature(answer);
      if (size > 0) loaded = reports.loadOf(std::span(answer).first(static_cast<std::size_t>(size)));
      if (loaded.status != PidLoad::Status::kNone) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  if (loaded.block != 0) return loaded.block;
  return fail(
      {.code = Error::Code::kUnreadable,
       .place = "force feedback",
       .found = loaded.status == PidLoad::Status::kFull ? "a full pool of effects" : "an effect that does not load",
       .expected = "place for one",
       .hint = "plug the device out and in; another program may use it"});
}

// What was loaded is freed again when something fails: end() knows which.
Expected<void> PidDevice::State::begin() {
  send(reports.control(PidControl::kReset));
  send(reports.control(PidControl::kStopAll));
  send(reports.control(PidControl::kEnable));
  if (const auto gain = reports.gain(1)) send(*gain);
  KERF_TRY(first, load(PidEffect::kConstant));
  constant = first;
  for (const auto& [effect, block] : {std::pair(PidEffect::kDamper, &damper), {PidEffect::kSine, &sine}})
    if (reports.has(effect))
      if (const auto loaded = load(effect)) *block = *loaded;

  send(reports.constant(constant, 0));
  send(reports.set(PidEffect::kConstant, constant, 0));
  if (damper) {
    for (const int axis : {0, 1}) send(reports.damper(damper, 0, axis));
    send(reports.set(PidEffect::kDamper, damper, 0));
  }
  if (sine) {
    send(reports.sine(sine, 0, last.shake_hz));
    send(reports.set(PidEffect::kSine, sine, 0));
  }
  startAgain();
  return {};
}

// What is due is started anew: its time counts from then on. A wave begins at its phase 0 again, so only after whole
// periods, if they are short enough.
void PidDevice::State::startAgain() {
  const std::int64_t now = deviceClock();
  const auto isDue = [&](std::int64_t since, double after) {
    return since == 0 || 1e-9 * static_cast<double>(now - since) >= after;
  };
  if (isDue(started_ns, kStartAgain)) {
    started_ns = now;
    for (const std::uint8_t block : {constant, damper})
      if (block) send(reports.operate(block, PidOperation::kStart));
  }

  const double periods = std::ceil(kStartAgain * last.shake_hz) / std::max(last.shake_hz, 1e-3);
  if (sine && isDue(sine_started_ns, std::clamp(periods, kStartAgain, 0.5 * PidReports::kLasts))) {
    sine_started_ns = now;
    send(reports.operate(sine, PidOperation::kStart));
  }
}

void PidDevice::State::countRound() {
  if (has_sent)
    failures = 0;
  else if (has_lost)
    ++failures;
  is_unsure = has_lost;
  has_sent = has_lost = false;
}

void PidDevice::State::update(const PidWish& wish) {
  const double size = std::hypot(wish.right, wish.away);
  if (is_unsure || wish.right != last.right || wish.away != last.away) {
    const double wanted = size > 0 ? std::atan2(wish.away, wish.right) : angle;
    if (is_unsure || std::abs(wanted - angle) > kTurned) {
      angle = wanted;
      send(reports.set(PidEffect::kConstant, constant, angle));
    }
    send(reports.constant(constant, size));
  }
  if (damper && (is_unsure || wish.damping != last.damping))
    for (const int axis : {0, 1}) send(reports.damper(damper, wish.damping, axis));
  if (sine && (is_unsure || wish.shake != last.shake || wish.shake_hz != last.shake_hz))
    send(reports.sine(sine, wish.shake, wish.shake_hz));
  last = wish;
}

void PidDevice::State::write() {
  has_sent = has_lost = false;
  while (!is_stopping.load(std::memory_order_acquire) && failures < kMostFailures) {
    wishes.update();
    const Wish& newest = wishes.front();
    const double age = 1e-9 * static_cast<double>(deviceClock() - newest.wished_ns);
    PidWish wish = newest.wished_ns != 0 && age < kStale ? newest.wish : PidWish{};
    const bool has_guard = guard.isThere();
    is_guarded.store(has_guard, std::memory_order_release);
    if (!has_guard || !std::isfinite(wish.right) || !std::isfinite(wish.away) || !std::isfinite(wish.damping) ||
        !std::isfinite(wish.shake) || !std::isfinite(wish.shake_hz))
      wish = {};
    update(wish);
    if (reports.hasDuration()) startAgain();
    countRound();
    std::this_thread::sleep_for(kPause);
  }
  const bool is_gone = failures >= kMostFailures;
  if (!is_gone) end();
  guard = {};
  is_connected.store(!is_gone, std::memory_order_release);
}

// Its guard stops what it does not let itself be stopped by from here.
void PidDevice::State::end() {
  const bool is_stopped = send(reports.control(PidControl::kStopAll));
  for (const std::uint8_t block : {constant, damper, sine})
    if (block) send(reports.free(block));
  send(reports.control(PidControl::kDisable));
  if (is_stopped) guard.release();
}

PidDevice::PidDevice(std::unique_ptr<State> state) : state_(std::move(state)) {}
PidDevice::~PidDevice() {
  state_->is_stopping.store(true, std::memory_order_release);
  if (state_->thread.joinable()) state_->thread.join();
}

Expected<std::unique_ptr<PidDevice>> PidDevice::open(const HidInfo& info) {
  KERF_TRY(descriptor, readHidDescriptor(info.path));
  KERF_TRY(layout, parseHidDescriptor(descriptor));
  KERF_TRY(reports, PidReports::of(std::move(layout)));
  KERF_TRY(port, HidPort::open(info.path));
  std::unique_ptr<PidDevice> device(new PidDevice(std::make_unique<State>(std::move(port), std::move(reports))));
  State& s = *device->state_;
  const std::array stop{s.reports.control(PidControl::kStopAll), s.reports.control(PidControl::kDisable)};
  KERF_TRY(guard, ZeroGuard::start(info.path, stop));
  s.guard = std::move(guard);
  if (const auto begun = s.begin(); !begun) {
    s.end();
    return fail(begun.error());
  }
  try {
    s.thread = std::thread([&s] { s.write(); });
  } catch (const std::system_error& e) {
    s.end();
    return fail({.code = Error::Code::kBadValue, .file = info.path, .found = e.what(), .expected = "a thread"});
  }
  return device;
}

bool PidDevice::has(PidEffect effect) const noexcept {
  switch (effect) {
    case PidEffect::kConstant:
      return state_->constant != 0;
    case PidEffect::kDamper:
      return state_->damper != 0;
    case PidEffect::kSine:
      break;
  }
  return state_->sine != 0;
}

bool PidDevice::stopsByItself() const noexcept { return state_->reports.hasDuration(); }

void PidDevice::set(const PidWish& wish) noexcept {
  State::Wish& out = state_->wishes.back();
  out.wish = wish;
  out.wished_ns = deviceClock();
  state_->wishes.publish();
}

bool PidDevice::isConnected() const noexcept { return state_->is_connected.load(std::memory_order_acquire); }
bool PidDevice::isGuarded() const noexcept { return state_->is_guarded.load(std::memory_order_acquire); }

}  // namespace kerf
