// Brick fields to and from OpenVDB files, so that Houdini, Blender and vdb_view open what Kerf stores.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/field/brick_field.h"

namespace kerf {

struct MaterialBricks;

/// What `kerf info` and the readers learn from a .vdb file without loading the voxels.
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
/// Metadata values are written on the file (string to string). Not atomic: callers write into a staging folder.
/// @param materials  become the int32 grid `material`, with what was added as text on it; without bricks, or null:
/// none.
Expected<void> writeVdb(const std::filesystem::path& path, const std::vector<NamedField>& fields,
                        const std::map<std::string, std::string>& metadata = {},
                        const MaterialBricks* materials = nullptr);

/// Reads the float grid `name`. Leaf nodes become bricks; tiles below zero mark interior bricks.
/// Refuses grids whose transform is not a plain uniform scale, values that are no distances, and files whose structure
/// does not add up, before memory is taken for them: a file from a stranger costs no more memory than 40 times its size
/// and what a million bricks deep inside need.
Expected<BrickField> readVdb(const std::filesystem::path& path, const std::string& name);

/// The grids of a file, by name. Reads its header and those of the grids, no voxels, and not by OpenVDB: a damaged
/// file is refused or told wrong of, never a crash. @cost microseconds a grid, whatever its size.
Expected<std::vector<VdbGridInfo>> inspectVdb(const std::filesystem::path& path);

}  // namespace kerf
