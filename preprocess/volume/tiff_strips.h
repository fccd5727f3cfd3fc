// Checks that a TIFF picture holds all of its values. libtiff stops unpacking a strip once it has the needed values: it
// does not reach the checksum behind them, and a changed bit silently becomes another label.
#pragma once

#include <filesystem>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"

namespace kerf::internal {

/// Walks the directories of a TIFF, classic or BigTIFF, without libtiff. Rejects strips outside the file or fewer than
/// the picture's rows. Unpacks deflate strips to their end, and rejects them if truncated, if they contradict their
/// checksum (Adler-32), or hold fewer values than the picture claims. LZW, PackBits and plain values have no checksum:
/// a changed bit stays undetected, unless libtiff runs out of values. Rejects pictures in tiles, because ITK makes
/// colours of them.
/// @param progress  called between parts of a strip; its fraction is meaningless.
/// @cost  reads the file once; for deflate, one more unpacking than reading the values.
/// Errors: kUnreadable, kBadFormat, kUnsupported, kCancelled; never throws.
Expected<void> requireWholeStrips(const std::filesystem::path& path, const Progress& progress);

}  // namespace kerf::internal
