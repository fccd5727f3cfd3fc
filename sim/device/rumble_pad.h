// The two motors of a gamepad, which carry the vibration of the drill: DualSense, DualShock 4, Xbox by Bluetooth. Never
// tried on hardware: reports are those that Linux and SDL write. (An Xbox pad on a cable is no HID device on Linux.)
//
//   window ──newest wish──▶ thread ──report──▶ pad          at most 100 a second, and only what has changed
//
// A pad goes on shaking until it is told otherwise: a wish older than kStale is zero, and so is the end. When Kerf is
// killed, or the pad does not take the end from here, a guard (zero_guard.h) tells it; without one it does not shake.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/device/hid_port.h"
#include "sim/device/pad_kind.h"

namespace kerf {

struct Rumble {
  double strong = 0, weak = 0;  ///< 0 to 1: the slow heavy motor, the fast light one
  bool operator==(const Rumble&) const = default;
};

/// The report that makes it shake so, its number first.
/// @param number  of the report, counts up: some pads want it.
std::vector<std::uint8_t> rumbleReport(PadKind kind, const Rumble& rumble, std::uint8_t number);
/// As Sony's pads check a report that comes by Bluetooth: CRC-32 over 0xA2 and the bytes.
std::uint32_t padChecksum(std::span<const std::uint8_t> bytes);

/// An open pad with a thread that writes.
class RumblePad {
 public:
  static constexpr double kStale = 0.2;  ///< s

  /// @param vendor, product  of the pad that is in use.   Errors: kUnsupported: none that is known to shake; kBadValue:
  /// several alike; those of HidPort::open() and ZeroGuard::start().
  static Expected<std::unique_ptr<RumblePad>> open(std::uint16_t vendor, std::uint16_t product);
  static Expected<std::unique_ptr<RumblePad>> open(const HidInfo& info, PadKind kind);
  /// Stands still.
  ~RumblePad();
  RumblePad(const RumblePad&) = delete;
  RumblePad& operator=(const RumblePad&) = delete;

  PadKind kind() const noexcept;
  /// The newest wish; to be repeated. Any one thread. Never waits.
  void set(const Rumble& rumble) noexcept;
  /// False: it was unplugged, or takes no report.
  bool isConnected() const noexcept;
  /// False: its guard has ended, and it does not shake any more. Any thread.
  bool isGuarded() const noexcept;

 private:
  struct State;
  explicit RumblePad(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
