// What kerf_volumes.so gives: ITK behind three functions. For volume_file.cpp, which loads it, and itk_reader.cpp
// alone.
#pragma once

#include "preprocess/volume/volume_file.h"

namespace kerf::internal {

/// The functions do what those of the same name in volume_file.h say.
struct ItkReader {
  const char* version = "";     ///< of the Kerf it was built with
  std::size_t header_size = 0;  ///< sizeof(VolumeHeader): another layout must not be read
  Expected<VolumeHeader> (*read_header)(const std::filesystem::path&, VolumeFormat) = nullptr;
  Expected<void> (*read_values)(const std::filesystem::path&, VolumeFormat, std::byte*, std::uint64_t) = nullptr;
  bool (*is_dicom)(const std::filesystem::path&) = nullptr;
};

}  // namespace kerf::internal

/// Lives as long as the program. Never null.
extern "C" const kerf::internal::ItkReader* kerfItkReader();
