// Images of any number of axes as ITK reads them, without ITK in the header. For label_volume.cpp only. ITK is in a
// library of its own, kerf_volumes.so, which the first call loads: it takes 35 ms and 22 MB, and few commands read a
// volume. ITK brings an Eigen of its own: this header may not include ours, as itk_reader.cpp includes it.
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
std::size_t bytesOf(ValueType type);

struct VolumeHeader {
  std::vector<std::uint64_t> size;  ///< values along each axis, fastest first
  std::vector<double> spacing;      ///< per axis, mm; what ITK made of it
  std::vector<double> origin;       ///< per axis, mm
  std::vector<double> direction;    ///< n x n, row-major; column a is the direction of axis a
  ValueType type = ValueType::kU8;
  unsigned components = 1;  ///< values per voxel
  std::string series;       ///< DICOM series instance UID, else empty
  /// DICOM: whether spacing[0] and [1], and spacing[2], stand in the file. ITK says 1 mm for those that do not.
  bool states_pixel_spacing = true, states_frame_spacing = true;
};

/// Loads the library that reads. To be called before a child process reads, and before isDicom().
/// Errors: kUnsupported if kerf_volumes.so is missing or of another Kerf. Thread-safe, like all that is here.
Expected<void> loadVolumeReader();

/// The header by ITK. @pre checkVolumeHeader() accepted the file, for the formats it knows. Never throws.
Expected<VolumeHeader> readVolumeHeader(const std::filesystem::path& path, VolumeFormat format);
/// All values, in file order (first axis fastest), in the machine's byte order, to `out` of `bytes` bytes.
/// Fails, before anything is written, if header and `bytes` disagree. Never throws.
/// @pre requireWholeValues() accepted what is packed: of a damaged file ITK may read a part and say nothing.
Expected<void> readVolumeValues(const std::filesystem::path& path, VolumeFormat format, std::byte* out,
                                std::uint64_t bytes);
/// True if the file is DICOM, whatever its name. @pre loadVolumeReader() succeeded; false otherwise.
bool isDicom(const std::filesystem::path& path);

/// What the file's own header says, read without ITK, which fills in what is missing and trusts sizes.
struct StatedHeader {
  std::vector<double> spacing;      ///< as stated, one per axis that has one; empty: none is stated
  std::uint64_t stored_bytes = 0;   ///< what the file holds after its header
  std::filesystem::path data_file;  ///< MetaImage: the file with the values, if it is not the header's own
  double most_per_byte = 1;         ///< bytes of values that one stored byte can stand for: 1 raw, 1032 deflate
  PackedValues packed;              ///< where the values are, and how they are written
  std::optional<ValueType> type;    ///< of the stored values, where ITK may make others of them
};
/// NRRD, NIfTI and MetaImage only.
Expected<StatedHeader> checkVolumeHeader(const std::filesystem::path& path, VolumeFormat format);

}  // namespace kerf::internal
