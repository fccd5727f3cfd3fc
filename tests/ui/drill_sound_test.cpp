#include "ui/sound/drill_sound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "tests/support/allocation_guard.h"
#include "ui/sound/sound_output.h"

namespace kerf::drill_sound_test {
namespace {

constexpr double kRate = SoundOutput::kRate;
constexpr std::size_t kBlock = 256;
constexpr double kRadPerSecond = 2 * std::numbers::pi / 60;  // of one turn per minute

// A carbide bur with six blades at half volume.
DrillSoundInput bur(double rpm, double load, double nominal_rpm) {
  DrillSoundInput out;
  out.source = {ToolMotion::kSpin, 1 / (2 * std::numbers::pi), nominal_rpm / 60, 6};
  out.now = {rpm * kRadPerSecond, load, Material::kDentin};
  out.volume = 0.7;
  out.is_running = true;
  return out;
}

std::vector<float> heard(DrillSound& sound, const DrillSoundInput& in, double seconds) {
  std::vector<float> out(static_cast<std::size_t>(seconds * kRate));
  for (std::size_t n = 0; n < out.size(); n += kBlock)
    sound.render(in, std::span(out).subspan(n, std::min(kBlock, out.size() - n)));
  return out;
}

double rms(std::span<const float> x) {
  double sum = 0;
  for (const float v : x) sum += static_cast<double>(v) * static_cast<double>(v);
  return std::sqrt(sum / static_cast<double>(x.size()));
}

double largestStep(std::span<const float> x) {
  double most = 0;
  for (std::size_t n = 1; n < x.size(); ++n) most = std::max(most, std::abs(static_cast<double>(x[n] - x[n - 1])));
  return most;
}

// Power at a frequency, Hz, in Hann's window.
double powerAt(std::span<const float> x, double frequency) {
  double re = 0, im = 0;
  for (std::size_t n = 0; n < x.size(); ++n) {
    const double t = static_cast<double>(n);
    const double w = 1 - std::cos(2 * std::numbers::pi * t / static_cast<double>(x.size()));
    const double a = 2 * std::numbers::pi * frequency * t / kRate;
    re += w * static_cast<double>(x[n]) * std::cos(a);
    im += w * static_cast<double>(x[n]) * std::sin(a);
  }
  return re * re + im * im;
}

// The strongest frequency within a fifth of a given one.
double pitchNear(std::span<const float> x, double frequency) {
  double best = 0, most = 0;
  for (double f = 0.8 * frequency; f < 1.2 * frequency; f += 0.001 * frequency)
    if (const double power = powerAt(x, f); power > most) {
      most = power;
      best = f;
    }
  return best;
}

TEST(DrillSound, ItsPitchIsTheSpeedOfTheDrive) {
  for (const double rpm : {30'000.0, 200'000.0, 380'000.0}) {
    DrillSound sound(kRate);
    (void)heard(sound, bur(rpm, 0, 380'000), 0.1);
    const auto steady = heard(sound, bur(rpm, 0, 380'000), 0.5);
    EXPECT_NEAR(pitchNear(steady, rpm / 60), rpm / 60, 0.01 * rpm / 60) << rpm;

    // The speed falls under load, and the pitch with it.
    (void)heard(sound, bur(0.7 * rpm, 0.2, 380'000), 0.12);
    EXPECT_NEAR(sound.frequency(), 0.7 * rpm / 60, 0.01 * 0.7 * rpm / 60) << rpm;
    const auto loaded = heard(sound, bur(0.7 * rpm, 0.2, 380'000), 0.5);
    EXPECT_NEAR(pitchNear(loaded, 0.7 * rpm / 60), 0.7 * rpm / 60, 0.01 * 0.7 * rpm / 60) << rpm;
  }
}

TEST(DrillSound, ItsLevelRisesWithTheLoad) {
  double last = 0;
  for (const double load : {0.0, 0.1, 0.3, 0.6, 1.0}) {
    DrillSound sound(kRate);
    (void)heard(sound, bur(40'000, load, 40'000), 0.2);
    const auto steady = heard(sound, bur(40'000, load, 40'000), 0.5);
    const double level = rms(steady);
    EXPECT_GT(level, 1.05 * last) << load;
    for (const float sample : steady) ASSERT_LE(std::abs(sample), 0.5f) << load;
    last = level;
  }
}

TEST(DrillSound, WithThePedalUpItFadesToNothing) {
  DrillSound sound(kRate);
  DrillSoundInput in = bur(380'000, 0.5, 380'000);
  EXPECT_GT(rms(heard(sound, in, 0.2)), 0.001);
  in.is_running = false;
  const auto end = heard(sound, in, 0.2);
  const auto fade = static_cast<std::size_t>((DrillSound::kFadeSeconds + 0.006) * kRate);
  EXPECT_GT(rms(std::span(end).first(fade / 4)), 0.001) << "it is no cut";
  for (std::size_t n = fade; n < end.size(); ++n) ASSERT_EQ(end[n], 0) << n;
  EXPECT_TRUE(sound.isSilent());

  // Muted means silent.
  in = bur(380'000, 0.5, 380'000);
  in.volume = 0;
  EXPECT_EQ(rms(heard(sound, in, 0.1)), 0);
}

// In any situation, the step between two samples is at most that of the loudest steady sound around it.
TEST(DrillSound, NothingClicks) {
  const DrillSoundInput loud = bur(40'000, 0, 40'000);
  DrillSoundInput other = bur(20'000, 0, 20'000), quiet = loud, off = loud;
  quiet.volume = 0.1;
  off.is_running = false;
  DrillSound steady(kRate);
  (void)heard(steady, loud, 0.2);
  const double most = largestStep(heard(steady, loud, 0.5));

  DrillSound sound(kRate);
  std::vector<float> all;
  for (const DrillSoundInput& in : {loud, off, loud, other, loud, quiet, loud, off, other, off}) {
    const auto part = heard(sound, in, 0.0731);  // in the middle of a block and of a turn
    all.insert(all.end(), part.begin(), part.end());
  }
  EXPECT_GT(most, 0.001);
  EXPECT_LE(largestStep(all), 1.02 * most);
}

TEST(DrillSound, AnotherToolIsHeardAfterTheOneBefore) {
  DrillSound sound(kRate);
  DrillSoundInput in = bur(40'000, 0, 40'000);
  (void)heard(sound, in, 0.2);
  in = bur(20'000, 0, 20'000);
  (void)heard(sound, in, 0.1);
  EXPECT_NEAR(pitchNear(heard(sound, in, 0.4), 20'000 / 60.0), 20'000 / 60.0, 3);
}

TEST(DrillSound, NumbersThatAreNoneAreSilentOrBounded) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  DrillSound sound(kRate);
  for (const double speed : {kNan, kInf, -kInf, 1e300, -4000.0, 0.0})
    for (const double load : {kNan, kInf, -1.0, 9.0})
      for (const double volume : {kNan, -1.0, 7.0}) {
        DrillSoundInput in = bur(0, load, 40'000);
        in.now.speed = speed;
        in.volume = volume;
        for (const float sample : heard(sound, in, 0.01)) ASSERT_TRUE(std::abs(sample) <= 1.0f) << speed << " " << load;
      }
  // No sound remains.
  (void)heard(sound, bur(40'000, 0, 40'000), 0.3);
  EXPECT_NEAR(sound.frequency(), 40'000 / 60.0, 7);
}

TEST(DrillSound, RenderingDoesNotAllocate) {
  DrillSound sound(kRate);
  std::array<float, kBlock> block;
  const AllocationGuard guard;
  for (std::size_t n = 0; n < 50; ++n) {
    DrillSoundInput in = bur(40'000, 0.3, 40'000);
    in.source.teeth = static_cast<double>(n / 20);
    sound.render(in, block);
  }
}

TEST(DrillSound, IsOfTheToolAndTheTick) {
  HapticReport report;
  report.output.speed = 4000;
  report.output.cutting_load = 2.5;
  report.output.material = Material::kEnamel;
  Tool tool;
  ToolDrive drive;
  drive.speed = 5000;
  const DrillSoundInput cutting = drillSoundOf(report, tool, drive, 0.4);
  EXPECT_TRUE(cutting.is_running);
  EXPECT_EQ(cutting.volume, 0.4);
  EXPECT_EQ(cutting.now.load, 0.5);
  EXPECT_EQ(cutting.now.material, Material::kEnamel);

  report.is_latched = true;
  EXPECT_FALSE(drillSoundOf(report, tool, drive, 0.4).is_running);
  report.is_latched = false;
  report.output.speed = 0;
  EXPECT_FALSE(drillSoundOf(report, tool, drive, 0.4).is_running);
}

}  // namespace
}  // namespace kerf::drill_sound_test
