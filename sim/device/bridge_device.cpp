#include "sim/device/bridge_device.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <mutex>
#include <system_error>
#include <thread>

#include "sim/device/device_driver.h"
#include "sim/hand/triple_buffer.h"

namespace kerf {
namespace {

constexpr std::int64_t kMs = 1'000'000;  // ns
constexpr std::int64_t kDeadManNs = 20 * kMs;
static_assert(kDeadManNs == static_cast<std::int64_t>(1e9 * BridgeDevice::kDeadMan));
constexpr std::int64_t kPeerGone = 1000 * kMs;  // then another sender may talk
constexpr std::int64_t kSendAgain = 5 * kMs;    // when there is nothing new to say
constexpr double kJump = 5;                     // mm from frame to frame: no hand, a device that was set anew
constexpr std::uint32_t kPedal = 1, kClutch = 2;

struct Stamped {
  HandFrame frame;
  std::int64_t came_ns = 0;  // 0: none yet
};

struct Wish {
  Vec3d force = Vec3d::Zero(), torque = Vec3d::Zero();  // device frame
  bool is_enabled = false;
  std::int64_t written_ns = 0;
  std::uint64_t hand_number = 0, hand_time_ns = 0;
};

bool isSame(const sockaddr_in& a, const sockaddr_in& b) {
  return a.sin_addr.s_addr == b.sin_addr.s_addr && a.sin_port == b.sin_port;
}

tl::unexpected<Error> systemError(const char* place, std::string hint) {
  return fail({.code = Error::Code::kUnreadable,
               .place = place,
               .found = std::strerror(errno),
               .expected = "a port of 127.0.0.1 of its own",
               .hint = std::move(hint)});
}

}  // namespace

Expected<std::uint16_t> parseBridgeAddress(const std::string& text) {
  const auto refuse = [&] {
    return fail({.code = Error::Code::kBadValue,
                 .place = "address of the bridge",
                 .found = "\"" + text + "\"",
                 .expected = "udp:PORT on this machine: other hosts are refused",
                 .hint = "udp:4417"});
  };
  std::string_view rest = text;
  if (!rest.starts_with("udp:")) return refuse();
  rest.remove_prefix(4);
  for (const std::string_view host : {"localhost:", "127.0.0.1:"})
    if (rest.starts_with(host)) rest.remove_prefix(host.size());
  unsigned port = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), port);
  if (error != std::errc() || end != rest.data() + rest.size() || rest.empty() || port > 65535) return refuse();
  return static_cast<std::uint16_t>(port);
}

struct BridgeDevice::State {
  explicit State(const BridgeOptions& given) : options(given), guard(given.limits), map(given.map) {
    sample.T_world_device = given.start;
    sample.pedal = 0;
  }
  ~State() {
    if (socket >= 0) ::close(socket);
  }

  // The bridge's thread.
  void exchange();
  void receive();
  void take(std::span<const std::uint8_t> bytes, const sockaddr_in& from, std::int64_t now);
  void answer(std::int64_t now);
  void send(const ForceFrame& frame);
  void stop();

  // The haptic thread.
  bool isUsable(const Stamped& hand, std::int64_t now) const noexcept;

  const BridgeOptions options;
  int socket = -1;
  std::uint16_t port = 0;
  std::atomic<bool> is_stopping{false}, may_give_force{false};
  TripleBuffer<Stamped> hands;
  TripleBuffer<Wish> wishes;

  // The bridge's thread alone.
  sockaddr_in peer{};
  std::int64_t peer_came = 0, last_sent = 0, last_written = 0;
  Stamped newest;
  ForceFrame next;

  mutable std::mutex mutex;
  BridgeCounts counts;  // guarded by mutex, as the next
  Stamped told;

  // The haptic thread alone.
  ForceGuard guard;
  WorkspaceMap map;
  DeviceSample sample;
  HandFrame hand;  // of the last read()
  bool has_met = false, is_clutched = false, is_armed = false;

  std::thread thread;
};

// ---- The bridge's thread

