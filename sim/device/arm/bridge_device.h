// A force-feedback device behind a bridge: datagrams over loopback; without news both ends give no force. Off unless a
// program makes one. It binds 127.0.0.1 alone, so nothing from another machine reaches it. Use of hand and force:
// force_arm.h.
//
//   bridge ──hand frame──▶ ┌────────┐ ──newest──▶ ForceArm
//   bridge ◀─force frame── │ thread │ ◀─newest─── ForceArm
//
// One thread for both ways: a datagram to loopback never waits. A late force is worse than a lost one, so neither is
// sent again.
#pragma once

#include <memory>
#include <string>

#include "sim/device/arm/force_arm.h"

namespace kerf {

struct BridgeOptions {
  std::uint16_t port = 0;  ///< of 127.0.0.1; 0: the system chooses, see BridgeDevice::port()
  ForceLimits limits{};    ///< as in ArmSettings, like the next and the last
  WorkspaceMap map{};
  Rigid3 start{};  ///< pose of the tool, world, where the hand begins
  bool pedal_is_down = false;
};

/// "udp:PORT", "udp:localhost:PORT", "udp:127.0.0.1:PORT": the port. Error kBadValue: anything else, also other hosts.
Expected<std::uint16_t> parseBridgeAddress(const std::string& text);

class BridgeDevice final : public ForceArm {
 public:
  /// Errors: kUnreadable: the port is taken; kBadValue: no thread.
  /// @param listener  not called for datagrams that are too old or from another sender.
  static Expected<std::unique_ptr<BridgeDevice>> open(const BridgeOptions& options, ArmListener listener = {});
  /// Sends zero force, not enabled.
  ~BridgeDevice() override;

  std::uint16_t port() const noexcept;
  std::string what() const override;
  ArmCounts counts() const override;

 private:
  struct State;
  BridgeDevice(const BridgeOptions& options, std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
