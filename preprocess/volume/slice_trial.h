// Trial reading of slices in another process.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "geometry/base/progress.h"
#include "preprocess/volume/itk_reader.h"

namespace kerf::internal {

/// The slice libraries abort the program on some broken files (GDCM asserts), and never return on others. So the
/// program kerf-slice-trial, beside kerf_volumes.so, reads every slice first, each within an ample time. The host is
/// never forked: it may have threads, signal handlers and memory locks of its own.
/// @param max_bytes  does not read files that claim more.
/// @return false if a slice ended that program.   Errors: kCancelled, within 0.1 s; kUnsupported if it cannot start.
Expected<bool> survivesReading(const std::vector<std::filesystem::path>& files, VolumeFormat format,
                               std::uint64_t max_bytes, const Progress& progress = {});

/// The work of that program: reads the files. Limits time and memory of this process; exceeding them ends it.
/// @return false if a file made the library take far more memory than the file justifies.
bool readEverySlice(const ItkReader& reader, const std::vector<std::filesystem::path>& files, VolumeFormat format,
                    std::uint64_t max_bytes);

}  // namespace kerf::internal