void BridgeDevice::State::exchange() {
  while (!is_stopping.load(std::memory_order_acquire)) {
    pollfd waits{socket, POLLIN, 0};
    ::poll(&waits, 1, 1);
    receive();
    answer(deviceClock());
  }
  next.is_enabled = false;
  next.force.setZero();
  next.torque.setZero();
  for (int n = 0; n < 3; ++n) send(next);  // one may be lost
}

// All that waits; the newest is published.
void BridgeDevice::State::receive() {
  constexpr int kMost = 256;
  std::array<std::uint8_t, 512> bytes{};
  const std::uint64_t before = newest.frame.number;
  const std::int64_t came_before = newest.came_ns;
  for (int n = 0; n < kMost; ++n) {
    sockaddr_in from{};
    socklen_t length = sizeof from;
    const ssize_t size = ::recvfrom(socket, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_TRUNC,
                                    reinterpret_cast<sockaddr*>(&from), &length);
    if (size < 0) break;
    const std::size_t kept = std::min(static_cast<std::size_t>(size), bytes.size());
    take({bytes.data(), kept}, from, deviceClock());
  }
  if (newest.frame.number == before && newest.came_ns == came_before) return;
  hands.back() = newest;
  hands.publish();
}

void BridgeDevice::State::take(std::span<const std::uint8_t> bytes, const sockaddr_in& from, std::int64_t now) {
  HandFrame frame;
  const FrameFault fault = decode(bytes, frame);
  const std::lock_guard lock(mutex);
  if (fault != FrameFault::kNone) {
    ++counts.refused;
    counts.last_fault = fault;
    return;
  }
  const bool is_free = peer_came == 0 || now - peer_came > kPeerGone;
  if (!is_free && !isSame(from, peer)) {
    ++counts.others;
    return;
  }
  if (!is_free && frame.number <= newest.frame.number) {
    ++counts.old;
    return;
  }
  peer = from;
  peer_came = now;
  newest = {frame, now};
  told = newest;
  ++counts.hand_frames;
}

// What the haptic thread wrote last, as long as it is news; zero after that.
void BridgeDevice::State::answer(std::int64_t now) {
  if (peer_came == 0) return;
  wishes.update();
  const Wish& wish = wishes.front();
  const bool is_alive = wish.written_ns != 0 && now - wish.written_ns <= kDeadManNs;
  const bool is_enabled = is_alive && wish.is_enabled && may_give_force.load(std::memory_order_acquire) &&
                          newest.frame.is_ready && now - newest.came_ns <= kDeadManNs;
  const bool is_news = wish.written_ns != last_written || is_enabled != next.is_enabled;
  if (!is_news && now - last_sent < kSendAgain) return;

  last_written = wish.written_ns;
  next.hand_number = wish.hand_number;
  next.hand_time_ns = wish.hand_time_ns;
  next.is_enabled = is_enabled;
  next.force = is_enabled ? wish.force : Vec3d::Zero();
  next.torque = is_enabled ? wish.torque : Vec3d::Zero();
  send(next);
  last_sent = now;
}

void BridgeDevice::State::send(const ForceFrame& frame) {
  if (peer_came == 0) return;
  ++next.number;
  ForceFrame out = frame;
  out.number = next.number;
  const auto bytes = encode(out);
  const ssize_t sent = ::sendto(socket, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                                reinterpret_cast<const sockaddr*>(&peer), sizeof peer);
  const std::lock_guard lock(mutex);
  counts.force_frames += sent > 0;
  counts.is_enabled = out.is_enabled;
}

void BridgeDevice::State::stop() {
  is_stopping.store(true, std::memory_order_release);
  if (thread.joinable()) thread.join();
}

// ---- Opening

BridgeDevice::BridgeDevice(std::unique_ptr<State> state) : state_(std::move(state)) {}
BridgeDevice::~BridgeDevice() { state_->stop(); }

