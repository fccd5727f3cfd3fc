#include "sim/monitor/heat.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "geometry/tool/tool_file.h"
#include "tests/support/allocation_guard.h"

namespace kerf::heat_test {
namespace {

// All power enters the tissue, and the only loss is into the tissue.
constexpr HeatSettings kNoLosses{.spray_share = 1, .air_film = 0, .coolant_rise = 0, .boiling_rise = 1e9};
HeatSource allOfIt(double spray_film = 0) {
  HeatSource source;
  source.share = 1;
  source.spray_film = spray_film;
  source.least_area = 1e-6;
  return source;
}
HeatInput touching(double power, double area, Material material) {
  HeatInput in;
  in.is_touching = true;
  in.power = power;
  in.area = area;
  in.material = material;
  return in;
}
void run(Heat& heat, const HeatInput& in, double seconds) {
  const auto ticks = static_cast<int>(std::lround(seconds / kTick));
  for (int n = 0; n < ticks; ++n) heat.step(in);
}
// Conductance of a disc, mW/K: the two terms of the law.
double intoTissue(double area, double dwell, Material material) {
  const ThermalProperties& tissue = thermalProperties(material);
  const double radius = std::sqrt(area / std::numbers::pi);
  return area * tissue.effusivity() * std::sqrt(std::numbers::pi / (4 * dwell)) +
         std::numbers::pi * tissue.conductivity * radius;
}
constexpr Material kTissues[] = {Material::kEnamel, Material::kDentin, Material::kCortical, Material::kCancellous};

// 2 q sqrt(t / pi) / e: Carslaw & Jaeger's surface under constant flux. A contact this wide has no sides.
TEST(Heat, AWideContactFollowsTheSemiInfiniteSolid) {
  constexpr double kFlux = 3, kArea = 1e8;
  for (const Material material : kTissues) {
    Heat heat(allOfIt(), kNoLosses);
    for (int n = 1; n <= 10000; ++n) {
      heat.step(touching(kFlux * kArea, kArea, material));
      const double exact =
          2 * kFlux * std::sqrt(n * kTick / std::numbers::pi) / thermalProperties(material).effusivity();
      ASSERT_NEAR(heat.surfaceRise() / exact, 1, 0.002) << n;
    }
  }
}

// q a / k: the centre of a disc. After ten minutes the transient term is some 5 % of the other.
TEST(Heat, ASmallContactSettlesAsADiscDoes) {
  constexpr double kRadius = 0.3, kArea = std::numbers::pi * kRadius * kRadius;
  for (const Material material : kTissues) {
    Heat heat(allOfIt(), kNoLosses);
    run(heat, touching(3 * kArea, kArea, material), 600);
    EXPECT_NEAR(heat.surfaceRise() / (3 * kRadius / thermalProperties(material).conductivity), 1, 0.05);
  }
}

TEST(Heat, AWanderingContactHasTheDwellOfItsOwnWidth) {
  constexpr double kArea = 0.8, kSpeed = 2;
  HeatInput in = touching(100, kArea, Material::kDentin);
  in.velocity = Vec3d(0, kSpeed, 0);
  Heat heat(allOfIt(), kNoLosses);
  run(heat, in, 20);
  const double dwell = 2 * std::sqrt(kArea / std::numbers::pi) / kSpeed;
  EXPECT_NEAR(heat.surfaceRise(), 100 / intoTissue(kArea, dwell, Material::kDentin), 1e-6);
}

TEST(Heat, ToAndFroWithinTheMeanIsNoWandering) {
  Heat still(allOfIt(), kNoLosses), trembling(allOfIt(), kNoLosses);
  HeatInput in = touching(100, 0.8, Material::kDentin);
  run(still, in, 10);
  for (int n = 0; n < 10000; ++n) {
    in.velocity = Vec3d(n % 2 ? 20 : -20, 0, 0);  // 0.02 mm at 500 Hz
    trembling.step(in);
  }
  EXPECT_NEAR(trembling.surfaceRise() / still.surfaceRise(), 1, 0.01);
}

TEST(Heat, ChipsCarryTheirWarmthOff) {
  const double capacity = thermalProperties(Material::kCortical).heat_capacity;
  for (const double rate : {0.5, 5.0, 500.0}) {
    HeatInput in = touching(1000, 1, Material::kCortical);
    in.removed = rate * kTick;
    Heat heat(allOfIt(), kNoLosses);
    run(heat, in, 5);
    EXPECT_NEAR(heat.surfaceRise(), 1000 / (intoTissue(1, 5, Material::kCortical) + capacity * rate), 1e-6) << rate;
  }
}

TEST(Heat, SprayHalvesTheShareAndCoolsAsAFilmInProportion) {
  constexpr double kShare = 0.03, kFilm = 10, kAirFilm = 0.02, kColdWater = -10;
  HeatSource source;
  source.share = kShare;
  source.spray_film = kFilm;
  for (const double wet : {0.0, 0.3, 1.0})
    for (const double power : {0.0, 5000.0}) {
      HeatInput in = touching(power, 2, Material::kEnamel);
      in.irrigation = wet;
      Heat heat(source);
      run(heat, in, 3);
      const double film = 2 * (kAirFilm + wet * (kFilm - kAirFilm));
      const double in_and_out = (1 - 0.5 * wet) * kShare * power + film * wet * kColdWater;
      EXPECT_NEAR(heat.surfaceRise(), in_and_out / (intoTissue(2, 3, Material::kEnamel) + film), 1e-6) << wet;
    }
}

TEST(Heat, AWetSurfaceIsNoHotterThanBoilingWater) {
  HeatInput in = touching(1e6, 1, Material::kCortical);
  Heat dry, wet, half;
  run(dry, in, 2);
  in.irrigation = 1;
  run(wet, in, 2);
  in.irrigation = 0.5;
  run(half, in, 2);
  EXPECT_EQ(wet.surfaceRise(), 63);
  EXPECT_GT(half.surfaceRise(), 63);
  EXPECT_GT(dry.surfaceRise(), 2 * half.surfaceRise());
}

TEST(Heat, ALeastAreaStandsForWhatNobodySees) {
  HeatSource source;
  source.least_area = 0.3;
  Heat none(source), small(source), more(source);
  run(none, touching(100, 0, Material::kDentin), 2);
  run(small, touching(100, 0.3, Material::kDentin), 2);
  run(more, touching(100, 0.6, Material::kDentin), 2);
  EXPECT_EQ(none.surfaceRise(), small.surfaceRise());
  EXPECT_LT(more.surfaceRise(), 0.8 * small.surfaceRise());
}

TEST(Heat, PowerCountsByItsMeanOverAFifthOfASecond) {
  Heat steady, pulsed;
  for (int n = 0; n < 4000; ++n) {
    steady.step(touching(500, 1, Material::kDentin));
    pulsed.step(touching(n % 2 ? 1000 : 0, 1, Material::kDentin));
  }
  EXPECT_NEAR(pulsed.surfaceRise() / steady.surfaceRise(), 1, 0.01);
}

// Superposition: three seconds after the end, a second of constant flux leaves sqrt(4) - sqrt(3) of it.
TEST(Heat, ItCoolsWhenTheToolLeaves) {
  Heat heat(allOfIt(), kNoLosses);
  run(heat, touching(5e6, 1e6, Material::kDentin), 1);
  const double hot = heat.surfaceRise();
  run(heat, {}, 3);
  EXPECT_NEAR(heat.surfaceRise() / hot, 2 - std::sqrt(3), 1e-6);
}

TEST(Heat, NewTissueIsCold) {
  Heat heat;
  HeatInput in = touching(5000, 1, Material::kDentin);
  run(heat, in, 20);
  const double long_there = heat.surfaceRise();
  run(heat, {}, 1);
  in.place = Vec3d(4, 0, 0);
  run(heat, in, 0.3);
  EXPECT_LT(heat.surfaceRise(), 0.8 * long_there);

  Heat fresh;
  run(fresh, in, 0.3);
  EXPECT_NEAR(heat.surfaceRise(), fresh.surfaceRise(), 1e-9);
}

TEST(Heat, WithoutLossesAllOfTheShareIsConducted) {
  Heat heat(allOfIt(), kNoLosses);
  HeatInput in = touching(250, 1, Material::kDentin);
  for (int n = 0; n < 30000; ++n) {
    in.place = Vec3d(std::sin(0.002 * n), std::cos(0.003 * n), 0);
    heat.step(in);
  }
  EXPECT_NEAR(heat.pulses().energy(), 250 * 30, 1e-6);
  in.is_elsewhere = true;
  run(heat, in, 5);
  EXPECT_NEAR(heat.pulses().energy(), 250 * 30, 1e-6) << "into another object";
}

// P / (2 pi k r) erfc(r / sqrt(4 alpha t)): a steady source on a half-space.
TEST(Heat, DepthBelowASteadySourceFollowsTheFormula) {
  for (const Material material : kTissues) {
    const ThermalProperties& tissue = thermalProperties(material);
    Heat heat(allOfIt(), kNoLosses);
    for (int n = 1; n <= 120000; ++n) {
      heat.step(touching(100, 1, material));
      if (n != 5000 && n != 20000 && n != 60000 && n != 120000) continue;
      const double t = n * kTick;
      for (const double r : {0.8, 1.5, 2.5, 4.0}) {
        const double x = r / std::sqrt(4 * tissue.diffusivity() * t);
        if (x > 2) continue;  // hardly any heat has come so far
        const double exact = 100 / (2 * std::numbers::pi * tissue.conductivity * r) * std::erfc(x);
        EXPECT_NEAR(heat.riseAt({0, 0, -r}) / exact, 1, 0.02) << t << " s, " << r << " mm";
        EXPECT_NEAR(heat.riseBelow(r), heat.riseAt({r, 0, 0}), 1e-9);
      }
    }
  }
}

TEST(Heat, DepthBelowAWanderingToolIsTheSumOfItsSpots) {
  const ThermalProperties& tissue = thermalProperties(Material::kDentin);
  const auto placeAt = [](double t) { return Vec3d(3 * std::sin(0.5 * t), std::fmod(t, 4.0) < 2 ? 0.0 : 2.0, 0); };
  HeatPulses some;
  std::vector<std::pair<double, Vec3d>> all;  // of a millijoule each
  for (int n = 0; n < 900; ++n) {
    const double t = 0.1 * n + 0.05;
    some.add(1, placeAt(t), t, tissue);
    all.emplace_back(t, placeAt(t));
    if (n % 100 != 99) continue;
    for (const double depth : {0.5, 1.0, 2.0, 3.0})
      for (const Vec3d& p : {Vec3d(0, 0, -depth), Vec3d(2, 1, -depth), Vec3d(-3, 2, -depth)}) {
        const double now = t + 0.05;
        double exact = 0;
        for (const auto& [at, place] : all) {
          const double spread = 4 * tissue.diffusivity() * (now - at);
          exact += 2 / (tissue.heat_capacity * std::pow(std::numbers::pi * spread, 1.5)) *
                   std::exp(-(p - place).squaredNorm() / spread);
        }
        EXPECT_NEAR(some.riseAt(p, now), exact, 0.03 * exact + 0.002) << now << " s, " << p.transpose();
      }
  }
  EXPECT_EQ(some.count(), HeatPulses::kMost);
  EXPECT_NEAR(some.energy(), 900, 1e-9);
}

TEST(Heat, PulpAlarmComesWhenTheFormulaSays) {
  const ThermalProperties& dentin = thermalProperties(Material::kDentin);
  const auto rise = [&](double power, double t) {
    return power / (2 * std::numbers::pi * dentin.conductivity) *
           std::erfc(1 / std::sqrt(4 * dentin.diffusivity() * t));
  };
  Heat heat(allOfIt(), kNoLosses);
  heat.watch(Heat::kPulp, {0, 0, -3});
  heat.watch(Heat::kPulp, {0, 0, -1});
  heat.watch(Heat::kNerve, {0, 0, -2});
  run(heat, touching(kPulpLimitRise / rise(1, 5), 1, Material::kDentin), 8);
  EXPECT_NEAR(heat.alarms().pulp, 5, 0.25);
  EXPECT_NEAR(heat.rise(Heat::kPulp), heat.riseAt({0, 0, -1}), 0.02 * heat.rise(Heat::kPulp)) << "the warmest of them";
  EXPECT_LT(heat.rise(Heat::kNerve), heat.rise(Heat::kPulp));
  EXPECT_LT(heat.alarms().bone_warm, 0) << "dentin is no bone";

  run(heat, {}, 100);
  EXPECT_LT(heat.rise(Heat::kPulp), kPulpLimitRise);
  EXPECT_NEAR(heat.alarms().pulp, 5, 0.25) << "latched";
}

TEST(Heat, TheWarmestPlacesOfAStructureAreFollowed) {
  Heat heat(allOfIt(), kNoLosses);
  HeatInput in = touching(200, 1, Material::kDentin);
  double most = 0;
  for (int n = 0; n < 40000; ++n) {  // 40 mm along a canal, the first of it for long
    in.place = Vec3d(0.001 * std::max(0, n - 10000), 0, 0);
    heat.step(in);
    heat.watch(Heat::kNerve, in.place - Vec3d(0, 0, 1.5));
    most = std::max(most, heat.rise(Heat::kNerve));
    if (n == 10000) {
      EXPECT_NEAR(most, heat.riseAt({0, 0, -1.5}), 1e-3 * most);
    }
  }
  double warmest = 0;
  for (double x = 0; x < 30; x += 0.1) warmest = std::max(warmest, heat.riseAt({x, 0, -1.5}));
  EXPECT_NEAR(heat.rise(Heat::kNerve), warmest, 0.05 * warmest);
}

TEST(Heat, BoneAlarmsComeWhenTheFormulasSay) {
  const ThermalProperties& bone = thermalProperties(Material::kCortical);
  const double radius = std::sqrt(1 / std::numbers::pi), off = radius + Heat::kBoneMargin;
  const auto beside = [&](double power, double t) {
    return power / (2 * std::numbers::pi * bone.conductivity * off) *
           std::erfc(off / std::sqrt(4 * bone.diffusivity() * t));
  };
  const double power = kBoneLimitRise / beside(1, 5);
  Heat heat(allOfIt(), kNoLosses);
  double warm = -1;
  for (int n = 1; n <= 70000; ++n) {
    heat.step(touching(power, 1, Material::kCortical));
    if (warm < 0 && power / intoTissue(1, n * kTick, Material::kCortical) >= kBoneLimitRise) warm = n * kTick;
  }
  EXPECT_NEAR(heat.alarms().bone_warm, warm, 0.002);
  EXPECT_NEAR(heat.alarms().bone_dead, 5 + kBoneLimitSeconds, 0.3);
  EXPECT_NEAR(heat.alarms().bone_exposure, 70 - 5, 0.3);

  const double before = heat.alarms().bone_exposure;
  run(heat, {}, 60);
  EXPECT_LT(heat.alarms().bone_exposure, before + 20) << "it cools";
  EXPECT_NEAR(heat.alarms().bone_warm, warm, 0.002) << "latched";
  heat.reset();
  EXPECT_LT(heat.alarms().bone_warm, 0);
  EXPECT_EQ(heat.surfaceRise(), 0);
  EXPECT_EQ(heat.pulses().count(), 0);
}

TEST(Heat, SharesAreThoseOfTheKindOfTool) {
  const struct {
    const char* id;
    double share, film, least_area;
  } rows[] = {{"856-016", 0.03, 10, 0.3},  {"round-014", 0.018, 10, 0.3},     {"us-330", 0.018, 10, 0.3},
              {"disc-22", 0.03, 5, 0.3},   {"saw-sagittal-10", 0.15, 5, 0.3}, {"saw-reciprocating-25", 0.15, 5, 0.3},
              {"drill-28", 0.15, 2, 6.16}, {"saw-piezo-050", 0.20, 5, 0.3},   {"lindemann-016", 0.10, 10, 0.3}};
  for (const auto& row : rows) {
    const auto file = findToolFile(row.id, defaultToolFolders());
    ASSERT_TRUE(file) << file.error().message();
    const auto tool = readTool(*file);
    ASSERT_TRUE(tool) << tool.error().message();
    const HeatSource source = heatSource(*tool);
    EXPECT_EQ(source.share, row.share) << row.id;
    EXPECT_EQ(source.spray_film, row.film) << row.id;
    EXPECT_NEAR(source.least_area, row.least_area, 0.01) << row.id;
    EXPECT_EQ(source.flank.isZero(), tool->kind != ToolKind::kBlade) << row.id;
  }
}

TEST(Heat, AnotherTissueMakesNoJump) {
  Heat heat;
  run(heat, touching(5000, 1, Material::kEnamel), 2);
  const double before = heat.surfaceRise();
  heat.step(touching(5000, 1, Material::kDentin));
  EXPECT_NEAR(heat.surfaceRise(), before, 0.01 * before);
}

TEST(Heat, NoInputMakesItLoseItsSenses) {
  Heat heat;
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf, -1.0, 1e300}) {
    HeatInput in;
    in.is_touching = true;
    in.power = bad;
    in.removed = bad;
    in.irrigation = bad;
    in.place = in.velocity = Vec3d::Constant(bad);
    heat.watch(Heat::kPulp, Vec3d::Constant(bad));
    heat.step(in);
    in.area = bad;
    for (int n = 0; n < 150; ++n) heat.step(in);
    heat.step(in, bad);
    EXPECT_TRUE(std::isfinite(heat.surfaceRise())) << bad;
    EXPECT_TRUE(std::isfinite(heat.riseAt(Vec3d::Constant(bad)))) << bad;
    EXPECT_TRUE(std::isfinite(heat.riseBelow(bad))) << bad;
    EXPECT_TRUE(std::isfinite(heat.rise(Heat::kPulp))) << bad;
  }
}

TEST(Heat, StepsWithoutAllocating) {
  Heat heat;
  const AllocationGuard guard;
  HeatInput in = touching(10, 1, Material::kCortical);
  for (int n = 0; n < 20000; ++n) {
    in.place = Vec3d(0.001 * n, 0, 0);
    heat.watch(Heat::kPulp, in.place);
    heat.step(in);
  }
}

}  // namespace
}  // namespace kerf::heat_test
