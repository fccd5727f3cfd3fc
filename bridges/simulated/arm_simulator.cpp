#include "bridges/simulated/arm_simulator.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <mutex>
#include <system_error>
#include <thread>

#include "sim/device/hid/device_driver.h"

namespace kerf {
namespace {

constexpr std::int64_t kPeriod = 1'000'000;  // ns

void sleepTo(std::int64_t when) {
  const timespec until{when / 1'000'000'000, when % 1'000'000'000};
  ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

std::int64_t nanoseconds(const timespec& t) { return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec; }

// A datagram and its arrival, deviceClock(); from the system's stamp, which uses the other clock.
struct Datagram {
  std::array<std::uint8_t, 256> bytes{};
  std::size_t size = 0;
  std::int64_t came_ns = 0;
};
bool receive(int socket, Datagram& out) {
  alignas(cmsghdr) std::array<char, 128> control{};
  iovec part{out.bytes.data(), out.bytes.size()};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t size = ::recvmsg(socket, &message, MSG_DONTWAIT);
  if (size < 0) return false;
  out.size = static_cast<std::size_t>(size);
  out.came_ns = deviceClock();

  for (const cmsghdr* c = CMSG_FIRSTHDR(&message); c; c = CMSG_NXTHDR(&message, const_cast<cmsghdr*>(c))) {
    if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec stamp{}, now{};
    std::memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
    ::clock_gettime(CLOCK_REALTIME, &now);
    out.came_ns -= std::max(nanoseconds(now) - nanoseconds(stamp), std::int64_t{0});
  }
  return true;
}

}  // namespace

struct ArmSimulator::State {
  State(CutPath given, const ArmOptions& how) : path(std::move(given)), options(how), hand(path, how.hand) {}
  ~State() {
    if (socket >= 0) ::close(socket);
  }
  void run();
  void hear();
  void take(const Datagram& datagram);
  void endForce(std::int64_t when);
  void say(const DeviceSample& sample, std::int64_t now);

  const CutPath path;
  const ArmOptions options;
  DeviceHand hand;
  int socket = -1;
  std::atomic<bool> is_stopping{false}, is_hanging{false}, wants_nan{false};

  // Of the thread.
  HandFrame frame;
  ForceFrame newest;
  std::int64_t heard = 0;         // ns, the newest; 0: nothing yet
  std::int64_t force_until = 0;   // ns: its deadline; 0: no force
  std::int64_t enabled_came = 0;  // the last one that was enabled
  ArmReport now_report;

