// An open HID device: a thread that reads, one that writes, and the newest reading.
//
//   interfaces ──reports──▶ reader ──newest reading──▶ update(), reading()
//   interfaces ◀───────────  writer ◀──newest wish──── light()
//
// Two threads, since a write to a device in trouble may take a second, and its reports must not wait for that. Reports
// are drained to the newest: the system keeps 64, so reading one a frame would lag by seconds.
#pragma once

#include <functional>
#include <memory>

#include "sim/device/hid/device_finder.h"

namespace kerf {

class HidDevice {
 public:
  /// The reader's thread calls it with each report, before taking it.
  using Listener = std::function<void(std::int64_t time_ns, int interface, std::span<const std::uint8_t> report)>;

  /// Opens all interfaces, lights the device and starts the threads. On a receiver with several interfaces the moving
  /// one counts; another one takes its place when it moves and the first has been silent for kSilence.
  /// Errors: those of HidPort::open().   @pre  found.driver->axes
  static Expected<std::unique_ptr<HidDevice>> open(const FoundDevice& found, Listener listener = {});
  /// Puts the light out.
  ~HidDevice();
  HidDevice(const HidDevice&) = delete;
  HidDevice& operator=(const HidDevice&) = delete;

  const FoundDevice& what() const noexcept;
  /// False: unplugged for good; its axes are at rest. Any thread. @rt safe
  bool isConnected() const noexcept;
  /// Fetches the newest reading; false: none since the last call. For one thread. @rt safe
  bool update() noexcept;
  const DeviceReading& reading() const noexcept;
  /// The current axes, axesAt(); zero once unplugged. The same thread. @rt safe
  std::array<double, 6> axes() noexcept;
  /// Any thread but the 1 kHz one; the newest wish counts.
  void light(bool is_lit);

 private:
  struct State;
  explicit HidDevice(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
