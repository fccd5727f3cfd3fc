#include "sim/monitor/heat_pulses.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace kerf {

double ThermalProperties::effusivity() const noexcept { return std::sqrt(conductivity * heat_capacity); }

void HeatPulses::add(double energy, const Vec3d& place, double time, const ThermalProperties& tissue) noexcept {
  if (energy == 0 || !std::isfinite(energy) || !place.allFinite()) return;
  pulses_[static_cast<std::size_t>(count_++)] = {
      place, energy, std::abs(energy), time, tissue.diffusivity(), tissue.heat_capacity};
  if (count_ > kMost) mergeNearestPair(time);
}

void HeatPulses::mergeNearestPair(double now) noexcept {
  // A union moves the weight m = w1 w2 / (w1 + w2), by dt of its age and dx of its width sqrt(4 alpha tau). Ages count
  // from a fifth of a second on: younger heat has not spread yet.
  constexpr double kYoungest = 0.2;  // s
  const auto count = static_cast<std::size_t>(count_);
  std::size_t first = 0, second = 1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = i + 1; j < count; ++j) {
      const Pulse &a = pulses_[i], &b = pulses_[j];
      const double age = std::max(kYoungest, now - std::max(a.time, b.time));
      const double in_time = (a.time - b.time) / age;
      const double in_space = (a.place - b.place).squaredNorm() / (4 * a.diffusivity * age);
      const double moved = a.weight * b.weight / (a.weight + b.weight) * (in_time * in_time + in_space) / age;
      if (moved < least) {
        least = moved;
        first = i;
        second = j;
      }
    }

  Pulse &a = pulses_[first], &b = pulses_[second];
  const double share = b.weight / (a.weight + b.weight);
  a.place += share * (b.place - a.place);
  a.time += share * (b.time - a.time);
  a.diffusivity += share * (b.diffusivity - a.diffusivity);
  a.capacity += share * (b.capacity - a.capacity);
  a.energy += b.energy;
  a.weight += b.weight;
  b = pulses_[count - 1];
  --count_;
}

double HeatPulses::riseAt(const Vec3d& place, double time, double beside) const noexcept {
  constexpr double kNothing = 40;  // exp(-40) of anything
  double sum = 0;
  for (std::size_t n = 0; n < static_cast<std::size_t>(count_); ++n) {
    const Pulse& pulse = pulses_[n];
    const double spread = 4 * pulse.diffusivity * (time - pulse.time);  // mm^2
    if (!(spread > 0)) continue;
    const double away = ((pulse.place - place).squaredNorm() + beside * beside) / spread;
    if (!(away < kNothing)) continue;
    const double width = std::numbers::pi * spread;
    sum += 2 * pulse.energy / (pulse.capacity * width * std::sqrt(width)) * std::exp(-away);
  }
  return sum;
}

double HeatPulses::energy() const noexcept {
  double sum = 0;
  for (std::size_t n = 0; n < static_cast<std::size_t>(count_); ++n) sum += pulses_[n].energy;
  return sum;
}

}  // namespace kerf
