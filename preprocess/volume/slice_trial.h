// Trial reading of slices in a child process.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "preprocess/volume/volume_file.h"

namespace kerf::internal {

/// The slice libraries abort the program on some broken files (GDCM asserts), and never return on others. So a child
/// process reads every slice first, each within an ample time. False if a slice ended the child.
/// @param max_bytes  does not read files that claim more.
bool survivesReading(const std::vector<std::filesystem::path>& files, VolumeFormat format, std::uint64_t max_bytes);

}  // namespace kerf::internal
