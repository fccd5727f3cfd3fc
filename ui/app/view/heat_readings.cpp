#include "ui/app/view/heat_readings.h"

namespace kerf {

HeatReading heatOfSurface(const HeatReport& heat, Material under) {
  const bool is_bone = under == Material::kCortical || under == Material::kCancellous;
  const double limit = kBodyCelsius + (is_bone ? kBoneLimitRise : HeatSettings{}.boiling_rise);
  return {heat.surface, heat.surface >= limit};
}

HeatReading heatOfKept(const HeatReport& heat, Material kept) {
  const bool is_pulp = kept == Material::kPulp;
  const double rise = is_pulp ? heat.pulp_rise : heat.nerve_rise;
  return {kBodyCelsius + rise, rise >= (is_pulp ? kPulpLimitRise : kBoneLimitRise)};
}

}  // namespace kerf
