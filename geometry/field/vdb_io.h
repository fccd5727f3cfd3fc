// Brick fields to and from OpenVDB files, readable by Houdini, Blender and vdb_view.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/field/brick_field.h"

namespace kerf {

struct MaterialBricks;

/// Header of a grid in a .vdb file, for `kerf info` and the readers, without voxels.
struct VdbGridInfo {
  std::string name, type;  ///< "phi", "Tree_float_5_4_3"
  double voxel = 0;        ///< mm
  std::uint64_t active_voxels = 0;
};

/// One field under its name.
struct NamedField {
  std::string name;
  const BrickField* field = nullptr;
};

/// Writes fields as float level-set grids with uniform scale `voxel` and no offset; all stored nodes are active,
/// interior bricks become tiles.
/// Metadata become file metadata (string to string). Not atomic: callers write into a staging folder.
/// @param materials  become the int32 grid `material`, with the added materials as text on it; without bricks, or null:
/// none.
Expected<void> writeVdb(const std::filesystem::path& path, const std::vector<NamedField>& fields,
                        const std::map<std::string, std::string>& metadata = {},
                        const MaterialBricks* materials = nullptr);

/// Reads the float grid `name`. Leaf nodes become bricks; tiles below zero mark interior bricks.
/// Rejects grids whose transform is not a plain uniform scale, values that are no distances, and files with an
/// inconsistent structure. The structure is checked before allocation. An untrusted file costs at most 40 times its
/// size in memory, plus the memory of a million inner bricks.
Expected<BrickField> readVdb(const std::filesystem::path& path, const std::string& name);

/// The grids of a file, by name. Reads its header and those of the grids, no voxels, without OpenVDB: a damaged file
/// gives an error or wrong information, never a crash. @cost microseconds a grid, at any size.
Expected<std::vector<VdbGridInfo>> inspectVdb(const std::filesystem::path& path);

}  // namespace kerf
