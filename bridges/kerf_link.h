// The side of Kerf for a bridge: datagrams of docs/reference/device-bridge.md, version 1, in SI units and the device's
// frame. For a little-endian machine. It includes nothing of Kerf, so a bridge of your own can copy it from the source
// tree; it is not installed.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstring>

namespace bridge {

using Vec3 = std::array<double, 3>;

/// CLOCK_MONOTONIC, ns.
inline std::int64_t clockNow() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// State of the device.
struct Hand {
  Vec3 position{};                                ///< of the tip, m
  std::array<double, 4> orientation{0, 0, 0, 1};  ///< x y z w
  std::uint32_t buttons = 0;                      ///< bit 0 the pedal, bit 1 the clutch
  bool is_ready = true;                           ///< switched on and calibrated
  bool senses_orientation = false;
  float most_force = 3, most_stiffness = 1000;  ///< N, N/m
};

class KerfLink {
 public:
  static constexpr std::int64_t kDeadMan = 20'000'000;  ///< ns

  KerfLink() = default;
  ~KerfLink() {
    if (socket_ >= 0) ::close(socket_);
  }
  KerfLink(const KerfLink&) = delete;
  KerfLink& operator=(const KerfLink&) = delete;

  /// @param port  of 127.0.0.1, where Kerf listens now or later.   @return  false: no socket; errno.
  bool open(std::uint16_t port) {
    sockaddr_in kerf{};
    kerf.sin_family = AF_INET;
    kerf.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    kerf.sin_port = htons(port);
    socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    return socket_ >= 0 && ::connect(socket_, reinterpret_cast<const sockaddr*>(&kerf), sizeof kerf) == 0;
  }

  /// Sends the hand. A lost or unreceived datagram is no error.
  void say(const Hand& hand) {
    HandFrame frame;
    frame.number = ++number_;
    frame.time_ns = static_cast<std::uint64_t>(clockNow());
    std::copy(hand.position.begin(), hand.position.end(), frame.position);
    std::copy(hand.orientation.begin(), hand.orientation.end(), frame.orientation);
    frame.buttons = hand.buttons;
    frame.flags = (hand.is_ready ? 1U : 0U) | (hand.senses_orientation ? 2U : 0U);
    frame.most_force = hand.most_force;
    frame.most_stiffness = hand.most_stiffness;
    (void)!::send(socket_, &frame, sizeof frame, MSG_DONTWAIT | MSG_NOSIGNAL);
  }

  /// The force on the hand now, N. Zero unless the newest frame is enabled, its deadline has not passed, and the hand
  /// that it answers is at most kDeadMan old: a frame may have waited while this program was stopped.
  Vec3 force() {
    const std::int64_t now = clockNow();
    ForceFrame next;
    for (;;) {
      const auto size = ::recv(socket_, &next, sizeof next, MSG_DONTWAIT | MSG_TRUNC);
      if (size < 0 && errno == ECONNREFUSED) continue;  // of an earlier say(): Kerf does not listen
      if (size < 0) break;
      if (size != sizeof next || !next.isGood() || next.hand_time_ns > static_cast<std::uint64_t>(now)) continue;
      if (!isNewer(next)) continue;
      newest_ = next;
      heard_ns_ = now;
    }
    const std::int64_t age = now - static_cast<std::int64_t>(newest_.hand_time_ns);
    const std::int64_t deadline = heard_ns_ + std::int64_t{1'000'000} * newest_.deadline_ms;
    if (newest_.enabled != 1 || now >= deadline || age < 0 || age >= kDeadMan) return {};
    return {newest_.force[0], newest_.force[1], newest_.force[2]};
  }

 private:
  struct HandFrame {
    char magic[4] = {'K', 'F', 'D', '1'};
    std::uint16_t version = 1, kind = 1;
    std::uint64_t number = 0, time_ns = 0;
    double position[3] = {}, orientation[4] = {}, velocity[3] = {}, angular[3] = {};
    std::uint32_t buttons = 0, flags = 0;
    float most_force = 0, most_torque = 0, most_stiffness = 0, reserved = 0;
  };
  struct ForceFrame {
    char magic[4] = {};
    std::uint16_t version = 0, kind = 0;
    std::uint64_t number = 0, hand_number = 0, hand_time_ns = 0;
    double force[3] = {}, torque[3] = {};
    std::uint32_t enabled = 0, deadline_ms = 0;

    bool isGood() const {
      return std::memcmp(magic, "KFD1", sizeof magic) == 0 && version == 1 && kind == 2 && std::isfinite(force[0]) &&
             std::isfinite(force[1]) && std::isfinite(force[2]);
    }
  };
  static_assert(sizeof(HandFrame) == 152 && sizeof(ForceFrame) == 88 && std::endian::native == std::endian::little);

  // By the hand that it answers: a Kerf that was started again counts from 1.
  bool isNewer(const ForceFrame& frame) const {
    if (frame.hand_time_ns != newest_.hand_time_ns) return frame.hand_time_ns > newest_.hand_time_ns;
    return frame.number > newest_.number;
  }

  int socket_ = -1;
  std::uint64_t number_ = 0;
  ForceFrame newest_;
  std::int64_t heard_ns_ = 0;
};

/// A port as a person gives it. @return  false: it is none.
inline bool parsePort(const char* text, std::uint16_t& out) {
  const char* const end = text + std::strlen(text);
  const auto [after, error] = std::from_chars(text, end, out);
  return error == std::errc() && after == end && out != 0;
}

/// Set by the signals that end a program: the bridge then writes zero force and ends.
inline volatile std::sig_atomic_t must_end = 0;
inline void endBySignals() {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) std::signal(number, [](int) { must_end = 1; });
  std::signal(SIGPIPE, SIG_IGN);
}

}  // namespace bridge
