#include "sim/monitor/felt_vibration.h"

#include <cmath>
#include <numbers>

#include "sim/step/drive.h"

namespace kerf {
namespace {

using internal::fade;
using internal::usable;

// Shares of the load. The last three from facts about handpieces and saws, the shares of a drill chosen.
constexpr double kFeltChips = 0.02, kChipsOfDrill = 0.05, kChipsAtStall = 0.08;
constexpr double kFeltRunOut = 0.0075, kLips = 0.02, kStroke = 0.04;
constexpr double kStalls = 0.3;  // of the free speed: below it chips grow

// The band of chips, Hz: middle and width.
constexpr double kMiddle = 122, kWidth = 250;

constexpr double kKick = 0.02, kKickFrequency = 80, kKickTime = 0.02;  // N, Hz, s
constexpr double kLargestPeak = 4;                                     // of noise, over its rms

}  // namespace

FeltSource feltSource(const Tool& tool, const ToolDrive& drive) {
  const VibrationSource heard = vibrationSource(tool, drive);
  FeltSource out;
  out.cycles_per_speed = heard.cycles_per_speed;
  out.free_speed = drive.speed;
  if (heard.motion != ToolMotion::kSpin) {
    out.kind = FeltSource::Kind::kSaw;
    if (heard.motion == ToolMotion::kStroke) out.direction_in_tool = Vec3d::UnitZ();
  } else if (isDrill(tool)) {
    out.kind = FeltSource::Kind::kDrill;
  } else if (drive.form != DriveForm::kTurbine) {
    out.kind = FeltSource::Kind::kMotor;
  }
  return out;
}

FeltVibration::FeltVibration(const FeltSource& source, double rate, std::uint64_t seed) noexcept
    : source_(source), rate_(rate >= 800 && rate <= 1e5 ? rate : 0), noise_(seed) {
  if (rate_ <= 0) return;
  // Evenly distributed noise has a variance of 1/3, the filter's gain at its middle is 1 / damping. A band pass of gain
  // 1 leaves d g / (1 + d g + g^2) of the variance of white noise.
  const double damping = kWidth / kMiddle;
  g_ = std::tan(std::numbers::pi * kMiddle / rate_);
  even_ = damping * std::sqrt(3 * (1 + damping * g_ + g_ * g_) / (damping * g_));
}

// Relative to the load.
double FeltVibration::chips(double speed_share, Material material) noexcept {
  const double noise = even_ * band_.next(noise_.next(), g_, kWidth / kMiddle);
  const bool is_hard_drilled = source_.kind == FeltSource::Kind::kDrill && material == Material::kCortical;
  const double free = is_hard_drilled ? kChipsOfDrill : kFeltChips;
  const double share = kChipsAtStall + (free - kChipsAtStall) * fade(speed_share, 0, kStalls);
  return share * std::clamp(noise, -kLargestPeak, kLargestPeak);
}

// Relative to the load. Below 10 Hz it would push, above 0.4 of the rate it would alias.
double FeltVibration::tone(double speed) noexcept {
  const double frequency = usable(std::abs(speed) * source_.cycles_per_speed, 0.5 * rate_);
  phase_ += internal::phaseStep(frequency, rate_);
  const auto felt = [&](double f) { return fade(f, 5, 10) * (1 - fade(f, 0.4 * rate_, 0.45 * rate_)); };

  switch (source_.kind) {
    case FeltSource::Kind::kTurbine:
      break;
    case FeltSource::Kind::kMotor:
      return kFeltRunOut * felt(frequency) * internal::sine(phase_);
    case FeltSource::Kind::kDrill:
      return kLips * felt(2 * frequency) * internal::sine(2 * phase_);
    case FeltSource::Kind::kSaw:
      return kStroke * felt(frequency) * internal::sine(phase_);
  }
  return 0;
}

// N.
double FeltVibration::startKick(double speed_share) noexcept {
  if (is_at_rest_ && speed_share > kAtRest) {
    kick_ = kKick;
    kick_phase_ = 0;
  }
  is_at_rest_ = speed_share < (is_at_rest_ ? kAtRest : 0.5 * kAtRest);
  if (kick_ < 1e-5) return 0;

  kick_phase_ += internal::phaseStep(kKickFrequency, rate_);
  kick_ *= 1 - 1 / (kKickTime * rate_);
  return kick_ * internal::sine(kick_phase_);
}

double FeltVibration::next(const FeltInput& in) noexcept {
  if (rate_ <= 0 || !(source_.free_speed > 0)) return 0;
  const double share = usable(std::abs(in.speed) / source_.free_speed, 1);
  const double load = usable(in.load, 100);

  const double cutting = load * (chips(share, in.material) + tone(in.speed));
  const double sum = fade(share, 0.5 * kAtRest, kAtRest) * cutting + startKick(share);
  return std::clamp(sum, -kMost, kMost);
}

}  // namespace kerf
