// Segmentations of 3D Slicer (.seg.nrrd): a number for each voxel of a grid, a name and a colour for each number.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/types.h"

namespace kerf {

/// A regular grid, perhaps oblique, in mm, LPS. Voxel (i, j, k) is centred at origin + axes * (i, j, k).
struct VoxelGrid {
  std::array<int, 3> size{};                           ///< voxels along each axis, >= 1
  Vec3d origin = Vec3d::Zero();                        ///< mm
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: mm per step along each axis; not singular

  double count() const { return 1.0 * size[0] * size[1] * size[2]; }
  double voxelVolume() const { return std::abs(axes.determinant()); }  ///< mm^3
};

struct Segment {
  std::uint16_t number = 0;  ///< > 0
  std::string id, name;      ///< the id is unique
  Rgba8 color{};             ///< alpha is not written
};

struct Segmentation {
  VoxelGrid grid;
  std::vector<std::uint16_t> numbers;  ///< of the voxels, x fastest; 0: empty space
  std::vector<Segment> segments;       ///< every other number, once
};

/// True for a name that ends in ".seg.nrrd", in any case.
bool isSegmentationFile(const std::filesystem::path& path);

/// Writes NRRD 4, three axes, one layer, packed by gzip, in bytes if no number is above 255, else in 16 bits. Complete
/// or not at all, like writeMesh(). The same segmentation gives the same bytes with the same zlib.
/// Error kWriteFailed.   @cost  10 ns a voxel.
Expected<void> writeSegmentation(const std::filesystem::path& path, const Segmentation& segmentation);

}  // namespace kerf
