#include "ui/sound/drill_sound.h"

#include <algorithm>
#include <cmath>

#include "sim/monitor/oscillators.h"

namespace kerf {
namespace {

// Share of full scale at full volume and full load. A drive in air reaches a seventh of that: Vibration.
constexpr double kMostGain = 1;
// Share of the free speed: below it a drive sounds like standing still.
constexpr double kLeastSpeed = 0.02;

// Loudness to amplitude: hearing follows ratios.
double gainOf(double volume) noexcept {
  const double v = internal::usable(volume, 1);
  return kMostGain * v * v;
}

bool isSame(const VibrationSource& a, const VibrationSource& b) noexcept {
  return a.motion == b.motion && a.cycles_per_speed == b.cycles_per_speed &&
         a.nominal_frequency == b.nominal_frequency && a.teeth == b.teeth;
}

}  // namespace

DrillSoundInput drillSoundOf(const HapticReport& report, const Tool& tool, const ToolDrive& drive, double volume) {
  DrillSoundInput out;
  out.source = vibrationSource(tool, drive);
  out.now = {report.output.speed, report.output.cutting_load / kFirmLoad, report.output.material};
  out.volume = volume;
  out.is_running = !report.is_latched && report.output.speed > kLeastSpeed * drive.speed;
  return out;
}

DrillSound::DrillSound(double rate) : rate_(std::clamp(rate, 8000.0, 192000.0)), vibration_({}, rate_) {}

void DrillSound::render(const DrillSoundInput& in, std::span<float> out) noexcept {
  // Another tool begins when the previous one is silent.
  if (isSilent() && in.is_running && !isSame(source_, in.source)) {
    vibration_ = Vibration(in.source, rate_);
    source_ = in.source;
    speed_ = 0;
    load_ = 0;
  }
  const bool is_heard = in.is_running && isSame(source_, in.source);
  const double wanted = is_heard ? gainOf(in.volume) : 0;
  if (isSilent() && wanted == 0) {
    std::fill(out.begin(), out.end(), 0.0f);
    return;
  }

  // A starting drive is at its pitch at once, an ending one keeps its pitch.
  if (is_heard) {
    const double share = isSilent() ? 1 : 1 - std::exp(-static_cast<double>(out.size()) / (rate_ * kFollowSeconds));
    speed_ += share * (internal::usable(std::abs(in.now.speed), 1e9) - speed_);
    load_ += share * (internal::usable(in.now.load, 1) - load_);
  }
  vibration_.render({speed_, load_, in.now.material}, out);

  const double step = kMostGain / (kFadeSeconds * rate_);
  for (float& sample : out) {
    gain_ += std::clamp(wanted - gain_, -step, step);
    sample = static_cast<float>(gain_ * static_cast<double>(sample));
  }
}

}  // namespace kerf
