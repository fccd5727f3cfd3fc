// Vibration and sound of a tool as a stream of samples at any rate: 4 kHz for a haptic channel, 44.1 or 48 kHz for
// sound. Separate from the 1 kHz step, whose force is the mean over a cycle and cannot carry a spindle's frequency.
//
// Three parts, of fixed shares, so that their sum stays within -1 to 1:
//   run-out  the drive's own frequency and one harmonic. The frequency f is rpm/60 of a spindle, cycles per second of
//            a stroke; the harmonic is the second of a spindle, the third of a stroke, whose force reverses.
//   teeth    blades that pass, twice: z f and 2 z f of a spindle; of a blade the ripple of its pitch, whose pace
//            follows the stroke. Only under load.
//   chips    noise in a band whose middle is the material's, growing with load.
// This matches a turbine's sound: a first group at rpm/60, its harmonic, and a broad part from 5 to 15 kHz (spectra of
// handpieces: doi 10.1007/s007840050078).
//
// Phase is continuous under any change; speed and load are interpolated linearly from one call to the next. Tones fade
// out below 10 Hz, where they would push the hand, and above 0.4 of the rate, where they would alias. The mean is zero,
// but for the edges of a window. Deterministic: own noise, own sine, integer phases; the same bits everywhere.
#pragma once

#include <cstdint>
#include <span>

#include "geometry/field/material.h"
#include "sim/monitor/oscillators.h"
#include "sim/step/tool_model.h"

namespace kerf {

/// Sound source of a tool, from its geometry and drive.
struct VibrationSource {
  ToolMotion motion = ToolMotion::kSpin;
  double cycles_per_speed = 0;   ///< Hz per unit of ToolDrive::speed
  double nominal_frequency = 0;  ///< Hz, at the drive's nominal speed
  /// kSpin: blades around; else teeth passed in one stroke one way. 0: grains, no tooth tone.
  double teeth = 0;
};
/// Blades: the shape's number if given (a drill has two), else six for carbides (chosen; catalogues have 6 to 12) and
/// none for diamonds; for saws from pitch and stroke.
VibrationSource vibrationSource(const Tool& tool, const ToolDrive& drive);

/// Input of one tick.
struct VibrationInput {
  double speed = 0;                       ///< StepOutput::speed: rad/s, mm/s, as ToolDrive
  double load = 0;                        ///< 0 to 1: StepOutput::cutting_load over a firm hand's (kFirmLoad)
  Material material = Material::kDentin;  ///< under the tool
};
/// The load that counts as full, N: upper end of operators' loads on crowns (0.1-4.9 N, litmetric 17074189).
inline constexpr double kFirmLoad = 5;

/// A value; for the thread that renders. The same seed and inputs give the same samples, for any number per call.
class Vibration {
 public:
  /// @param rate  samples per second, 100 to 1e6; otherwise all samples are 0.   @param seed  of the noise.
  explicit Vibration(const VibrationSource& source, double rate, std::uint64_t seed = 1) noexcept;
  /// The next samples, from the last call's speed and load to these, each in [-1, 1]: times a force (N) for the hand,
  /// times a volume for the ear.   @rt safe.  @cost about 30 ns a sample.
  void render(const VibrationInput& in, std::span<float> out) noexcept;
  double frequency() const noexcept { return frequency_; }  ///< Hz, of the drive, at the last sample

 private:
  float sample(double frequency, double load) noexcept;
  double chips() noexcept;

  VibrationSource source_;
  double rate_ = 0;
  internal::WhiteNoise noise_;
  internal::BandPass band_;
  std::uint32_t phase_ = 0;              // of the drive, 2^32 a turn
  double frequency_ = 0, load_ = 0;      // as of the last sample
  double middle_ = 0, last_middle_ = 0;  // of the chips' band, Hz
};

}  // namespace kerf
