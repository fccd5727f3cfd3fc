// A simulated Haply service: the part of its protocol that bridges/haply.cpp needs, with the mass, damping, friction,
// encoder and delay of a DeviceHand, held by a hand that follows a path.
#pragma once

#include <memory>

#include "bridges/simulated/arm_simulator.h"
#include "geometry/base/error.h"
#include "sim/hand/virtual_hand.h"

namespace kerf::test {

struct HaplyOptions {
  std::uint16_t port = 10001;  ///< of 127.0.0.1; 0: chosen by the system
  CutPath path{};              ///< of the hand; empty: at rest
  DeviceHand::Options hand{};
};

/// One client at a time. A force expires after 10 ms.
class HaplySimulator {
 public:
  /// Error kUnreadable: the port is taken; kBadValue: no thread.
  static Expected<std::unique_ptr<HaplySimulator>> start(HaplyOptions options);
  ~HaplySimulator();
  std::uint16_t port() const noexcept;
  /// force_frames: received commands.
  ArmReport report() const;
  /// While hanging, the service sends no answers.
  void hang(bool is_hanging) noexcept;

 private:
  struct State;
  explicit HaplySimulator(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf::test
