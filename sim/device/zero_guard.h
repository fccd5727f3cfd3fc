// Takes the force of a device away when this program is killed, where the firmware would go on with the last one.
//
//   this process ──socket──▶ kerf-zero-guard ──zero report(s)──▶ device
//
// A small process of its own keeps the device's node open and waits at the socket, whose other end only this process
// holds. However this process ends, by kill -9 or a crash, the system closes that end, and the guard writes the
// reports; so it does when this process lets it go without release(). It is started by posix_spawn(), never by fork():
// pages that are shared after a fork would stop the 1 kHz thread. It stands in a session of its own and ignores INT,
// HUP, TERM and QUIT, so that what ends Kerf does not end it first.
//
// It knows nothing of a program that is stopped, or hangs, and still lives: the transport's dead-man is for that.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

class ZeroGuard {
 public:
  using Report = std::vector<std::uint8_t>;

  /// Guards nothing.
  ZeroGuard() = default;
  /// @param path  node of the device, that this process has open.
  /// @param reports  what takes the force away, in this order, each by one write.
  /// Takes some ms: until the guard has opened the node. Not for the 1 kHz thread.
  /// Errors: kNotFound: its program is not installed; kUnreadable: it does not open the node; kBadValue: the system
  /// starts no process.
  static Expected<ZeroGuard> start(const std::string& path, std::span<const Report> reports);
  ZeroGuard(ZeroGuard&& other) noexcept;
  ZeroGuard& operator=(ZeroGuard&& other) noexcept;
  /// Lets it write its reports, unless release() was called, and waits until it has ended: a second at most, then it
  /// goes on by itself.
  ~ZeroGuard();

  /// Ends it without a write. Only once the device has accepted a report that takes its force away, or was never given
  /// any. Waits until it has ended.
  void release() noexcept;

  /// It was started, and has not ended. What has no guard any more is to be given no force. A call of the system, about
  /// a microsecond. Any thread.
  bool isThere() const noexcept;

 private:
  void end() noexcept;  // waits for it
  int socket_ = -1;
  int process_ = -1;
};

}  // namespace kerf