Expected<std::unique_ptr<BridgeDevice>> BridgeDevice::open(const BridgeOptions& options) {
  auto state = std::make_unique<State>(options);
  State& s = *state;
  s.socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (s.socket < 0) return systemError("opening a socket", "raise the limit nofile");
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  here.sin_port = htons(options.port);
  if (::bind(s.socket, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0)
    return systemError("binding the port of the bridge", "end the other program, or choose another port");
  socklen_t length = sizeof here;
  if (::getsockname(s.socket, reinterpret_cast<sockaddr*>(&here), &length) != 0)
    return systemError("asking for the port of the bridge", "");
  s.port = ntohs(here.sin_port);

  std::unique_ptr<BridgeDevice> device(new BridgeDevice(std::move(state)));
  try {
    s.thread = std::thread([&s] { s.exchange(); });
  } catch (const std::system_error& e) {
    return fail({.code = Error::Code::kBadValue,
                 .place = "the bridge",
                 .found = e.what(),
                 .expected = "a thread",
                 .hint = "close other programs, or raise the limit nproc"});
  }
  return device;
}

std::uint16_t BridgeDevice::port() const noexcept { return state_->port; }
void BridgeDevice::enable(bool may_give_force) noexcept {
  state_->may_give_force.store(may_give_force, std::memory_order_release);
}

BridgeCounts BridgeDevice::counts() const {
  const std::lock_guard lock(state_->mutex);
  BridgeCounts out = state_->counts;
  out.is_talking = state_->told.came_ns != 0 && deviceClock() - state_->told.came_ns <= kDeadManNs;
  return out;
}

bool BridgeDevice::lastHand(HandFrame& out) const {
  const std::lock_guard lock(state_->mutex);
  if (state_->told.came_ns == 0) return false;
  out = state_->told.frame;
  return true;
}

// ---- The haptic thread

bool BridgeDevice::State::isUsable(const Stamped& now_hand, std::int64_t now) const noexcept {
  return is_armed && now_hand.came_ns != 0 && now - now_hand.came_ns <= kDeadManNs && now_hand.frame.is_ready;
}

void BridgeDevice::arm() noexcept { state_->is_armed = true; }

DeviceSample BridgeDevice::read() noexcept {
  State& s = *state_;
  s.hands.update();
  const Stamped& newest = s.hands.front();
  if (!s.isUsable(newest, deviceClock())) {
    s.guard.disarm();
    s.has_met = false;
    s.sample.is_valid = 0;
    s.sample.pedal = 0;
    return s.sample;
  }

  // A hand that has just come, one that leapt, one that holds the clutch: it takes the tool where the tool is.
  const bool has_leapt = s.has_met && (newest.frame.pose.translation - s.hand.pose.translation).norm() > kJump;
  const bool is_clutched = newest.frame.buttons & kClutch;
  s.hand = newest.frame;
  if (!s.hand.senses_orientation) s.hand.pose.rotation.setIdentity();
  if (!s.has_met || has_leapt || is_clutched || s.is_clutched) s.map.meet(s.hand.pose, s.sample.T_world_device);
  if (has_leapt || is_clutched) s.guard.disarm();
  s.has_met = true;
  s.is_clutched = is_clutched;

  ForceLimits limits = s.options.limits;
  limits.force = std::min(limits.force, s.hand.most_force);
  s.guard.limit(limits);
  if (!s.may_give_force.load(std::memory_order_acquire)) {
    s.guard.disarm();
    s.guard.forgetFault();
  } else if (!is_clutched && !has_leapt && !s.guard.hasFault()) {
    s.guard.arm();
  }

  s.sample.is_valid = 1;
  s.sample.T_world_device = s.map.toWorld(s.hand.pose);
  s.sample.pedal = s.options.pedal_is_down || (s.hand.buttons & kPedal) ? 1 : 0;
  return s.sample;
}

void BridgeDevice::write(const DeviceForce& force) noexcept {
  State& s = *state_;
  Wish& wish = s.wishes.back();
  wish.force = s.guard.pass(s.map.toDevice(force.force), kTick);
  wish.torque = Vec3d::Zero();
  wish.is_enabled = s.guard.isArmed();
  wish.written_ns = deviceClock();
  wish.hand_number = s.hand.number;
  wish.hand_time_ns = s.hand.time_ns;
  s.wishes.publish();
}

void BridgeDevice::placed(const Rigid3& T_world_tool) noexcept {
  state_->sample.T_world_device = T_world_tool;
  state_->has_met = false;
  state_->guard.disarm();
}

void BridgeDevice::disarm() noexcept {
  state_->is_armed = false;
  state_->guard.disarm();
  write({});
}

}  // namespace kerf
