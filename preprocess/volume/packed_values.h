// Values that a file holds raw, compressed or as text. Raw and compressed ones are read here, a slice at a time; others
// are followed to their end before ITK gets them: of those it takes what it finds, and leaves the rest at zero without
// a word.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <span>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"

namespace kerf::internal {

enum class Packing {
  kNone,  ///< bytes as they are; or an encoding that ITK follows to its end itself
  kGzip,  ///< one gzip stream or several, one after the other
  kZlib,  ///< one zlib stream, or one gzip stream
  kText,  ///< numbers with blanks between them
};

/// Where the packed values of a volume are.
struct PackedValues {
  Packing packing = Packing::kNone;
  std::filesystem::path file;
  std::uint64_t from = 0;                                           ///< the first packed byte in the file
  std::uint64_t bytes = std::numeric_limits<std::uint64_t>::max();  ///< packed bytes; fewer if the file ends before
  std::uint64_t ahead = 0;                                          ///< bytes that come out before the first value
  bool is_plain = false;    ///< nothing else has to be known to read them: see readSlices()
  bool is_swapped = false;  ///< plain: not in this machine's byte order
};

/// Takes the values of one slice after the other, in this machine's byte order.
using SliceSink = std::function<Expected<void>(std::size_t slice, std::span<const std::byte> values)>;

/// Hands plain values to `sink`, a slice at a time; holds one slice. Refuses them as requireWholeValues() does; what
/// the sink has got by then is of no use.
/// @pre packed.is_plain   Errors: kBadFormat, kUnreadable, kCancelled, those of `sink`.
Expected<void> readSlices(const PackedValues& packed, std::size_t slices, std::size_t values_per_slice,
                          std::size_t value_bytes, const SliceSink& sink, const Progress& progress);

/// Refuses packed values that are cut short, contradict their checksum, or are fewer than the header claims. What
/// follows the values is not looked at, as after values that are not packed. Nothing is kept: the values are unpacked
/// a second time when they are read, which adds about a third to the time.
/// @param values      how many the header claims
/// @param value_bytes the size of one
/// Errors: kBadFormat, kUnreadable, kCancelled.
Expected<void> requireWholeValues(const PackedValues& packed, std::uint64_t values, std::uint64_t value_bytes,
                                  const Progress& progress);

}  // namespace kerf::internal
