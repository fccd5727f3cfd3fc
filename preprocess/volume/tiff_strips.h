// Whether a TIFF picture holds all of its values. libtiff stops to unpack a strip when it has the values it needs: the
// checksum behind them is not reached, and a bit that changed becomes another label without a word.
#pragma once

#include <filesystem>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"

namespace kerf::internal {

/// Walks the directories of a TIFF, classic or BigTIFF, without libtiff. Refuses strips that lie outside of the file or
/// are fewer than the picture has rows. Strips by deflate are unpacked to their end: refused if they are cut short, if
/// they contradict their checksum (Adler-32), or are fewer values than the picture claims. LZW, PackBits and values as
/// they are have no checksum: a changed bit among them can not be told, unless libtiff runs out of values. Pictures in
/// tiles are refused, because ITK makes colours of them.
/// @param progress  asked between parts of a strip; its number is not of use.
/// @cost  the file is read once; of deflate it is unpacked once more than the values are read.
/// Errors: kUnreadable, kBadFormat, kUnsupported, kCancelled; never throws.
Expected<void> requireWholeStrips(const std::filesystem::path& path, const Progress& progress);

}  // namespace kerf::internal
