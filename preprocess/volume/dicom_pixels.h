// Checks that a DICOM file holds all of its pixels. GDCM does not: for a truncated file it returns stale memory.
#pragma once

#include <filesystem>

#include "geometry/base/error.h"

namespace kerf::internal {

/// Walks the elements of a DICOM file up to its pixels, without GDCM. Rejects a file that ends before its pixels, or
/// has fewer pixels than rows, columns and frames state, or has compressed pixels without an end of the fragment
/// sequence. Accepts unknown encodings (no mark "DICM", deflated) if the file is large enough, and files without
/// pixels: GDCM rejects files without a picture. DICOM has no pixel checksum: changed bits stay undetected.
/// @cost  reads the elements before the pixels, not the pixels.   Errors: kUnreadable, kBadFormat; never throws.
Expected<void> requireWholePixels(const std::filesystem::path& path);

}  // namespace kerf::internal
