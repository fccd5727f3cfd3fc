// Trim files: the parts of a scan that were cut away before closing. Each case has one as trim.toml, if any were.
//
//   format = "kerf-trim"
//   version = 1
//
//   [[trim]]                           # beyond a plane
//   point = [0, 0, 5]                  # mm, of the scan
//   normal = [0, 0, 1]                 # everything on its side goes
//
//   [[trim]]                           # a closed line drawn over a view, through the whole scan
//   remove = "inside"                  # or "outside"
//   direction = [0, 0, -1]             # of the view
//   eye = [0, 0, 200]                  # mm; perspective views only
//   outline = [[0, 0, 5], [10, 0, 5], [10, 8, 5]]   # mm
#pragma once

#include <filesystem>
#include <vector>

#include "geometry/base/error.h"
#include "preprocess/close/scan_trim.h"

namespace kerf {

/// Strict, as all of Kerf's TOML files. Directions of any length but zero; a unit direction keeps its bits.
/// @param file  a trim file, or a case that has one.
/// Errors: kBadFormat and kBadValue, with file, line and key; kNotFound for a case without trims.
Expected<std::vector<ScanTrim>> readTrims(const std::filesystem::path& file);
Expected<void> writeTrims(const std::filesystem::path& file, std::span<const ScanTrim> trims);

}  // namespace kerf
