// Slices read on trial, in a process of their own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "preprocess/volume/volume_file.h"

namespace kerf::internal {

/// The libraries that take slices apart end the program on some broken files, and never end on others (GDCM asserts,
/// for one). So a child process reads every slice first, each within a time that is ample. False if it died of one.
/// @param max_bytes  files that claim more are not read.
bool survivesReading(const std::vector<std::filesystem::path>& files, VolumeFormat format, std::uint64_t max_bytes);

}  // namespace kerf::internal