  mutable std::mutex mutex;
  ArmReport told;              // guarded by mutex, like the next
  TimeHistogram ages, jitter;  // of enabled forces
  std::thread thread;
};

void ArmSimulator::State::run() {
  frame.gives_torque = false;
  frame.most_force = options.most_force;
  frame.most_stiffness = options.most_stiffness;
  StepOutput last;
  DeviceSample sample;
  sample.T_world_device = poseAt(path, 0);
  for (std::int64_t due = deviceClock(); !is_stopping.load(std::memory_order_acquire); due += kPeriod) {
    sleepTo(due);
    const std::int64_t now = deviceClock();
    if (!is_hanging.load(std::memory_order_relaxed)) hear();

    // The dead-man of the bridge.
    if (force_until != 0 && now > force_until) {
      ++now_report.forceless;
      endForce(force_until);
    }
    now_report.is_enabled = force_until != 0;
    now_report.force = now_report.is_enabled ? newest.force : Vec3d(Vec3d::Zero());
    now_report.most_force = std::max(now_report.most_force, now_report.force.norm());

    last.force.force = now_report.force;
    now_report.is_over = !hand.next(last, sample);
    if (!is_hanging.load(std::memory_order_relaxed)) say(sample, now);

    ++now_report.ticks;
    now_report.position = hand.position();
    now_report.port_energy = hand.portEnergy();
    now_report.most_energy = std::max(now_report.most_energy, now_report.port_energy);
    const std::lock_guard lock(mutex);
    told = now_report;
  }
}

void ArmSimulator::State::hear() {
  for (Datagram next; receive(socket, next);) take(next);
}

void ArmSimulator::State::endForce(std::int64_t when) {
  now_report.stopped_ns = when;
  force_until = 0;
}

void ArmSimulator::State::take(const Datagram& datagram) {
  ForceFrame got;
  if (decode(std::span(datagram.bytes).first(datagram.size), got) != FrameFault::kNone) return;
  if (heard != 0 && got.number < newest.number && datagram.came_ns - heard < 1'000'000'000) return;
  newest = got;
  heard = datagram.came_ns;
  ++now_report.force_frames;
  if (force_until != 0 && heard > force_until) endForce(force_until);
  if (force_until != 0 && !got.is_enabled) endForce(heard);
  if (got.is_enabled) force_until = heard + 1'000'000 * std::int64_t{got.deadline_ms};
  if (!got.is_enabled || got.hand_time_ns == 0) {
    enabled_came = 0;
    return;
  }

  const std::int64_t came = deviceClock();
  const std::int64_t age = came - static_cast<std::int64_t>(got.hand_time_ns);
  const std::lock_guard lock(mutex);
  now_report.worst_age_ms = std::max(now_report.worst_age_ms, 1e-6 * static_cast<double>(age));
  ages.add(age);
  if (enabled_came != 0) jitter.add(std::abs(came - enabled_came - kPeriod));
  enabled_came = came;
}

void ArmSimulator::State::say(const DeviceSample& sample, std::int64_t now) {
  ++frame.number;
  frame.time_ns = static_cast<std::uint64_t>(now);
  frame.velocity = (sample.T_world_device.translation - frame.pose.translation) / kTick;
  frame.pose = sample.T_world_device;
  frame.buttons = sample.pedal > 0 ? 1 : 0;
  HandFrame out = frame;
  if (wants_nan.exchange(false)) out.pose.translation[1] = std::numeric_limits<double>::quiet_NaN();
  const auto bytes = encode(out);
  ::send(socket, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

ArmSimulator::ArmSimulator(std::unique_ptr<State> state) : state_(std::move(state)) {}
ArmSimulator::~ArmSimulator() {
  state_->is_stopping.store(true, std::memory_order_release);
  if (state_->thread.joinable()) state_->thread.join();
}

Expected<std::unique_ptr<ArmSimulator>> ArmSimulator::start(CutPath path, const ArmOptions& options) {
  auto state = std::make_unique<State>(std::move(path), options);
  State& s = *state;
  s.socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  constexpr int kOn = 1;
  if (s.socket >= 0) ::setsockopt(s.socket, SOL_SOCKET, SO_TIMESTAMPNS, &kOn, sizeof kOn);
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  there.sin_port = htons(options.port);
  if (s.socket < 0 || ::connect(s.socket, reinterpret_cast<const sockaddr*>(&there), sizeof there) != 0)
    return fail({.code = Error::Code::kUnreadable,
                 .place = "the socket of the simulated arm",
                 .found = std::strerror(errno),
                 .expected = "a datagram socket to 127.0.0.1"});
  std::unique_ptr<ArmSimulator> arm(new ArmSimulator(std::move(state)));
  try {
    s.thread = std::thread([&s] { s.run(); });
  } catch (const std::system_error& e) {
    return fail(
        {.code = Error::Code::kBadValue, .place = "the simulated arm", .found = e.what(), .expected = "a thread"});
  }
  return arm;
}

ArmReport ArmSimulator::report() const {
  const std::lock_guard lock(state_->mutex);
  return state_->told;
}
TimeHistogram ArmSimulator::ages() const {
  const std::lock_guard lock(state_->mutex);
  return state_->ages;
}
TimeHistogram ArmSimulator::jitter() const {
  const std::lock_guard lock(state_->mutex);
  return state_->jitter;
}
void ArmSimulator::hang(bool is_hanging) noexcept { state_->is_hanging = is_hanging; }
void ArmSimulator::sendNan() noexcept { state_->wants_nan = true; }

}  // namespace kerf
