// Samples of a session log, packed without loss: every bit comes back, of NaN and of -0, too.
//
// A hand is smooth, and at rest most of the time. The bits of each of a sample's ten numbers are read as an integer.
// Its distance from the extrapolation of the previous samples (a difference of the first to the fourth order, whichever
// is shortest) is stored as a code of variable length. A number that is constant in all of a record takes no bits at
// all. All arithmetic is on integers, modulo 2^64: any machine packs and unpacks the same. Byte by byte in
// docs/reference/file-formats.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/step/device_sample.h"

namespace kerf::internal {

inline constexpr std::size_t kSampleNumbers = 10;       ///< nine doubles, and whether it is valid
inline constexpr std::size_t kMostPackedSamples = 256;  ///< in one record: bounds the claim of a few bytes

/// The bits of a sample's numbers, in the order in which they stand in a log.
using SampleBits = std::array<std::uint64_t, kSampleNumbers>;

/// State of packing and unpacking after the previous records. Both begin with zeros.
struct SampleHistory {
  static constexpr std::size_t kDepth = 4;
  std::array<SampleBits, kDepth> before{};  ///< the newest first
};

/// The payload of a record.   @param samples  1 to kMostPackedSamples, one a tick.
/// @cost  about 1 us a moving sample, 0.1 us one at rest. For the thread that writes.
std::vector<std::byte> packSamples(std::span<const SampleBits> samples, SampleHistory& history);

/// Inverse: appends to `out`. False for bytes that packSamples() cannot have made; `out` is then unchanged.
bool unpackSamples(std::span<const std::byte> payload, SampleHistory& history, std::vector<SampleBits>& out);

/// From pack()'s bytes, and to bytes for unpackSample() (sim/session/session_format.h).
SampleBits bitsOfSample(const std::byte* packed);
/// False if the last number exceeds 2^32 - 1.
bool isSample(const SampleBits& bits);
DeviceSample sampleOf(const SampleBits& bits);

}  // namespace kerf::internal
