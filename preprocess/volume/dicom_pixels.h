// Whether a DICOM file holds all of its pixels. GDCM does not ask: of a file that is cut short it returns what was in
// memory before.
#pragma once

#include <filesystem>

#include "geometry/base/error.h"

namespace kerf::internal {

/// Walks the elements of a DICOM file up to its pixels, without GDCM. Refuses one that ends before its pixels do, or
/// that has fewer of them than rows, columns and frames say; of compressed pixels, one whose sequence of fragments has
/// no end. Files in ways of writing that the walk does not know (no mark "DICM", deflated) are let through if they are
/// large enough, and files without pixels: GDCM refuses those, if they are no picture at all. Pixels have no checksum
/// in DICOM: a changed bit among them can not be told.
/// @cost  the elements before the pixels are read, not the pixels.   Errors: kUnreadable, kBadFormat; never throws.
Expected<void> requireWholePixels(const std::filesystem::path& path);

}  // namespace kerf::internal
