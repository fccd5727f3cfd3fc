// Samples of a session log, packed without loss: every bit comes back, of NaN and of -0, too.
//
// A hand is smooth, and at rest most of the time. The bits of each of a sample's ten numbers are taken for an integer.
// What is stored of it is how far it is from where the samples before lead (a difference of the first to the fourth
// order, whichever is shortest), as a code of variable length. A number that stays as it was in all of a record takes
// no bits at all. Integers alone are computed with, modulo 2^64: any machine packs and unpacks the same.
// Byte by byte in docs/reference/file-formats.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/step/device_sample.h"

namespace kerf::internal {

inline constexpr std::size_t kSampleNumbers = 10;       ///< nine doubles, and whether it is valid
inline constexpr std::size_t kMostPackedSamples = 256;  ///< in one record: what few bytes can claim stays bounded

/// The bits of a sample's numbers, in the order in which they stand in a log.
using SampleBits = std::array<std::uint64_t, kSampleNumbers>;

/// What packing and unpacking know from the records before. Both begin with zeros.
struct SampleHistory {
  static constexpr std::size_t kDepth = 4;
  std::array<SampleBits, kDepth> before{};  ///< the newest first
};

/// The payload of a record.   @param samples  1 to kMostPackedSamples, one a tick.
/// @cost  about 1 us a sample that moves, 0.1 us one at rest. For the thread that writes.
std::vector<std::byte> packSamples(std::span<const SampleBits> samples, SampleHistory& history);

/// The way back: appends to `out`. False for bytes that packSamples() can not have made; `out` is then as it was.
bool unpackSamples(std::span<const std::byte> payload, SampleHistory& history, std::vector<SampleBits>& out);

/// From what pack() wrote, and to what unpackSample() reads (sim/session/session_format.h).
SampleBits bitsOfSample(const std::byte* packed);
/// A last number above 2^32 - 1 is no sample's.
bool isSample(const SampleBits& bits);
DeviceSample sampleOf(const SampleBits& bits);

}  // namespace kerf::internal
