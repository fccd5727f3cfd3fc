// Images of any number of axes, read by ITK, without ITK in the header. For label_volume.cpp only. ITK is in a separate
// library, kerf_volumes.so, loaded by the first call: it takes 35 ms and 22 MB, and few commands read a volume. ITK has
// its own Eigen: this header must not include Kerf's, as itk_reader.cpp includes it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "preprocess/volume/packed_values.h"

namespace kerf::internal {

enum class VolumeFormat { kNrrd, kNifti, kMetaImage, kDicom, kPng, kTiff, kBmp };
enum class ValueType { kU8, kI8, kU16, kI16, kU32, kI32, kU64, kI64, kF32, kF64 };
constexpr std::size_t bytesOf(ValueType type) {
  constexpr std::size_t kBytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kBytes[static_cast<std::size_t>(type)];
}

struct VolumeHeader {
  std::vector<std::uint64_t> size;  ///< values along each axis, fastest first
  std::vector<double> spacing;      ///< per axis, mm; as interpreted by ITK
  std::vector<double> origin;       ///< per axis, mm
  std::vector<double> direction;    ///< n x n, row-major; column a is the direction of axis a
  ValueType type = ValueType::kU8;
  unsigned components = 1;  ///< values per voxel
  std::string series;       ///< DICOM series instance UID, else empty
  /// DICOM: whether spacing[0] and [1], and spacing[2], stand in the file. ITK reports 1 mm for missing ones.
  bool states_pixel_spacing = true, states_frame_spacing = true;
};

/// Loads the reader library. Call before isDicom().
/// Errors: kUnsupported if kerf_volumes.so is missing or of another Kerf. Thread-safe, like all functions here.
Expected<void> loadVolumeReader();
/// Folder of the reader library.   Errors: as loadVolumeReader().
Expected<std::filesystem::path> volumeReaderFolder();

/// The header by ITK. @pre checkVolumeHeader() accepted the file, for the formats it knows. Never throws.
Expected<VolumeHeader> readVolumeHeader(const std::filesystem::path& path, VolumeFormat format);
/// All values, in file order (first axis fastest), in the machine's byte order, to `out` of `bytes` bytes.
/// Fails, before any write, if header and `bytes` disagree. Never throws.
/// @pre requireWholeValues() accepted the packed values: ITK may silently read a part of a damaged file.
Expected<void> readVolumeValues(const std::filesystem::path& path, VolumeFormat format, std::byte* out,
                                std::uint64_t bytes);
/// True if the file is DICOM, by content. @pre loadVolumeReader() succeeded; false otherwise.
bool isDicom(const std::filesystem::path& path);

/// The file's own header, read without ITK, which fills in missing fields and trusts sizes.
struct StatedHeader {
  std::vector<double> spacing;      ///< as in the header, one per axis that has one; empty: none
  std::uint64_t stored_bytes = 0;   ///< size of the file after its header
  std::filesystem::path data_file;  ///< MetaImage: the file with the values, if it is not the header's own
  double most_per_byte = 1;         ///< largest number of value bytes per stored byte: 1 raw, 1032 deflate
  PackedValues packed;              ///< place and encoding of the values
  std::optional<ValueType> type;    ///< type of the stored values, where ITK may convert them
};
/// NRRD, NIfTI and MetaImage only.
Expected<StatedHeader> checkVolumeHeader(const std::filesystem::path& path, VolumeFormat format);

}  // namespace kerf::internal
