// Read plan of a volume, from headers alone: its files, and their grid.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "preprocess/volume/label_volume.h"
#include "preprocess/volume/volume_file.h"

namespace kerf::internal {

struct VolumePlan {
  VolumeFormat format = VolumeFormat::kNrrd;
  std::vector<std::filesystem::path> files;  ///< along the last axis; one: the whole volume
  VolumeHeader header;                       ///< header of each file
  PackedValues packed{};                     ///< values of a single file
  ValueType stored_type = ValueType::kU8;    ///< type of the packed values; differs from the header where ITK scales
                                             ///< them
  LabelVolume grid;                          ///< without labels
  std::optional<Vec3d> stated_spacing{};     ///< mm, set if the files state it for all axes
  std::string unusable;                      ///< reason for an empty stated_spacing
  /// Spacing that the file states for some axes, for an empty stated_spacing, mm; NaN on the other axes.
  Vec3d known_spacing = Vec3d::Constant(std::numeric_limits<double>::quiet_NaN());
};

/// The plan for a file or a folder, its spacing not yet chosen. Takes 0 to 0.2 of the progress.
Expected<VolumePlan> planVolume(const std::filesystem::path& path, const LabelReadOptions& options,
                                const Progress& progress);

/// Sets the spacing of the plan's grid: the file's, or the given one if the file states none. Makes the directions unit
/// vectors. Errors: kBadValue for a spacing that contradicts the file, or none, or an impossible grid.
Expected<void> chooseSpacing(const std::filesystem::path& path, const LabelReadOptions& options, VolumePlan& plan);

/// For one kind of folder each; called by planVolume().
Expected<VolumePlan> planDicom(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& files,
                               const Progress& progress);

/// Rejects colours and vectors.
Expected<void> requireOneValue(const std::filesystem::path& path, const VolumeHeader& header);
/// Gives the plan's grid the three axes of a header; drops axes of one voxel, trailing ones first.
Expected<void> setGrid(const std::filesystem::path& path, const VolumeHeader& header, VolumePlan& plan);

/// True for a possible voxel size in mm.
bool isUsableSpacing(double spacing);
/// "[0.2, 0.2, 0.5]".
std::string textOf(const Vec3d& v);

}  // namespace kerf::internal
