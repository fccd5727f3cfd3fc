#include "sim/device/arm/hid_arm.h"

#include <fmt/format.h>

#include <array>
#include <mutex>
#include <optional>

#include "sim/device/arm/arm_thread.h"
#include "sim/device/hid/device_driver.h"

namespace kerf {
namespace {

constexpr std::int64_t kReportAgain = 5'000'000;  // ns without news: an arm in lock-step waits for a report

}  // namespace

struct HidArm::State {
  State(const FoundDevice& found, HidPort opened) : what(found), port(std::move(opened)) {}
  void exchange();
  bool receive();
  void answer(std::int64_t now);
  bool write(const ForceFrame& force);

  const FoundDevice what;
  std::optional<HidPort> port;  // null: unplugged
  HidArm* arm = nullptr;

  // The thread alone.
  ArmLink::Hand newest;
  ForceFrame last;
  std::int64_t last_sent = 0;

  internal::ArmThread thread;
  // Guarded by the thread's mutex.
  bool is_unplugged = false, is_stuck = false;
};

void HidArm::State::exchange() {
  while (!thread.isStopping()) {
    if (!receive()) break;
    answer(deviceClock());
  }
  for (int n = 0; n < 2; ++n) write({});

  // While a process has the node of an unplugged arm open, the arm comes back at another node.
  if (!thread.isStopping()) port.reset();
}

// Reads until no report waits; a millisecond for the first one. An arm that sends faster than this thread reads must
// not delay the force. False: the arm is gone.
bool HidArm::State::receive() {
  constexpr int kMost = 64;                     // reports that the system keeps
  constexpr std::int64_t kLongest = 3'000'000;  // ns
  const std::int64_t began = deviceClock();
  std::array<std::uint8_t, HidPort::kLongestReport> bytes{};
  bool has_news = false;
  for (int n = 0; n < kMost && deviceClock() - began < kLongest; ++n) {
    const int size = port->read(bytes, n == 0 ? 1 : 0);
    if (size < 0) {
      const std::lock_guard lock(thread.mutex);
      is_unplugged = true;
      return false;
    }
    if (size == 0) break;

    const std::int64_t came = deviceClock();
    const std::span<const std::uint8_t> report(bytes.data(), static_cast<std::size_t>(size));
    thread.tell(came, report);
    const FrameFault fault = what.driver->arm->take(report, newest.frame);
    const std::lock_guard lock(thread.mutex);
    ArmCounts& counts = thread.counts;
    if (fault != FrameFault::kNone) {
      ++counts.refused;
      counts.last_fault = nameOf(fault);
      continue;
    }
    ++counts.hands;
    counts.newest_came_ns = came;
    newest.came_ns = came;
    has_news = true;
  }
  if (has_news) arm->publish(newest);
  return true;
}

void HidArm::State::answer(std::int64_t when) {
  const ForceFrame next = arm->link_.answer(newest, when);
  const bool is_news = next.hand_number != last.hand_number || next.is_enabled != last.is_enabled ||
                       next.force != last.force || next.torque != last.torque;
  if (!is_news && when - last_sent < kReportAgain) return;
  last = next;
  last_sent = when;
  const bool is_taken = write(next);
  const std::lock_guard lock(thread.mutex);
  thread.counts.forces += is_taken;
  thread.counts.is_enabled = is_taken && next.is_enabled;
  is_stuck = !is_taken;
}

bool HidArm::State::write(const ForceFrame& force) {
  ArmReportBytes bytes{};
  return port->write({bytes.data(), what.driver->arm->write(force, bytes)});
}

HidArm::HidArm(const ArmSettings& settings, const Rigid3& start, std::unique_ptr<State> state)
    : ForceArm(settings, start), state_(std::move(state)) {
  state_->arm = this;
}
HidArm::~HidArm() { state_->thread.stop(); }

Expected<std::unique_ptr<HidArm>> HidArm::open(const FoundDevice& found, const ArmSettings& settings,
                                               const Rigid3& start, ArmListener listener) {
  KERF_TRY(port, HidPort::open(found.path()));
  std::unique_ptr<HidArm> arm(new HidArm(settings, start, std::make_unique<State>(found, std::move(port))));
  State& s = *arm->state_;
  s.thread.listener = std::move(listener);
  KERF_CHECK(s.thread.start([&s] { s.exchange(); }, found.path(), ""));
  return arm;
}

std::string HidArm::what() const { return fmt::format("{}, {}", state_->what.name, state_->what.path()); }

ArmCounts HidArm::counts() const {
  ArmCounts out = state_->thread.told();
  const std::lock_guard lock(state_->thread.mutex);
  out.is_talking = out.is_talking && !state_->is_unplugged;
  if (state_->is_unplugged)
    out.trouble = "unplugged: plug it in";
  else if (state_->is_stuck)
    out.trouble = "it accepts no report: unplug it and plug it in again";
  else if (!out.is_talking)
    out.trouble = "no data: switch it on; another program may be using it";
  return out;
}

bool HidArm::isGone() const {
  const std::lock_guard lock(state_->thread.mutex);
  return state_->is_unplugged;
}

}  // namespace kerf
