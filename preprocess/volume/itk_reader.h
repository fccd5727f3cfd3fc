// Interface of kerf_volumes.so: ITK behind three functions. Only for volume_file.cpp, which loads it, itk_reader.cpp,
// and kerf-slice-trial, which has it inside.
#pragma once

#include "preprocess/volume/volume_file.h"

namespace kerf::internal {

/// See the functions of the same names in volume_file.h.
struct ItkReader {
  const char* version = "";     ///< Kerf version of the build
  std::size_t header_size = 0;  ///< sizeof(VolumeHeader): detects another layout
  Expected<VolumeHeader> (*read_header)(const std::filesystem::path&, VolumeFormat) = nullptr;
  Expected<void> (*read_values)(const std::filesystem::path&, VolumeFormat, std::byte*, std::uint64_t) = nullptr;
  bool (*is_dicom)(const std::filesystem::path&) = nullptr;
};

}  // namespace kerf::internal

/// Lives as long as the program. Never null.
extern "C" const kerf::internal::ItkReader* kerfItkReader();
