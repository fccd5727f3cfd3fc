#include "sim/monitor/vibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "geometry/tool/tool_file.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/places.h"

namespace kerf::vibration_test {
namespace {

constexpr double kRadPerSecond = 2 * std::numbers::pi / 60;  // of one turn per minute

VibrationSource bur(double teeth, double nominal_rpm) {
  return {ToolMotion::kSpin, 1 / (2 * std::numbers::pi), nominal_rpm / 60, teeth};
}
// A micro saw of 3 mm stroke.
VibrationSource saw(double cycles_per_minute) { return {ToolMotion::kStroke, 1 / 6.0, cycles_per_minute / 60, 3}; }

// Samples of a steady state, tick by tick, as requested by the step.
std::vector<float> steady(const VibrationSource& source, double rate, double speed, double load, double seconds = 1) {
  Vibration vibration(source, rate);
  std::vector<float> start(static_cast<std::size_t>(rate / 10)), out(static_cast<std::size_t>(seconds * rate));
  vibration.render({speed, load, Material::kDentin}, start);
  for (std::size_t n = 0; n < out.size();) {
    // Ticks of a millisecond with all samples that fit: 44 or 45 at 44.1 kHz.
    const std::size_t end =
        std::min(out.size(), static_cast<std::size_t>((std::floor(n / rate * 1000 + 0.5) + 1) * rate / 1000));
    vibration.render({speed, load, Material::kDentin}, std::span(out).subspan(n, end - n));
    n = end;
  }
  return out;
}
// Amplitude at a frequency, Hz: one bin of a Fourier transform, in Hann's window.
double amplitude(const std::vector<float>& x, double rate, double frequency) {
  double re = 0, im = 0, sum = 0;
  for (std::size_t n = 0; n < x.size(); ++n) {
    const double t = static_cast<double>(n);
    const double w = 1 - std::cos(2 * std::numbers::pi * t / static_cast<double>(x.size()));
    const double a = 2 * std::numbers::pi * frequency * t / rate;
    re += w * static_cast<double>(x[n]) * std::cos(a);
    im += w * static_cast<double>(x[n]) * std::sin(a);
    sum += w;
  }
  return 2 * std::hypot(re, im) / sum;
}
double peakBetween(const std::vector<float>& x, double rate, double low, double high, double step) {
  double best = low, most = 0;
  for (double f = low; f <= high; f += step)
    if (const double a = amplitude(x, rate, f); a > most) {
      most = a;
      best = f;
    }
  return best;
}
double mean(const std::vector<float>& x) {
  double sum = 0;
  for (const float v : x) sum += static_cast<double>(v);
  return sum / static_cast<double>(x.size());
}
double largest(const std::vector<float>& x) {
  float most = 0;
  for (const float v : x) most = std::max(most, std::abs(v));
  return static_cast<double>(most);
}
double rms(const std::vector<float>& x) {
  double sum = 0;
  for (const float v : x) sum += static_cast<double>(v) * static_cast<double>(v);
  return std::sqrt(sum / static_cast<double>(x.size()));
}

TEST(Vibration, BurTurnsAtItsFrequency) {  // goal G19: 1 %
  for (const double rate : {4000.0, 44100.0, 48000.0})
    for (const double rpm : {20000.0, 40000.0, 64321.0}) {
      const auto x = steady(bur(6, rpm), rate, rpm * kRadPerSecond, 0.3, 0.25);
      const double f = rpm / 60;
      EXPECT_NEAR(peakBetween(x, rate, 0.7 * f, 1.3 * f, f / 200), f, 0.01 * f) << rate << " Hz, " << rpm << " rpm";
    }
}

TEST(Vibration, SawsCyclesAreBetween160And210Hertz) {
  for (const double cycles : {9800.0, 11200.0, 12600.0}) {
    const auto x = steady(saw(cycles), 4000, 2 * 3 * cycles / 60, 0.5);
    const double f = peakBetween(x, 4000, 100, 300, 0.5);
    EXPECT_NEAR(f, cycles / 60, 0.01 * f);
    EXPECT_GE(f, 160);
    EXPECT_LE(f, 212);
  }
}

TEST(Vibration, TeethAreHeardUnderLoadOnly) {
  const double speed = 40000 * kRadPerSecond, f = 40000.0 / 60;
  const auto idle = steady(bur(6, 40000), 48000, speed, 0), busy = steady(bur(6, 40000), 48000, speed, 1);
  EXPECT_LT(amplitude(idle, 48000, 6 * f), 1e-4);
  EXPECT_NEAR(amplitude(busy, 48000, 6 * f), 0.2, 0.03);
  EXPECT_NEAR(amplitude(busy, 48000, 12 * f), 0.1, 0.03);
  EXPECT_GT(amplitude(busy, 48000, f), amplitude(idle, 48000, f));
}

TEST(Vibration, NoiseGrowsWithLoadAndWithTheMaterialsHardness) {
  const double speed = 40000 * kRadPerSecond;
  double last = -1;
  for (const double load : {0.0, 0.25, 0.5, 1.0}) {
    const double loud = rms(steady(bur(0, 40000), 48000, speed, load));
    EXPECT_GT(loud, last);
    last = loud;
  }
  const auto high_part = [&](Material material) {
    Vibration vibration(bur(0, 40000), 48000);
    std::vector<float> x(48000);
    vibration.render({speed, 1, material}, x);
    vibration.render({speed, 1, material}, x);
    double sum = 0;
    for (double f = 8000; f < 9000; f += 10) sum += std::pow(amplitude(x, 48000, f), 2);
    return sum;
  };
  EXPECT_GT(high_part(Material::kEnamel), 2 * high_part(Material::kCaries));
}

TEST(Vibration, MeanIsZeroAndAmplitudeBounded) {  // goal G19: 1 %
  for (const double rate : {4000.0, 48000.0})
    for (const double load : {0.0, 0.5, 1.0})
      for (const VibrationSource& source : {bur(6, 40000), bur(0, 20000), saw(12000)}) {
        const auto x = steady(source, rate, source.nominal_frequency / source.cycles_per_speed, load);
        EXPECT_LE(std::abs(mean(x)), 0.01 * largest(x)) << rate << " Hz, load " << load;
        EXPECT_LE(largest(x), 1);
        EXPECT_GT(largest(x), 0.05);
      }
}

TEST(Vibration, RestIsSilent) {
  Vibration vibration(bur(6, 40000), 48000);
  std::vector<float> x(48000);
  vibration.render({0, 0, Material::kDentin}, x);
  EXPECT_EQ(largest(x), 0);
}

// The maximum slope of a sum of these tones. A jump of phase or size would exceed it.
TEST(Vibration, ChangesOfSpeedAndLoadMakeNoClick) {
  constexpr double kRate = 48000;
  Vibration vibration(bur(0, 40000), kRate);
  std::vector<float> x(48);
  float last = 0;
  double steepest = 0;
  for (int tick = 0; tick < 2000; ++tick) {
    // Without load, so without noise. Speed in steps from tick to tick.
    vibration.render({40000 * kRadPerSecond * (0.5 + 0.5 * std::sin(0.05 * tick)), 0, Material::kDentin}, x);
    for (const float v : x) {
      steepest = std::max(steepest, static_cast<double>(std::abs(v - last)));
      last = v;
    }
  }
  const double f = 40000.0 / 60, w = 2 * std::numbers::pi * f / kRate;
  EXPECT_LE(steepest, 1.02 * 0.4 * (0.25 * w + 0.1 * 2 * w));
}

TEST(Vibration, WhatTheRateCannotCarryIsLeftOut) {
  // 200 000 rpm at 4 kHz: the tone of 3333 Hz would alias to 667.
  const auto x = steady(bur(6, 200000), 4000, 200000 * kRadPerSecond, 0);
  EXPECT_LT(largest(x), 1e-6);
}

TEST(Vibration, SameInputsSameBits) {
  const auto a = steady(bur(6, 40000), 44100, 4000, 0.7), b = steady(bur(6, 40000), 44100, 4000, 0.7);
  EXPECT_EQ(a, b);
  // As numbers, to detect a different system or compiler.
  std::uint64_t hash = 14695981039346656037u;
  for (const float v : a) hash = (hash ^ std::bit_cast<std::uint32_t>(v)) * 1099511628211u;
  EXPECT_EQ(hash, 9109773133947693407u);
}

TEST(Vibration, NoInputMakesItLeaveItsBounds) {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<float> x(480);
  for (const double rate : {0.0, -1.0, nan, inf, 100.0, 48000.0})
    for (const double bad : {nan, inf, -inf, -1.0, 1e300}) {
      Vibration vibration({ToolMotion::kStroke, bad, bad, bad}, rate);
      Vibration sane(bur(6, 40000), rate);
      for (int n = 0; n < 3; ++n) {
        vibration.render({bad, bad, static_cast<Material>(250)}, x);
        EXPECT_TRUE(std::all_of(x.begin(), x.end(), [](float v) { return std::abs(v) <= 1; }));
        sane.render({bad, bad, Material::kEnamel}, x);
        EXPECT_TRUE(std::all_of(x.begin(), x.end(), [](float v) { return std::abs(v) <= 1; }));
      }
    }
}

TEST(Vibration, RackToolsSoundAtTheirDrivesFrequency) {
  const std::filesystem::path rack = std::filesystem::path(kSourceFolder) / "assets/tools";
  int spinning = 0, stroking = 0;
  for (const auto& entry : std::filesystem::directory_iterator(rack)) {
    if (entry.path().extension() != ".toml") continue;
    const auto tool = readTool(entry.path());
    ASSERT_TRUE(tool) << tool.error().message();
    const ToolDrive drive = defaultDrive(*tool);
    const VibrationSource source = vibrationSource(*tool, drive);
    EXPECT_GT(source.nominal_frequency, 0) << tool->id;
    if (source.motion == ToolMotion::kSpin) {
      ++spinning;
      EXPECT_NEAR(source.nominal_frequency, drive.speed / (2 * std::numbers::pi), 1e-9) << tool->id;
    } else if (tool->motion == findBladeMotion("reciprocating") && tool->stroke_mm <= 10) {
      ++stroking;
      EXPECT_NEAR(source.nominal_frequency, 200, 1e-9) << tool->id;
      EXPECT_GT(source.teeth, 0) << tool->id;
    }
  }
  EXPECT_GT(spinning, 10);
  EXPECT_GT(stroking, 0);
}

TEST(Vibration, RendersWithoutAllocating) {
  Vibration vibration(bur(6, 40000), 48000);
  std::vector<float> x(48);
  const AllocationGuard guard;
  for (int n = 0; n < 100; ++n) vibration.render({4000, 0.01 * n, Material::kEnamel}, x);
}

}  // namespace
}  // namespace kerf::vibration_test
