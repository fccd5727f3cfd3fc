// Values that a file holds compressed or as text, followed to their end before ITK gets them: of those it takes what it
// finds, and leaves the rest at zero without a word.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>

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
};

/// Refuses packed values that are cut short, contradict their checksum, or are fewer than the header claims. What
/// follows the values is not looked at, as after values that are not packed. Nothing is kept: the values are unpacked
/// a second time when they are read, which adds about a third to the time.
/// @param values      how many the header claims
/// @param value_bytes the size of one
/// Errors: kBadFormat, kUnreadable, kCancelled.
Expected<void> requireWholeValues(const PackedValues& packed, std::uint64_t values, std::uint64_t value_bytes,
                                  const Progress& progress);

}  // namespace kerf::internal
