// A segmented CT or CBCT: one label per voxel, on a grid that may be oblique in space.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/base/types.h"

namespace kerf {

/// Labels on a regular grid. Each line along x stores only the voxels from its first to its last label: a jaw in a head
/// takes a fraction of two bytes per voxel. Voxel (i, j, k) is centred at toWorld((i, j, k)); label 0 is empty space.
/// World: mm, LPS (x to the patient's left, y to the back, z to the head), as DICOM and ITK have it; files that store
/// RAS (NIfTI, NRRD with such a space) are converted. Files that name no space keep their own axes.
struct LabelVolume {
  std::array<int, 3> size{};      ///< voxels along each axis, >= 1
  Vec3d spacing = Vec3d::Ones();  ///< mm along each grid axis, finite, > 0
  Vec3d origin = Vec3d::Zero();   ///< mm, centre of voxel (0, 0, 0)
  /// Columns: unit vectors along the grid's axes. Usually a rotation; may be left-handed (a mirrored grid) or slightly
  /// sheared, never singular.
  Eigen::Matrix3d direction = Eigen::Matrix3d::Identity();
  /// A line along x: its labels from voxel `begin` up to `end` are those of the slice from number `first` on.
  struct Row {
    std::uint64_t first = 0;
    int begin = 0, end = 0;
  };
  struct Slice {
    std::vector<Row> rows;  ///< size[1] of them; none where the slice has no label
    std::vector<std::uint16_t> labels;
  };
  std::vector<Slice> slices;      ///< size[2] of them once the volume is whole
  std::string format;             ///< "NRRD", "NIfTI", "MetaImage", "DICOM", "PNG slices", ...
  bool is_spacing_given = false;  ///< the spacing came from the caller, not from the file

  /// Adds the next slice along z. @param labels  size[0] * size[1] of them, x fastest.
  void addSlice(std::span<const std::uint16_t> labels);

  std::uint16_t at(int i, int j, int k) const {
    const Slice& slice = slices[static_cast<std::size_t>(k)];
    if (slice.rows.empty()) return 0;
    const Row& row = slice.rows[static_cast<std::size_t>(j)];
    if (i < row.begin || i >= row.end) return 0;
    return slice.labels[row.first + static_cast<std::uint64_t>(i - row.begin)];
  }
  /// Columns: mm per step along each grid axis.
  Eigen::Matrix3d axes() const { return direction * spacing.asDiagonal(); }
  Vec3d toWorld(const Vec3d& index) const { return origin + axes() * index; }
  double voxelVolume() const;  ///< mm^3, > 0
};

struct LabelCount {
  std::uint16_t label = 0;
  std::uint64_t voxels = 0;
};
/// Every label that occurs, 0 included, in rising order, with its number of voxels.
std::vector<LabelCount> countLabels(const LabelVolume& volume);

struct LabelReadOptions {
  /// mm along the grid's axes. Required for slice pictures, and for files with no spacing or an unusable one (not a
  /// number, zero, negative). A usable spacing in the file that differs by more than 0.1 % is an error, never
  /// overridden. (A NIfTI file with an unusable spacing is an error: ITK can not read it.)
  std::optional<Vec3d> spacing_mm{};
  /// Makes labels from intensities: 1 where the value is at least this, else 0. Without it the values are the labels.
  std::optional<double> threshold{};
  std::uint64_t max_bytes = 6ull << 30;  ///< rejects, before allocating, a volume that needs more during reading
  /// Rejects a volume that needs more than 4/5 of this; empty: of the machine's free memory.
  std::optional<std::uint64_t> available_bytes{};
};

/// Reads a volume. By name: `.nrrd`, `.nii`, `.nii.gz`, `.mha`, `.mhd` (with its raw file beside it), or a folder: a
/// DICOM series, or slices as `.png`, `.tif`, `.tiff` or `.bmp`, stacked along z in natural order (slice-2 before
/// slice-10).
/// Errors name the cause: more than three axes of more than one voxel; several values per voxel (colour, vectors);
/// values that are no labels, unless `threshold` is given (fractions, negative, above 65535, more than 256 different
/// ones, or more than 32 of which neighbours mostly differ, as densities do); pictures beside DICOM slices; missing or
/// doubled DICOM slices; several series in one folder; files shorter than their header claims; packed data that
/// contradicts its checksum. (Raw values and DICOM have no checksum: changed bits stay undetected.)
/// @return the volume. Errors: kNotFound, kUnreadable, kBadFormat, kBadValue, kUnsupported, kCancelled; never throws.
/// @cost  360 x 360 x 330 from .nii.gz: about 0.5 s. Reads raw or compressed values in one file slice by slice; other
/// encodings (text, frames of DICOM) need all values in memory at once.   @thread any.
Expected<LabelVolume> readLabelVolume(const std::filesystem::path& path, const LabelReadOptions& options = {},
                                      const Progress& progress = {});

/// Summary of a volume with labels or intensities.
struct VolumeSummary {
  LabelVolume grid;  ///< without labels
  double lowest = 0, highest = 0;
};
/// Reads all values for their range. Errors: as readLabelVolume(), except values that are no labels.
Expected<VolumeSummary> summariseVolume(const std::filesystem::path& path, const LabelReadOptions& options = {},
                                        const Progress& progress = {});

/// ", but in its sub-folders: CT/axial (120 slices), CT/scout (1 slice)": folders with slices, down to four levels;
/// empty if none. @return text for messages.
std::string textOfSliceFolders(const std::filesystem::path& folder);

/// "label 3 (x low, z high)": labels that touch faces of their volume, with a flat cut surface there.
/// @param labels  empty: all.   @return empty if no label touches a face.
std::string textOfCutLabels(const LabelVolume& volume, std::span<const std::uint16_t> labels = {});

/// Files of a volume: the file itself, then for `.mhd` the raw file it names.
Expected<std::vector<std::filesystem::path>> filesOfVolume(const std::filesystem::path& path);

/// True for a file name that readLabelVolume() treats as a volume, and for a folder with slices of either kind.
bool isLabelVolume(const std::filesystem::path& path);

}  // namespace kerf
