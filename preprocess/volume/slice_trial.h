// Slices read on trial, in a process of their own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "preprocess/volume/volume_file.h"

namespace kerf::internal {

/// The libraries that read slices end the program on some broken files (GDCM asserts), and never return on others. So a
/// child process reads every slice first, each within an ample time. False if it died of one.
/// @param max_bytes  files that claim more are not read.
bool survivesReading(const std::vector<std::filesystem::path>& files, VolumeFormat format, std::uint64_t max_bytes);

}  // namespace kerf::internal
