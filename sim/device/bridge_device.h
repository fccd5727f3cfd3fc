// A force-feedback device behind a bridge, as the device of the haptic thread: datagrams over loopback, at both ends
// no force without news. Off unless a program makes one; it binds 127.0.0.1 alone, so nothing from another machine
// reaches it.
//
//   bridge ──hand frame──▶ ┌────────┐ ──newest──▶ read()    haptic thread
//   bridge ◀─force frame── │ thread │ ◀─newest─── write()
//
// One thread for both ways: a datagram to loopback never waits. A late force is worse than a lost one, so neither is
// sent again.
//
// Force reaches the device only if all of it holds: enable(true) was called; the haptic thread runs (arm()); the newest
// hand frame is less than kDeadMan old and says that the device is ready; the haptic thread wrote less than kDeadMan
// ago; no force was other than finite. When it begins to hold the force fades in. When it ends to hold the very next
// frame, a millisecond later, says zero and not enabled.
//
// Buttons: 1 is the pedal; while 2 is held the tool stays where it is and the hand moves on (clutch), without force.
#pragma once

#include <memory>
#include <string>

#include "sim/device/device_frame.h"
#include "sim/device/force_guard.h"
#include "sim/device/workspace_map.h"
#include "sim/hand/device_source.h"

namespace kerf {

struct BridgeOptions {
  std::uint16_t port = 0;      ///< of 127.0.0.1; 0: the system chooses, see BridgeDevice::port()
  ForceLimits limits{};        ///< beside what the device says it can
  WorkspaceMap map{};          ///< turn and scale; the offset is met when the hand first appears
  Rigid3 start{};              ///< of the tool, world: there the hand finds it
  bool pedal_is_down = false;  ///< without button 1
};

/// "udp:PORT", "udp:localhost:PORT", "udp:127.0.0.1:PORT": the port. Error kBadValue: anything else; other hosts are
/// refused.
Expected<std::uint16_t> parseBridgeAddress(const std::string& text);

/// Since it was opened.
struct BridgeCounts {
  std::uint64_t hand_frames = 0;  ///< that were taken
  std::uint64_t refused = 0;      ///< malformed; nothing of them is used
  FrameFault last_fault = FrameFault::kNone;
  std::uint64_t old = 0;           ///< that came after a newer one
  std::uint64_t others = 0;        ///< from another sender while the first one talks
  std::uint64_t force_frames = 0;  ///< sent
  bool is_talking = false;         ///< the newest hand frame is less than kDeadMan old
  bool is_enabled = false;         ///< the last force frame said so
};

class BridgeDevice final : public DeviceSource {
 public:
  static constexpr double kDeadMan = 0.02;  ///< s

  /// Errors: kUnreadable: the port is taken; kBadValue: no thread.
  static Expected<std::unique_ptr<BridgeDevice>> open(const BridgeOptions& options);
  /// Says zero and not enabled.
  ~BridgeDevice() override;

  std::uint16_t port() const noexcept;
  /// Whether it may give force; at first not. After a force that was not finite: off, then on again. Any thread.
  void enable(bool may_give_force) noexcept;
  /// Any thread.
  BridgeCounts counts() const;
  /// What the device said of itself last; for the thread that calls counts(). False: nothing yet.
  bool lastHand(HandFrame& out) const;

  void arm() noexcept override;
  DeviceSample read() noexcept override;
  void write(const DeviceForce& force) noexcept override;
  void placed(const Rigid3& T_world_tool) noexcept override;
  void disarm() noexcept override;

 private:
  struct State;
  explicit BridgeDevice(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
