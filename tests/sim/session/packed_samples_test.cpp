#include "sim/session/packed_samples.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "sim/session/session_format.h"
#include "tests/sim/session_samples.h"

namespace kerf::packed_samples_test {
namespace {

using namespace internal;

SampleBits bitsFor(const DeviceSample& sample) {
  std::array<std::byte, kSampleBytes> packed;
  pack(sample, packed);
  return bitsOfSample(packed.data());
}

// Packs runs of `run` samples in sequence, as records of a log, and unpacks them again.
std::size_t bytesThereAndBack(const std::vector<SampleBits>& samples, std::size_t run) {
  SampleHistory writer, reader;
  std::vector<SampleBits> back;
  std::size_t bytes = 0;
  for (std::size_t at = 0; at < samples.size(); at += run) {
    const auto part = std::span(samples).subspan(at, std::min(run, samples.size() - at));
    const auto payload = packSamples(part, writer);
    bytes += payload.size();
    EXPECT_TRUE(unpackSamples(payload, reader, back)) << at;
  }
  EXPECT_EQ(back, samples);
  return bytes;
}

// A hand that moves in a circle, with a stroke's rotation and its pedal.
std::vector<SampleBits> strokes(std::size_t count) {
  std::vector<SampleBits> out;
  for (std::size_t n = 0; n < count; ++n) {
    const double t = 1e-3 * static_cast<double>(n);
    DeviceSample sample;
    sample.T_world_device.translation = {20 + 3 * std::sin(2 * t), -7 + 3 * std::cos(1.7 * t), 4 + std::sin(5 * t)};
    sample.pedal = n / 500 % 2 ? 1 : 0;
    out.push_back(bitsFor(sample));
  }
  return out;
}

TEST(PackedSamples, EveryBitComesBack) {
  std::vector<SampleBits> awkward, noise, all;
  std::mt19937_64 random(7);
  for (std::uint64_t n = 0; n < 1000; ++n) {
    awkward.push_back(bitsFor(sampleOf(n)));
    SampleBits bits;
    for (std::uint64_t& number : bits) number = random();
    bits.back() &= 0xffffffffu;
    noise.push_back(bits);
    for (std::uint64_t& number : bits) number = n % 2 ? ~std::uint64_t{0} : 0;  // the longest possible paths
    bits.back() &= 0xffffffffu;
    all.push_back(bits);
  }
  for (const std::size_t run : {1, 2, 3, 50, 256}) {
    EXPECT_GT(bytesThereAndBack(awkward, run), 0u);
    EXPECT_LT(bytesThereAndBack(noise, run), 1000u * 95 + 16 * (1000 / run + 1)) << "noise hardly grows";
    EXPECT_GT(bytesThereAndBack(all, run), 0u);
  }
}

TEST(PackedSamples, BytesAreThoseOfTheDocumentedFormat) {
  // By hand from docs/reference/file-formats.md: 5 after zeros folds to 10. 3 low bits and one bit beyond them: 0 1,
  // and 0 1 0.
  SampleBits one{};
  one[4] = 5;
  SampleHistory history;
  const std::vector<std::byte> wanted = {std::byte{1},      {}, std::byte{1 << 4}, {}, std::byte{3 << 2},
                                         std::byte{0b01010}};
  EXPECT_EQ(packSamples(std::span(&one, 1), history), wanted);
}

TEST(PackedSamples, AHandAtRestTakesFourBytesARecord) {
  const std::vector<SampleBits> rest(1000, bitsFor(sampleOf(3)));
  const std::size_t first = bytesThereAndBack({rest.begin(), rest.begin() + 50}, 50);
  EXPECT_EQ(bytesThereAndBack(rest, 50), first + 4 * 19);
}

TEST(PackedSamples, AHandThatMovesTakesAFifthOfWhatItIs) {
  const std::size_t bytes = bytesThereAndBack(strokes(10'000), 50);
  EXPECT_LT(bytes, 10'000u * kSampleBytes / 5);
}

TEST(PackedSamples, BytesThatNobodyPackedAreRefused) {
  SampleHistory writer;
  const auto samples = strokes(60);
  const auto good = packSamples(samples, writer);
  const auto isRefused = [&](std::vector<std::byte> bytes) {
    SampleHistory reader;
    std::vector<SampleBits> out(1);
    const bool is_read = unpackSamples(bytes, reader, out);
    if (is_read) return false;
    EXPECT_EQ(out.size(), 1u) << "what was there before stays";
    EXPECT_EQ(reader.before, SampleHistory{}.before);
    return true;
  };
  EXPECT_FALSE(isRefused(good));
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_TRUE(isRefused({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)})) << size;

  auto bad = good;
  bad.push_back({});
  EXPECT_TRUE(isRefused(bad)) << "bytes after the end";
  bad = good;
  bad[0] = {};
  EXPECT_TRUE(isRefused(bad)) << "no samples";
  bad[1] = std::byte{2};
  EXPECT_TRUE(isRefused(bad)) << "more than a record may hold";
  bad = good;
  bad[3] |= std::byte{4};
  EXPECT_TRUE(isRefused(bad)) << "an eleventh number";

  // All 64 bits of a code, and more.
  EXPECT_TRUE(isRefused({std::byte{1}, {}, std::byte{1}, {}, std::byte{0xfc}, {}, {}, {}, {}, {}, {}, {}, {}, {}}));
  SampleBits no_sample{};
  no_sample.back() = std::uint64_t{1} << 32;
  SampleHistory history;
  EXPECT_TRUE(isRefused(packSamples(std::span(&no_sample, 1), history))) << "valid is a number of 32 bits";
}

}  // namespace
}  // namespace kerf::packed_samples_test
