// The vibration of a tool as a force on the hand, below 400 Hz. Skin feels best at 50 to 300 Hz; of a turbine's 6 kHz
// nothing is left. The step's force is the mean over a cycle and has no vibration.
//
//   chips    noise of 50 to 300 Hz: rms 2 % of the load, 5 % of a drill in cortical bone, growing to 8 % as the drive
//            falls below 0.3 of its free speed. A bur that stalls is felt, then quiet.
//   run-out  of a motor: a tone at rpm / 60, 0.75 % of the load, below 400 Hz.
//   lips     of a drill: a tone at twice its turns, 2 % of the load.
//   stroke   of a saw: a tone at its cycles, 4 % of the load.
//   start    0.02 N at 80 Hz, gone within 0.1 s. In air there is nothing else.
//
// Along one direction: above 50 Hz a hand does not tell directions apart (Landin et al., EuroHaptics 2010). Shares are
// chosen from measurements of handpieces. Added to the force of the coupling: it has no stiffness, so it does not
// affect the coupling's stability, and its mean over 0.1 s is zero.
#pragma once

#include <cstdint>

#include "sim/monitor/oscillators.h"
#include "sim/monitor/vibration.h"

namespace kerf {

/// Vibration source of a tool, from its geometry and drive.
struct FeltSource {
  enum class Kind { kTurbine, kMotor, kDrill, kSaw };
  Kind kind = Kind::kTurbine;
  double cycles_per_speed = 0;               ///< Hz per unit of ToolDrive::speed
  double free_speed = 0;                     ///< ToolDrive::speed
  Vec3d direction_in_tool = Vec3d::UnitX();  ///< unit vector: for a saw along its stroke
};
FeltSource feltSource(const Tool& tool, const ToolDrive& drive);

/// Input of one sample.
struct FeltInput {
  double speed = 0;                       ///< StepOutput::speed
  double load = 0;                        ///< N: StepOutput::normal_load
  Material material = Material::kDentin;  ///< under the tool
};

/// A value; belongs to the thread that renders. The same seed and inputs give the same samples.
class FeltVibration {
 public:
  static constexpr double kMost = 0.5;  ///< N, of a sample

  /// @param rate  samples per second, 800 to 1e5; otherwise all samples are 0.   @param seed  of the noise.
  explicit FeltVibration(const FeltSource& source = {}, double rate = 1000, std::uint64_t seed = 1) noexcept;
  /// The next sample, N along direction_in_tool.   @rt  @cost about 30 ns.
  double next(const FeltInput& in) noexcept;
  const FeltSource& source() const noexcept { return source_; }

 private:
  double chips(double speed_share, Material material) noexcept;
  double tone(double speed) noexcept;
  double startKick(double speed_share) noexcept;

  FeltSource source_;
  double rate_ = 0;
  double g_ = 0, even_ = 0;  // of the filter; what makes its output's rms 1
  internal::WhiteNoise noise_;
  internal::BandPass band_;
  std::uint32_t phase_ = 0;  // of the drive
  double kick_ = 0;          // N, rest of the start kick
  std::uint32_t kick_phase_ = 0;
  bool is_at_rest_ = true;
};

}  // namespace kerf
