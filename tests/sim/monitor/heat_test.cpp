#include "sim/monitor/heat.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/support/allocation_guard.h"

namespace kerf {
namespace {

// All of the power stays, nothing leaves but by conduction into the depth: the analytic case.
HeatSettings oneDimensional() {
  HeatSettings settings;
  settings.dry_share = 1;
  settings.air_film = 0;
  settings.spreads_sideways = false;
  return settings;
}
HeatInput flux(double mw_per_mm2, Material material, double area = 1) {
  HeatInput in;
  in.power = mw_per_mm2 * area;
  in.area = area;
  in.material = material;
  return in;
}
double analyticSurface(double q, double t, Material material) {
  return 2 * q * std::sqrt(t / std::numbers::pi) / thermalProperties(material).effusivity();
}
// Integral of the complementary error function.
double ierfc(double x) { return std::exp(-x * x) / std::sqrt(std::numbers::pi) - x * std::erfc(x); }

TEST(Heat, ConstantFluxFollowsTheSemiInfiniteSolid) {
  for (const Material material : {Material::kEnamel, Material::kDentin, Material::kCortical, Material::kCancellous}) {
    Heat heat(oneDimensional());
    double worst = 0;
    for (int n = 1; n <= 60000; ++n) {
      heat.step(flux(3, material));
      if (n < 10) continue;
      worst = std::max(worst, std::abs(heat.surfaceRise() / analyticSurface(3, n * kTick, material) - 1));
    }
    EXPECT_LT(worst, 0.002);  // goal G20: 10 %
  }
}

TEST(Heat, RiseAtDepthFollowsTheSemiInfiniteSolid) {
  Heat heat(oneDimensional());
  const double alpha = thermalProperties(Material::kDentin).diffusivity();
  const double e = thermalProperties(Material::kDentin).effusivity();
  for (int n = 1; n <= 60000; ++n) {
    heat.step(flux(3, Material::kDentin));
    if (n != 1000 && n != 10000 && n != 60000) continue;
    const double t = n * kTick;
    for (const double depth : {0.2, 0.5, 1.0, 2.0}) {
      if (depth > 3 * std::sqrt(alpha * t)) continue;  // next to nothing has come so far
      const double expected = 2 * 3 * std::sqrt(t) / e * ierfc(depth / (2 * std::sqrt(alpha * t)));
      EXPECT_NEAR(heat.riseAt(depth) / expected, 1, 0.03) << t << " s, " << depth << " mm";
    }
  }
}

// q (1 - exp(h^2 t / e^2) erfc(h sqrt(t) / e)) / h: Carslaw & Jaeger's surface with a film.
TEST(Heat, SprayCoolsAsAFilmDoes) {
  HeatSettings settings = oneDimensional();
  settings.wet_share = 1;
  settings.spray_film = 2;
  Heat heat(settings);
  HeatInput in = flux(4, Material::kEnamel);
  in.irrigation = 1;
  const double e = thermalProperties(Material::kEnamel).effusivity();
  for (int n = 1; n <= 5000; ++n) {
    heat.step(in);
    if (n % 50) continue;
    const double x = 2 * std::sqrt(n * kTick) / e;
    EXPECT_NEAR(heat.surfaceRise(), 4.0 / 2 * (1 - std::exp(x * x) * std::erfc(x)), 0.01 * heat.surfaceRise());
  }
}

// The centre of a disc on a half-space: 2 q sqrt(alpha t) / k (ierfc(0) - ierfc(a / (2 sqrt(alpha t)))).
TEST(Heat, ASmallContactSettlesAsADiscDoes) {
  HeatSettings settings = oneDimensional();
  settings.spreads_sideways = true;
  Heat heat(settings);
  const ThermalProperties& tissue = thermalProperties(Material::kCortical);
  constexpr double kRadius = 0.5, kArea = std::numbers::pi * kRadius * kRadius;
  double worst = 0;
  for (int n = 1; n <= 60000; ++n) {
    heat.step(flux(3, Material::kCortical, kArea));
    const double s = std::sqrt(tissue.diffusivity() * n * kTick);
    const double exact = 2 * 3 * s / tissue.conductivity * (ierfc(0) - ierfc(kRadius / (2 * s)));
    if (n >= 10) worst = std::max(worst, std::abs(heat.surfaceRise() / exact - 1));
  }
  EXPECT_LT(worst, 0.26);
  EXPECT_NEAR(heat.surfaceRise() / (3 * kRadius / tissue.conductivity), 1, 0.08);
}

// On the axis: 2 q sqrt(alpha t) / k (ierfc(z / (2 sqrt(alpha t))) - ierfc(sqrt(z^2 + a^2) / (2 sqrt(alpha t)))).
TEST(Heat, DepthBelowASmallContactWarmsAsBelowADisc) {
  HeatSettings settings = oneDimensional();
  settings.spreads_sideways = true;
  Heat heat(settings);
  const ThermalProperties& tissue = thermalProperties(Material::kDentin);
  constexpr double kRadius = 0.5, kArea = std::numbers::pi * kRadius * kRadius;
  for (int n = 1; n <= 60000; ++n) {
    heat.step(flux(30, Material::kDentin, kArea));
    if (n != 10000 && n != 30000 && n != 60000) continue;
    const double s = std::sqrt(tissue.diffusivity() * n * kTick);
    for (const double z : {0.3, 0.5, 1.0, 2.0}) {
      const double exact =
          2 * 30 * s / tissue.conductivity * (ierfc(z / (2 * s)) - ierfc(std::hypot(z, kRadius) / (2 * s)));
      EXPECT_NEAR(heat.riseAt(z) / exact, 1, 0.3) << n * kTick << " s, " << z << " mm";
    }
  }
}

// In front of a steadily receding surface all that arrives goes into the tissue about to leave: T = q / (rho c v).
TEST(Heat, ChipsCarryTheirWarmthOff) {
  Heat heat(oneDimensional());
  HeatInput in = flux(20, Material::kCortical);
  in.removed = 2 * kTick;  // 2 mm/s
  for (int n = 0; n < 60000; ++n) heat.step(in);
  EXPECT_NEAR(heat.surfaceRise(), 20 / (2 * thermalProperties(Material::kCortical).heat_capacity), 0.1);
}

TEST(Heat, ItCoolsWhenTheToolLeaves) {
  Heat heat(oneDimensional());
  for (int n = 0; n < 1000; ++n) heat.step(flux(5, Material::kDentin));
  const double hot = heat.surfaceRise();
  for (int n = 0; n < 3000; ++n) heat.step(HeatInput{});
  // Superposition: sqrt(4) - sqrt(3) of what one second made.
  EXPECT_NEAR(heat.surfaceRise() / hot, 2 - std::sqrt(3), 0.003);
}

TEST(Heat, IrrigationKeepsTissueCooler) {
  Heat dry, wet;
  HeatInput in = flux(50, Material::kCortical);
  for (int n = 0; n < 5000; ++n) {
    in.irrigation = 0;
    dry.step(in);
    in.irrigation = 1;
    wet.step(in);
  }
  EXPECT_LT(wet.surfaceRise(), 0.1 * dry.surfaceRise());
  EXPECT_GT(wet.surfaceRise(), 0);
}

TEST(Heat, AnotherTissueMakesNoJump) {
  Heat heat(oneDimensional());
  for (int n = 0; n < 1000; ++n) heat.step(flux(5, Material::kEnamel));
  const double before = heat.surfaceRise();
  heat.step(flux(5, Material::kDentin));
  EXPECT_NEAR(heat.surfaceRise(), before, 0.05 * before);
}

TEST(Heat, BoneAlarmComesWhenTheFormulaSays) {
  const double e = thermalProperties(Material::kCortical).effusivity();
  // The flux that reaches the limit after four seconds.
  const double q = kBoneLimitRise * e / (2 * std::sqrt(4 / std::numbers::pi));
  Heat heat(oneDimensional());
  for (int n = 0; n < 70000; ++n) {
    heat.step(flux(q, Material::kCortical));
    if (n == 3900) {
      EXPECT_LT(heat.alarms().bone_warm, 0);
    }
  }
  EXPECT_NEAR(heat.alarms().bone_warm, 4, 0.05);
  EXPECT_NEAR(heat.alarms().bone_dead, heat.alarms().bone_warm + kBoneLimitSeconds, 0.002);
  for (int n = 0; n < 1000; ++n) heat.step(HeatInput{});
  EXPECT_NEAR(heat.alarms().bone_warm, 4, 0.05) << "latched";
  heat.reset();
  EXPECT_LT(heat.alarms().bone_warm, 0);
  EXPECT_EQ(heat.surfaceRise(), 0);
}

TEST(Heat, PulpAlarmComesWhenTheFormulaSays) {
  const ThermalProperties& dentin = thermalProperties(Material::kDentin);
  const auto rise = [&](double q, double t) {
    return 2 * q * std::sqrt(t) / dentin.effusivity() * ierfc(0.5 / (2 * std::sqrt(dentin.diffusivity() * t)));
  };
  const double q = kPulpLimitRise / rise(1, 5);
  Heat heat(oneDimensional());
  HeatInput in = flux(q, Material::kDentin);
  in.pulp_depth = 0.5;
  for (int n = 0; n < 8000; ++n) heat.step(in);
  EXPECT_NEAR(heat.alarms().pulp, 5, 0.25);
  EXPECT_LT(heat.alarms().bone_warm, 0) << "dentin is no bone";
}

TEST(Heat, NoInputMakesItLoseItsSenses) {
  Heat heat;
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf, -1.0, 1e300}) {
    HeatInput in;
    in.power = bad;
    in.area = 1;
    in.removed = bad;
    in.irrigation = bad;
    in.pulp_depth = bad;
    heat.step(in);
    in.area = bad;
    heat.step(in);
    heat.step(in, bad);
    EXPECT_TRUE(std::isfinite(heat.surfaceRise())) << bad;
    EXPECT_TRUE(std::isfinite(heat.riseAt(bad))) << bad;
  }
}

TEST(Heat, StepsWithoutAllocating) {
  Heat heat;
  const AllocationGuard guard;
  for (int n = 0; n < 1000; ++n) heat.step(flux(10, Material::kEnamel));
}

}  // namespace
}  // namespace kerf
