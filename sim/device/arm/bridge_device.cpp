#include "sim/device/arm/bridge_device.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <mutex>

#include "sim/device/arm/arm_thread.h"
#include "sim/device/hid/device_driver.h"

namespace kerf {
namespace {

constexpr std::int64_t kMs = 1'000'000;         // ns
constexpr std::int64_t kPeerGone = 1000 * kMs;  // then another sender may talk
constexpr std::int64_t kSendAgain = 5 * kMs;    // between frames without news

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
                 .expected = "udp:PORT on this machine: Kerf rejects other hosts",
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
  ~State() {
    if (socket >= 0) ::close(socket);
  }

  // The bridge's thread.
  void exchange();
  void receive();
  void take(std::span<const std::uint8_t> bytes, const sockaddr_in& from, std::int64_t now);
  void answer(std::int64_t now);
  void send(const ForceFrame& frame);

  BridgeDevice* device = nullptr;
  int socket = -1;
  std::uint16_t port = 0;

  // The bridge's thread alone.
  sockaddr_in peer{};
  std::int64_t peer_came = 0, last_sent = 0;
  std::uint64_t number = 0;  // of the last force frame
  ArmLink::Hand newest;
  ForceFrame last;

  internal::ArmThread thread;
};

// ---- The bridge's thread

void BridgeDevice::State::exchange() {
  while (!thread.isStopping()) {
    pollfd waits{socket, POLLIN, 0};
    ::poll(&waits, 1, 1);
    receive();
    answer(deviceClock());
  }
  last.is_enabled = false;
  last.force.setZero();
  last.torque.setZero();
  for (int n = 0; n < 3; ++n) send(last);  // one may be lost
}

// Drains all datagrams and publishes the newest.
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
  device->publish(newest);
}

void BridgeDevice::State::take(std::span<const std::uint8_t> bytes, const sockaddr_in& from, std::int64_t now) {
  HandFrame frame;
  const FrameFault fault = decode(bytes, frame);
  const bool is_free = peer_came == 0 || now - peer_came > kPeerGone;
  const bool is_other = !is_free && !isSame(from, peer);
  const bool is_old = !is_free && frame.number <= newest.frame.number;
  if (fault != FrameFault::kNone || (!is_other && !is_old)) thread.tell(now, bytes);

  const std::lock_guard lock(thread.mutex);
  ArmCounts& counts = thread.counts;
  if (fault != FrameFault::kNone) {
    ++counts.refused;
    counts.last_fault = nameOf(fault);
    return;
  }
  if (is_other) {
    ++counts.others;
    return;
  }
  if (is_old) {
    ++counts.old;
    return;
  }
  peer = from;
  peer_came = now;
  newest = {frame, now};
  counts.newest_came_ns = now;
  ++counts.hands;
}

void BridgeDevice::State::answer(std::int64_t now) {
  if (peer_came == 0) return;
  const ForceFrame next = device->link_.answer(newest, now);
  const bool is_news = next.hand_number != last.hand_number || next.is_enabled != last.is_enabled ||
                       next.force != last.force || next.torque != last.torque;
  if (!is_news && now - last_sent < kSendAgain) return;
  last = next;
  send(next);
  last_sent = now;
}

void BridgeDevice::State::send(const ForceFrame& frame) {
  if (peer_came == 0) return;
  ForceFrame out = frame;
  out.number = ++number;
  const auto bytes = encode(out);
  const ssize_t sent = ::sendto(socket, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                                reinterpret_cast<const sockaddr*>(&peer), sizeof peer);
  const std::lock_guard lock(thread.mutex);
  thread.counts.forces += sent > 0;
  thread.counts.is_enabled = out.is_enabled;
}

// ---- Opening

BridgeDevice::BridgeDevice(const BridgeOptions& options, std::unique_ptr<State> state)
    : ForceArm({options.limits, options.map, options.pedal_is_down}, options.start), state_(std::move(state)) {
  state_->device = this;
}
BridgeDevice::~BridgeDevice() { state_->thread.stop(); }

Expected<std::unique_ptr<BridgeDevice>> BridgeDevice::open(const BridgeOptions& options, ArmListener listener) {
  auto state = std::make_unique<State>();
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

  std::unique_ptr<BridgeDevice> device(new BridgeDevice(options, std::move(state)));
  s.thread.listener = std::move(listener);
  KERF_CHECK(s.thread.start([&s] { s.exchange(); }, "", "the bridge"));
  return device;
}

std::uint16_t BridgeDevice::port() const noexcept { return state_->port; }
std::string BridgeDevice::what() const { return fmt::format("bridge, port {} of this machine", state_->port); }

ArmCounts BridgeDevice::counts() const {
  ArmCounts out = state_->thread.told();
  if (out.newest_came_ns == 0)
    out.trouble = fmt::format("no bridge sends to port {} yet: start it", state_->port);
  else if (!out.is_talking)
    out.trouble = "no data from the bridge: start it again";
  return out;
}

}  // namespace kerf
