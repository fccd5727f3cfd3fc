#include "sim/monitor/vibration.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

using internal::fade;
using internal::sine;
using internal::usable;

// Shares of the whole; together 1. Chosen.
constexpr double kRunOut = 0.25, kHarmonic = 0.1, kTeeth = 0.2, kTeethTwice = 0.1, kChips = 0.35;
// Run-out in air relative to full load: an idle handpiece is quieter. Chosen.
constexpr double kIdle = 0.4;

// Middle of the chips' band, Hz: harder rings higher. Chosen.
double bandMiddle(Material material) noexcept {
  switch (material) {
    case Material::kEnamel:
      return 7000;
    case Material::kDentin:
    case Material::kCortical:
      return 4000;
    case Material::kCancellous:
      return 2000;
    case Material::kCaries:
      return 1500;
    case Material::kPulp:
    case Material::kGingiva:
    case Material::kPdl:
    case Material::kNerveCanal:
      return 600;
    default:
      return 3000;
  }
}

}  // namespace

VibrationSource vibrationSource(const Tool& tool, const ToolDrive& drive) {
  VibrationSource out;
  out.motion = motionOf(tool);
  if (out.motion == ToolMotion::kSpin)
    out.cycles_per_speed = 1 / (2 * std::numbers::pi);
  else if (const double way = tool.motion->way(tool); way > 0)
    out.cycles_per_speed = 1 / (2 * way);  // the drive's speed is the mean there and back

  if (tool.motion)
    out.teeth = tool.motion->teeth(tool);
  else if (isDrill(tool))
    out.teeth = 2;
  else
    out.teeth = tool.iso && tool.iso->material == "806" ? 0 : 6;  // 806: diamond
  out.nominal_frequency = out.cycles_per_speed * drive.speed;
  return out;
}

Vibration::Vibration(const VibrationSource& source, double rate, std::uint64_t seed) noexcept
    : source_(source), rate_(rate >= 100 && rate <= 1e6 ? rate : 0), noise_(seed) {
  source_.teeth = usable(source.teeth, 1000);
}

// The noise of the chips in the material's band. Tangent by its first terms (the pitch of a hiss needs no more), the
// middle well below half the rate.
double Vibration::chips() noexcept {
  const double w = std::numbers::pi * std::min(last_middle_ / rate_, 0.2);
  return band_.next(noise_.next(), w * (1 + w * w / 3), 1);
}

float Vibration::sample(double frequency, double load) noexcept {
  const double band = chips();
  phase_ += internal::phaseStep(frequency, rate_);
  const double hearable = fade(frequency, 0, 10);
  const auto tone = [&](double f) { return hearable * (1 - fade(f, 0.4 * rate_, 0.45 * rate_)); };
  const bool spins = source_.motion == ToolMotion::kSpin;
  const double drive = source_.nominal_frequency > 0 ? std::min(1.0, frequency / source_.nominal_frequency) : 0;
  const double moved = drive * (kIdle + (1 - kIdle) * load);

  // Run-out and its harmonic.
  double sum = kRunOut * moved * tone(frequency) * sine(phase_);
  const std::uint32_t harmonic = spins ? 2 : 3;
  sum += kHarmonic * moved * tone(frequency * harmonic) * sine(phase_ * harmonic);

  // Teeth.
  if (source_.teeth > 0 && spins) {
    const auto z = static_cast<std::uint32_t>(source_.teeth + 0.5);
    sum += kTeeth * drive * load * tone(z * frequency) * sine(z * phase_);
    sum += kTeethTwice * drive * load * tone(2 * z * frequency) * sine(2 * z * phase_);
  } else if (source_.teeth > 0) {
    // The stroke is teeth / 2 * sin(phase) pitches from its middle; at its fastest pi * teeth * f pass in a second.
    const double fastest = std::numbers::pi * source_.teeth * frequency;
    const double at = 0.5 * source_.teeth * sine(phase_) * 4294967296.0;
    const auto passed = static_cast<std::uint32_t>(static_cast<std::int64_t>(at));
    sum += kTeeth * drive * load * tone(fastest) * sine(passed);
    sum += kTeethTwice * drive * load * tone(2 * fastest) * sine(2 * passed);
  }

  // Scaled so that the band's rare peaks alone reach its share; clamped alike on both sides.
  sum += kChips * drive * load * std::clamp(1.2 * band, -1.0, 1.0);
  return static_cast<float>(sum);
}

void Vibration::render(const VibrationInput& in, std::span<float> out) noexcept {
  if (out.empty()) return;
  if (rate_ <= 0) {
    std::fill(out.begin(), out.end(), 0.0f);
    return;
  }
  // Limits the frequency to half the rate: faster tones have faded.
  const double frequency = usable(std::abs(in.speed) * source_.cycles_per_speed, 0.5 * rate_);
  const double load = usable(in.load, 1), middle = bandMiddle(in.material);

  if (middle_ <= 0) middle_ = middle;
  const double step = 1 / static_cast<double>(out.size());
  for (std::size_t n = 0; n < out.size(); ++n) {
    const double t = static_cast<double>(n + 1) * step;
    last_middle_ = middle_ + t * (middle - middle_);
    out[n] = sample(frequency_ + t * (frequency - frequency_), load_ + t * (load - load_));
  }
  frequency_ = frequency;
  load_ = load;
  middle_ = middle;
}

}  // namespace kerf
