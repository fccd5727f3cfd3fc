#include "sim/device/hid_arm.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <optional>

#include "sim/device/arm_thread.h"
#include "sim/device/device_driver.h"
#include "sim/device/zero_guard.h"

namespace kerf {
namespace {

constexpr std::int64_t kSendAgain =
    5'000'000;                              // ns, when there is nothing new to say: an arm in lock-step waits for it
constexpr std::uint64_t kMostWaiting = 64;  // reports that the system keeps
constexpr std::int64_t kTakesHome = 1'000'000'000;  // ns, until its reports say that it was calibrated

std::string listOf(const std::vector<FoundArm>& arms) {
  std::string out;
  for (const FoundArm& arm : arms) {
    out += (out.empty() ? "" : ", ") + arm.info.path;
    if (!arm.info.serial.empty()) out += " (serial " + arm.info.serial + ")";
  }
  return out;
}

}  // namespace

std::vector<FoundArm> groupArms(const std::vector<HidInfo>& interfaces) {
  std::vector<FoundArm> out;
  for (const HidInfo& info : interfaces)
    if (const ArmDriver* const driver = armDriverOf(info)) out.push_back({driver, driver->nameOf(info), info});
  return out;
}

Expected<FoundArm> chooseArm(const std::vector<FoundArm>& arms, const std::string& name) {
  std::vector<FoundArm> meant;
  for (const FoundArm& arm : arms)
    if (name.empty() || arm.info.path == name || (!arm.info.serial.empty() && arm.info.serial == name))
      meant.push_back(arm);
  if (meant.size() == 1) return meant.front();
  const std::string what = name.empty() ? "" : " called \"" + name + "\"";
  if (meant.empty())
    return fail(
        {.code = Error::Code::kNotFound,
         .place = "force-feedback devices",
         .found = "none" + what + (arms.empty() ? "" : ", but " + listOf(arms)),
         .expected = "one that a driver knows",
         .hint = "plug it in and see kerf devices; any other one needs a bridge: docs/reference/device-bridge.md"});
  return fail({.code = Error::Code::kBadValue,
               .place = "force-feedback devices",
               .found = fmt::format("{}{}: {}", meant.size(), what, listOf(meant)),
               .expected = "one",
               .hint = "name it by its path or, if each has its own, by its serial number"});
}

struct HidArm::State {
  State(const FoundArm& found, HidPort opened) : what(found), port(std::move(opened)) {}
  void exchange();
  bool receive();
  void answer(std::int64_t now);
  void sendCalibration();
  void confirmCalibration(std::int64_t now);

  const FoundArm what;
  std::optional<HidPort> port;  // none: it was unplugged
  ZeroGuard guard;              // of an arm that keeps its force
  HidArm* arm = nullptr;
  std::atomic<bool> wants_calibration{false};

  // The thread alone.
  ArmState now;
  ArmLink::Hand newest;
  ForceFrame last;
  std::int64_t last_sent = 0;
  bool is_drained = false;         // no report waits that is older than the last round
  std::uint64_t taken = 0;         // reports
  std::int64_t calibrated_ns = 0;  // when it was told that it is at home; 0: it is not waited for
  std::uint64_t waiting = 0;       // the last report that may have waited then

