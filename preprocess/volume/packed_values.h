// Values that a file holds raw, compressed or as text. This file reads raw and compressed values, a slice at a time. It
// checks other encodings to their end before ITK reads them, because ITK silently leaves missing values at zero.
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
  kNone,  ///< plain bytes; or an encoding that ITK itself checks to its end
  kGzip,  ///< one or several consecutive gzip streams
  kZlib,  ///< one zlib stream, or one gzip stream
  kText,  ///< numbers with blanks between them
};

/// Place and encoding of the packed values of a volume.
struct PackedValues {
  Packing packing = Packing::kNone;
  std::filesystem::path file;
  std::uint64_t from = 0;                                           ///< the first packed byte in the file
  std::uint64_t bytes = std::numeric_limits<std::uint64_t>::max();  ///< packed bytes; fewer if the file ends before
  std::uint64_t ahead = 0;                                          ///< unpacked bytes before the first value
  bool is_plain = false;    ///< readSlices() can read them without further information
  bool is_swapped = false;  ///< plain: not in this machine's byte order
};

/// Takes the values of one slice after the other, in this machine's byte order.
using SliceSink = std::function<Expected<void>(std::size_t slice, std::span<const std::byte> values)>;

/// Hands plain values to `sink`, a slice at a time; holds one slice. Errors as requireWholeValues(); after an error the
/// slices already handed over are invalid.
/// @pre packed.is_plain   Errors: kBadFormat, kUnreadable, kCancelled, those of `sink`.
Expected<void> readSlices(const PackedValues& packed, std::size_t slices, std::size_t values_per_slice,
                          std::size_t value_bytes, const SliceSink& sink, const Progress& progress);

/// Rejects packed values that are truncated, contradict their checksum, or are fewer than the header claims. Ignores
/// bytes after the values, as for unpacked values. Keeps nothing: reading unpacks the values again, which adds about a
/// third to the time.
/// @param values      number of values in the header
/// @param value_bytes size of one value
/// Errors: kBadFormat, kUnreadable, kCancelled.
Expected<void> requireWholeValues(const PackedValues& packed, std::uint64_t values, std::uint64_t value_bytes,
                                  const Progress& progress);

}  // namespace kerf::internal
