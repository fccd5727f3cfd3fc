#include "ui/sound/sound_thread.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>

#include "ui/sound/alsa_output.h"

namespace kerf::sound_thread_test {
namespace {

using namespace std::chrono_literals;

// Sound output of a test. It accepts all samples at once, unlike a sound card.
struct Ear {
  std::atomic<std::uint64_t> samples{0};
  std::atomic<double> loudest{0};  // of the newest block
  std::atomic<bool> is_gone{false};
};

class EarOutput final : public SoundOutput {
 public:
  explicit EarOutput(Ear& ear) : ear_(ear) {}
  Expected<void> write(std::span<const float> samples) override {
    if (ear_.is_gone) return fail({.code = Error::Code::kUnsupported, .place = "sound", .found = "pulled out"});
    double loudest = 0;
    for (const float sample : samples) loudest = std::max(loudest, std::abs(static_cast<double>(sample)));
    ear_.loudest = loudest;
    ear_.samples += samples.size();
    return {};
  }

 private:
  Ear& ear_;
};

OpenSound openEar(Ear& ear) {
  return [&ear]() -> Expected<std::unique_ptr<SoundOutput>> { return std::make_unique<EarOutput>(ear); };
}

DrillSoundInput running() {
  DrillSoundInput out;
  out.source = {ToolMotion::kSpin, 1 / (2 * std::numbers::pi), 700, 6};
  out.now = {2 * std::numbers::pi * 700, 0.5, Material::kDentin};
  out.volume = 1;
  out.is_running = true;
  return out;
}

template <class What>
bool becomes(const What& what) {
  for (int n = 0; n < 2000; ++n) {
    if (what()) return true;
    std::this_thread::sleep_for(5ms);
  }
  return false;
}

TEST(SoundThread, PlaysTheNewestThatItWasTold) {
  Ear ear;
  SoundThread thread(openEar(ear));
  EXPECT_TRUE(becomes([&] { return ear.samples > 1000; }));
  EXPECT_EQ(ear.loudest, 0);
  EXPECT_TRUE(becomes([&] {
    thread.play(running());
    return ear.loudest > 0.05;
  }));
  EXPECT_TRUE(becomes([&] {
    thread.play({});
    return ear.loudest == 0;
  }));
  EXPECT_FALSE(thread.takeError());
}

TEST(SoundThread, WhoSaysNothingMoreIsNotHeardForEver) {
  Ear ear;
  SoundThread thread(openEar(ear));
  EXPECT_TRUE(becomes([&] {
    thread.play(running());
    return ear.loudest > 0.05;
  }));
  EXPECT_TRUE(becomes([&] { return ear.loudest == 0; }));
}

TEST(SoundThread, WithoutADeviceItIsSilentAndSaysSoOnce) {
  SoundThread thread([]() -> Expected<std::unique_ptr<SoundOutput>> {
    return fail({.code = Error::Code::kUnsupported, .place = "sound", .found = "no sound card"});
  });
  std::optional<Error> error;
  EXPECT_TRUE(becomes([&] {
    thread.play(running());
    error = thread.takeError();
    return error.has_value();
  }));
  EXPECT_NE(error->message().find("no sound card"), std::string::npos);
  thread.play(running());
  EXPECT_FALSE(thread.takeError());
}

TEST(SoundThread, ADeviceThatIsPulledOutEndsIt) {
  Ear ear;
  SoundThread thread(openEar(ear));
  EXPECT_TRUE(becomes([&] { return ear.samples > 0; }));
  ear.is_gone = true;
  EXPECT_TRUE(becomes([&] { return thread.takeError().has_value(); }));
}

// At real-time rate with any consumer: more would waste a core.
TEST(SoundThread, RendersNoFasterThanItIsHeard) {
  Ear ear;
  const auto began = std::chrono::steady_clock::now();
  SoundThread thread(openEar(ear));
  std::this_thread::sleep_for(300ms);
  const double samples = static_cast<double>(ear.samples);
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  EXPECT_GT(samples, 0);
  EXPECT_LE(samples, (elapsed + SoundThread::kMostAheadSeconds) * SoundOutput::kRate + 2 * SoundThread::kBlock);
}

TEST(SoundThread, RestsInSilenceAndStartsAgain) {
  Ear ear;
  SoundThread thread(openEar(ear));
  std::uint64_t before = 0;
  EXPECT_TRUE(becomes([&] {
    const bool rests = ear.samples > SoundOutput::kRate / 2 && ear.samples == before;
    before = ear.samples;
    std::this_thread::sleep_for(30ms);
    return rests;
  }));
  EXPECT_TRUE(becomes([&] {
    thread.play(running());
    return ear.loudest > 0.05;
  }));
}

// With a sound card or without one.
TEST(SoundThread, TheDeviceOfThisMachineIsOpenedOrRefusedWithAReason) {
  auto output = openAlsa();
  if (!output) {
    EXPECT_EQ(output.error().code, Error::Code::kUnsupported);
    EXPECT_NE(output.error().message().find("sound"), std::string::npos) << output.error().message();
    return;
  }
  const std::vector<float> silence(SoundThread::kBlock);
  EXPECT_TRUE((*output)->write(silence));
}

}  // namespace
}  // namespace kerf::sound_thread_test
