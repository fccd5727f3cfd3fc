// A simulated force-feedback arm behind a bridge of its own: mass, damping, friction, encoder and delay of a
// DeviceHand, held by a hand that follows a path, over the same datagrams as a real one.
//
// The age of a force counts by the system's time stamps of the frames, not by the time of this thread, which may be
// late on a busy machine. A force that is too old by then is not applied.
#pragma once

#include <memory>

#include "sim/device/frame/device_frame.h"
#include "sim/hand/virtual_hand.h"
#include "sim/live/time_histogram.h"

namespace kerf {

struct ArmOptions {
  std::uint16_t port = 0;  ///< of 127.0.0.1, where Kerf listens
  DeviceHand::Options hand{};
  double most_force = 8, most_stiffness = 1;  ///< N, N/mm: as reported
};

struct ArmReport {
  Vec3d position = Vec3d::Zero();  ///< true place, mm, device frame
  Vec3d force = Vec3d::Zero();     ///< N, at its motors now
  double most_force = 0;           ///< N, since the beginning
  double port_energy = 0;          ///< N mm: DeviceHand::portEnergy()
  double most_energy = 0;          ///< the most of it so far
  std::uint64_t ticks = 0, force_frames = 0;
  std::uint64_t forceless = 0;  ///< times its dead-man took the force away
  double worst_age_ms = 0;      ///< from a hand frame to the force that answers it
  /// When a force last ended, by the frames' stamps: a disabled frame came, or the deadline passed. deviceClock(), ns.
  /// 0: none has ended.
  std::int64_t stopped_ns = 0;
  bool is_enabled = false, is_over = false;
};

/// Runs in a thread of its own, each millisecond, until the path is over; then it stays where it is.
class ArmSimulator {
 public:
  /// Error kUnreadable: no socket; kBadValue: no thread.
  static Expected<std::unique_ptr<ArmSimulator>> start(CutPath path, const ArmOptions& options);
  ~ArmSimulator();
  ArmReport report() const;
  /// Ages of the forces on arrival, as worst_age_ms; and the deviation of two successive arrivals from 1 ms. Of enabled
  /// forces.
  TimeHistogram ages() const;
  TimeHistogram jitter() const;
  /// Its bridge hangs: it sends and hears nothing, but the arm goes on, and its dead-man watches.
  void hang(bool is_hanging) noexcept;
  /// The next frame has a place that is not finite.
  void sendNan() noexcept;

 private:
  struct State;
  explicit ArmSimulator(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
