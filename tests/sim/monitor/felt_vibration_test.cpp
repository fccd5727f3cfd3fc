#include "sim/monitor/felt_vibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "geometry/tool/tool_file.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/places.h"

namespace kerf::felt_vibration_test {
namespace {

using Kind = FeltSource::Kind;

constexpr double kRadPerSecond = 2 * std::numbers::pi / 60;  // of one turn per minute

FeltSource spinning(Kind kind, double rpm) {
  return {kind, 1 / (2 * std::numbers::pi), rpm * kRadPerSecond, {1, 0, 0}};
}

// Felt vibration after the start phase.
std::vector<double> steady(const FeltSource& source, double speed_share, double load, Material material,
                           double rate = 1000, double seconds = 20) {
  FeltVibration vibration(source, rate);
  const FeltInput in{speed_share * source.free_speed, load, material};
  std::vector<double> out(static_cast<std::size_t>(seconds * rate));
  for (int n = 0; n < rate; ++n) vibration.next(in);
  for (double& sample : out) sample = vibration.next(in);
  return out;
}

double rms(const std::vector<double>& x) {
  double sum = 0;
  for (const double v : x) sum += v * v;
  return std::sqrt(sum / static_cast<double>(x.size()));
}

double largest(const std::vector<double>& x) {
  double most = 0;
  for (const double v : x) most = std::max(most, std::abs(v));
  return most;
}

// Share of the power between two frequencies, by Fourier transform of pieces of a second.
double shareBetween(const std::vector<double>& x, double rate, double low, double high) {
  const auto size = static_cast<std::size_t>(rate);
  double inside = 0, all = 0;
  for (std::size_t begin = 0; begin + size <= x.size(); begin += size)
    for (double f = 2; f < rate / 2; f += 2) {
      double re = 0, im = 0;
      for (std::size_t n = 0; n < size; ++n) {
        const double a = 2 * std::numbers::pi * f * static_cast<double>(n) / rate;
        re += x[begin + n] * std::cos(a);
        im += x[begin + n] * std::sin(a);
      }
      all += re * re + im * im;
      if (f >= low && f <= high) inside += re * re + im * im;
    }
  return inside / all;
}

double amplitude(const std::vector<double>& x, double rate, double frequency) {
  double re = 0, im = 0;
  for (std::size_t n = 0; n < x.size(); ++n) {
    const double a = 2 * std::numbers::pi * frequency * static_cast<double>(n) / rate;
    re += x[n] * std::cos(a);
    im += x[n] * std::sin(a);
  }
  return 2 * std::hypot(re, im) / static_cast<double>(x.size());
}

TEST(FeltVibration, AnIdleToolIsNotFelt) {
  for (const Kind kind : {Kind::kTurbine, Kind::kMotor, Kind::kDrill, Kind::kSaw})
    EXPECT_LT(largest(steady(spinning(kind, 20000), 1, 0, Material::kEnamel)), 1e-5);
}

TEST(FeltVibration, NoiseOfATurbineIsASharesOfTheLoad) {
  const FeltSource turbine = spinning(Kind::kTurbine, 380000);
  for (const double rate : {1000.0, 4000.0})
    for (const double load : {0.2, 1.0, 3.0}) {
      EXPECT_NEAR(rms(steady(turbine, 0.6, load, Material::kEnamel, rate)) / load, 0.02, 0.001) << rate << " " << load;
      EXPECT_NEAR(rms(steady(turbine, 0.03, load, Material::kEnamel, rate)) / load, 0.08, 0.006) << rate << " " << load;
    }
}

TEST(FeltVibration, MostOfTheNoiseIsWhereSkinFeelsBest) {
  for (const double rate : {1000.0, 2000.0}) {
    const auto samples = steady(spinning(Kind::kTurbine, 380000), 0.6, 1, Material::kEnamel, rate, 4);
    EXPECT_GT(shareBetween(samples, rate, 50, 300), 0.6) << rate;
    EXPECT_GT(shareBetween(samples, rate, 0, 400), 0.8) << rate;
    EXPECT_LT(shareBetween(samples, rate, 0, 10), 0.03) << rate;
  }
}

TEST(FeltVibration, AStalledToolIsQuiet) {
  EXPECT_LT(largest(steady(spinning(Kind::kTurbine, 380000), 0, 3, Material::kEnamel)), 1e-5);
}

TEST(FeltVibration, ToneOfAMotorIsAtItsTurns) {
  const auto slow = steady(spinning(Kind::kMotor, 20000), 0.6, 2, Material::kDentin);  // 200 Hz
  EXPECT_NEAR(amplitude(slow, 1000, 200) / 2, 0.0075, 0.001);
  const auto fast = steady(spinning(Kind::kMotor, 200000), 1, 2, Material::kDentin);  // 3.3 kHz folds back to 333 Hz
  EXPECT_LT(amplitude(fast, 1000, 333.3) / 2, 0.001);
}

TEST(FeltVibration, LipsOfADrillPassTwiceATurn) {
  const auto drill = steady(spinning(Kind::kDrill, 1500), 1, 10, Material::kCancellous);  // limited to 0.5 N
  EXPECT_NEAR(amplitude(drill, 1000, 50) / 10, 0.02, 0.003);
  EXPECT_NEAR(rms(steady(spinning(Kind::kDrill, 150), 1, 4, Material::kCortical)) / 4, 0.05, 0.004);
}

TEST(FeltVibration, AStrokeOfASawIsFeltAtItsCycles) {
  const FeltSource saw{Kind::kSaw, 1 / 6.0, 1080, {0, 0, 1}};  // 3 mm, 10 800 a minute
  EXPECT_NEAR(amplitude(steady(saw, 1, 5, Material::kCortical), 1000, 180) / 5, 0.04, 0.004);
}

TEST(FeltVibration, TheStartIsAKick) {
  FeltVibration vibration(spinning(Kind::kTurbine, 380000));
  const double speed = 380000 * kRadPerSecond;
  double most = 0, sum = 0, last = 0;
  for (int n = 0; n < 20; ++n) EXPECT_EQ(vibration.next({0, 0, Material::kDentin}), 0);
  for (int n = 0; n < 200; ++n) {
    last = vibration.next({speed, 0, Material::kDentin});
    most = std::max(most, std::abs(last));
    sum += last;
  }
  EXPECT_GT(most, 0.01);
  EXPECT_LE(most, 0.02);
  EXPECT_LT(std::abs(sum) / 200, 0.0005);
  EXPECT_EQ(last, 0);
}

TEST(FeltVibration, NoInputMakesItLeaveItsBounds) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf, 1e300, -1e300})
    for (const double rate : {1000.0, bad}) {
      FeltVibration vibration({Kind::kSaw, bad, bad, {1, 0, 0}}, rate);
      FeltVibration sane(spinning(Kind::kTurbine, 380000), rate);
      for (int n = 0; n < 100; ++n) {
        EXPECT_LE(std::abs(vibration.next({bad, bad, Material::kEnamel})), FeltVibration::kMost);
        EXPECT_LE(std::abs(sane.next({bad, bad, Material::kEnamel})), FeltVibration::kMost);
      }
    }
}

TEST(FeltVibration, RackToolsAreFeltAsWhatTheyAre) {
  const auto kindOf = [](const char* id) {
    const auto tool = readTool(std::filesystem::path(kSourceFolder) / "assets/tools" / (std::string(id) + ".toml"));
    EXPECT_TRUE(tool) << id;
    return feltSource(*tool, defaultDrive(*tool)).kind;
  };
  EXPECT_EQ(kindOf("round-014"), Kind::kTurbine);
  EXPECT_EQ(kindOf("drill-20"), Kind::kDrill);
  EXPECT_EQ(kindOf("lindemann-016"), Kind::kMotor);
  EXPECT_EQ(kindOf("saw-reciprocating-25"), Kind::kSaw);
}

TEST(FeltVibration, RendersWithoutAllocating) {
  FeltVibration vibration(spinning(Kind::kDrill, 1500));
  const AllocationGuard guard;
  for (int n = 0; n < 1000; ++n) vibration.next({100, 3, Material::kCortical});
}

}  // namespace
}  // namespace kerf::felt_vibration_test