  internal::ArmThread thread;
  // Guarded by the thread's mutex.
  bool is_unplugged = false, is_stuck = false, is_unguarded = false;
  bool ignores_calibration = false;
};

void HidArm::State::exchange() {
  while (!thread.isStopping()) {
    if (!receive()) break;
    if (wants_calibration.exchange(false)) sendCalibration();
    if (calibrated_ns != 0) confirmCalibration(deviceClock());
    answer(deviceClock());
  }
  ArmReportBytes bytes{};
  const std::size_t size = what.driver->write({}, now, what.info, bytes);
  bool is_taken = false;
  for (int n = 0; n < 2; ++n) is_taken = port->write({bytes.data(), size}) || is_taken;
  if (is_taken) guard.release();  // else it writes no force

  // As long as somebody has the node of an unplugged arm open, the arm comes back as another one.
  if (!thread.isStopping()) {
    port.reset();
    guard = {};
  }
}

// Until nothing waits any more; a millisecond for the first one. An arm that talks faster than it is read must not keep
// the force waiting. False: it is gone.
bool HidArm::State::receive() {
  constexpr int kMost = kMostWaiting;
  constexpr std::int64_t kLongest = 3'000'000;  // ns
  const std::int64_t began = deviceClock();
  std::array<std::uint8_t, HidPort::kLongestReport> bytes{};
  bool has_news = false;
  is_drained = false;
  for (int n = 0; n < kMost && deviceClock() - began < kLongest; ++n) {
    const int size = port->read(bytes, n == 0 ? 1 : 0);
    if (size < 0) {
      const std::lock_guard lock(thread.mutex);
      is_unplugged = true;
      return false;
    }
    if (size == 0) {
      is_drained = true;
      break;
    }
    const std::int64_t came = deviceClock();
    const std::span<const std::uint8_t> report(bytes.data(), static_cast<std::size_t>(size));
    thread.tell(came, report);
    const FrameFault fault = what.driver->take(report, now);
    const std::lock_guard lock(thread.mutex);
    ArmCounts& counts = thread.counts;
    if (fault != FrameFault::kNone) {
      ++counts.refused;
      counts.last_fault = nameOf(fault);
      continue;
    }
    ++counts.hands;
    counts.newest_came_ns = came;
    newest.frame = now.hand;
    if (newest.frame.number == 0) countHand(newest.frame, counts.hands, came);  // its reports do not count
    newest.came_ns = came;
    has_news = true;
    ++taken;
  }
  if (has_news) arm->publish(newest);
  return true;
}

void HidArm::State::answer(std::int64_t when) {
  const bool has_no_guard = what.driver->keeps_force && !guard.isThere();
  const ForceFrame next = has_no_guard ? ForceFrame{} : arm->link_.answer(newest, when);
  const bool is_news = next.hand_number != last.hand_number || next.is_enabled != last.is_enabled ||
                       next.force != last.force || next.torque != last.torque;
  if (!is_news && when - last_sent < kSendAgain) return;
  last = next;
  last_sent = when;
  ArmReportBytes bytes{};
  const std::size_t size = what.driver->write(next, now, what.info, bytes);
  const bool is_taken = port->write({bytes.data(), size});
  const std::lock_guard lock(thread.mutex);
  thread.counts.forces += is_taken;
  thread.counts.is_enabled = is_taken && next.is_enabled;
  is_stuck = !is_taken;
  is_unguarded = has_no_guard;
}

void HidArm::State::sendCalibration() {
  ArmReportBytes bytes{};
  const std::size_t size = what.driver->calibrate(what.info, bytes);
  arm->link_.needs_calibration = true;
  port->write({bytes.data(), size});
  calibrated_ns = deviceClock();
  waiting = taken + kMostWaiting;
  const std::lock_guard lock(thread.mutex);
  ignores_calibration = false;
}

// A firmware that does not know the command leaves its encoders where they were, which may be anywhere. Reports that
// waited meanwhile say nothing of it.
void HidArm::State::confirmCalibration(std::int64_t when) {
  const bool is_later = taken > waiting;
  if (is_drained) waiting = std::min(waiting, taken);
  if (is_later && what.driver->isAtHome(now)) {
    calibrated_ns = 0;
    arm->link_.needs_calibration = false;
  } else if (when - calibrated_ns > kTakesHome) {
    calibrated_ns = 0;
    const std::lock_guard lock(thread.mutex);
    ignores_calibration = true;
  }
}

HidArm::HidArm(const ArmSettings& settings, const Rigid3& start, std::unique_ptr<State> state)
    : ForceArm(settings, start), state_(std::move(state)) {
  state_->arm = this;
}
HidArm::~HidArm() { state_->thread.stop(); }

Expected<std::unique_ptr<HidArm>> HidArm::open(const FoundArm& found, const ArmSettings& settings, const Rigid3& start,
                                               ArmListener listener) {
  KERF_TRY(port, HidPort::open(found.info.path));
  std::unique_ptr<HidArm> arm(new HidArm(settings, start, std::make_unique<State>(found, std::move(port))));
  State& s = *arm->state_;
  s.thread.listener = std::move(listener);
  arm->link_.needs_calibration = found.driver->needs_calibration;
  if (found.driver->keeps_force) {
    ArmReportBytes bytes{};
    const std::size_t size = found.driver->write({}, {}, found.info, bytes);
    const ZeroGuard::Report zero(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    KERF_TRY(started, ZeroGuard::start(found.info.path, std::array{zero, zero}));
    s.guard = std::move(started);
  }
  KERF_CHECK(s.thread.start([&s] { s.exchange(); }, found.info.path, ""));
  return arm;
}

std::string HidArm::what() const { return fmt::format("{}, {}", state_->what.name, state_->what.info.path); }

ArmCounts HidArm::counts() const {
  ArmCounts out = state_->thread.told();
  const std::lock_guard lock(state_->thread.mutex);
  out.is_talking = out.is_talking && !state_->is_unplugged;
  if (state_->is_unplugged)
    out.trouble = "it was unplugged: plug it in";
  else if (state_->is_stuck)
    out.trouble = "it takes no report: plug it out and in";
  else if (state_->is_unguarded)
    out.trouble = "it gives no force: the process that guards it is gone; close it, and open it anew";
  else if (state_->ignores_calibration)
    out.trouble =
        "it did not take its calibration: hold it still in its home pose and calibrate it again; if it never takes it, "
        "its firmware does not know how";
  else if (!out.is_talking)
    out.trouble = "it says nothing: switch it on; another program may have taken it";
  return out;
}

bool HidArm::isGone() const {
  const std::lock_guard lock(state_->thread.mutex);
  return state_->is_unplugged;
}

bool HidArm::calibrate() {
  ArmReportBytes bytes{};
  if (state_->what.driver->calibrate(state_->what.info, bytes) == 0) return false;
  link_.needs_calibration = true;
  state_->wants_calibration = true;
  return true;
}

}  // namespace kerf
