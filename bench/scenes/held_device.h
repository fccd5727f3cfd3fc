// Model of a force-feedback device held in a hand: two masses, friction, a delay, encoder steps.
#pragma once

#include <cstdint>
#include <deque>

#include "sim/hand/device_profile.h"

namespace kerf::scenes {

/// A grip joins the device to the hand; an arm pulls the hand to its target. Units: mm, N, t (a tonne, 1000 kg), s; for
/// a turning device rad, N mm, t mm^2.
struct HeldDeviceNumbers {
  double mass = 8e-5, damping = 5e-4;  ///< of the device
  double friction = 0.02;              ///< Coulomb
  double step = 0.03;                  ///< of the encoder; 0: perfect
  double delay_s = 0.002;              ///< from sample to motor
  double hand_mass = 2e-4;
  double grip = 1, grip_damping = 0.003;                     ///< from device to hand
  double arm = 0.3, arm_damping = 0.003;                     ///< from hand to the arm's target
  Eigen::Quaterniond axes = Eigen::Quaterniond::Identity();  ///< of the encoder

  /// The driver's view of the device, for translation or turning.
  DeviceProfile profile() const;
  DeviceProfile turningProfile() const;
};

/// Random devices of 30 to 300 g, 0.1 to 2 N s/m, encoders of 5, 30 and 55 um, delays of 1 to 5 ms; hands of 50 to 400
/// g, grips of 0.3 to 2 (half of them) or 3 to 10 N/mm, arms of 0.05 to 0.8 N/mm. The seed determines the numbers.
/// @param least_friction  N: the exact value of a third; the others have up to 0.05.
HeldDeviceNumbers randomDevice(std::uint64_t seed, double least_friction = 0.01);
/// The same, turning: 2e-5 to 2e-4 kg m^2, friction of 0.1 to 0.5 N mm, encoders of 0.05, 0.2 and 0.5 mrad.
HeldDeviceNumbers randomTurningDevice(std::uint64_t seed);
/// An ideal device in the same hand: no delay, a perfect encoder, friction 0.05 N.
HeldDeviceNumbers idealised(HeldDeviceNumbers numbers);

class HeldDevice {
 public:
  HeldDevice(const HeldDeviceNumbers& numbers, const Vec3d& start);
  /// Reading of the encoder.
  Vec3d read() const;
  /// Advances a tick of kTick. @param force  for the last sample read.   @param wanted  the arm's target at the end of
  /// the tick.
  void tick(const Vec3d& force, const Vec3d& wanted);
  const Vec3d& position() const { return device_; }
  /// Work of the motors on the device, less the losses by its damping and friction, N mm.
  double given() const { return work_ - lost_; }

 private:
  struct Late {
    long at = 0;  // part of a tick, counted from the start
    Vec3d force;
  };
  HeldDeviceNumbers n_;
  Vec3d device_, hand_, wanted_;
  Vec3d device_speed_ = Vec3d::Zero(), hand_speed_ = Vec3d::Zero(), force_ = Vec3d::Zero();
  std::deque<Late> late_;
  long part_ = 0;
  double work_ = 0, lost_ = 0;
};

}  // namespace kerf::scenes
