// Kinds of files by name, reading at most a few bytes of them.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "geometry/base/error.h"
#include "preprocess/volume/volume_file.h"

namespace kerf::internal {

/// Format of a whole volume in a file, by its extension: NRRD, NIfTI or MetaImage.
std::optional<VolumeFormat> fileFormat(const std::filesystem::path& path);
/// Format of a picture that may be a slice, by its extension: PNG, TIFF or BMP.
std::optional<VolumeFormat> sliceFormat(const std::filesystem::path& path);
/// For people: "NRRD", "PNG slices".
const char* nameOf(VolumeFormat format);

/// The visible files of a folder in natural order: slice-2 before slice-10. Errors: kUnreadable.
Expected<std::vector<std::filesystem::path>> filesOf(const std::filesystem::path& folder);

/// True if the file has "DICM" at byte 128, as every DICOM file on disk has.
bool hasDicomMark(const std::filesystem::path& path);

}  // namespace kerf::internal
