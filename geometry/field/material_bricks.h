// The materials of single bricks of an object, where they are no longer those of its case: something was added there.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/field/brick_field.h"
#include "geometry/field/material_field.h"

namespace kerf {

/// Name of their grid in a file.
inline constexpr const char* kMaterialGrid = "material";

/// Whole bricks: each of their nodes has a material, whether it is inside or not.
struct MaterialBricks {
  using Numbers = std::array<std::uint8_t, kBrickNodes>;

  double voxel = 0;                           ///< mm
  std::vector<Vec3i> bricks;                  ///< each once, by growing coordKey(): find() asks for that
  std::vector<Numbers> numbers;               ///< of the same: 1 to 255, in the order of a brick's nodes
  std::map<std::uint8_t, std::string> added;  ///< number and id of what was added, by the table of materials then
  std::filesystem::path file;                 ///< that they were read from, for messages; not stored

  bool isEmpty() const { return bricks.empty(); }
  /// Null: that brick is as in the case.   @cost  O(log n).
  const Numbers* find(const Vec3i& brick) const;
};

/// Reads the int32 grid `material` of a run's file. A file without such a grid has no bricks.
/// Refused, with the place: numbers that no material has, materials of more than whole bricks, another type, more than
/// a uniform scale, and files whose structure does not add up: before memory is taken for them.
Expected<MaterialBricks> readMaterialBricks(const std::filesystem::path& vdb);

/// Refuses bricks that were never of this case: another voxel size, or a node whose material is neither the case's nor
/// one of those that were added.   @param in_case  kNone counts as `fallback`.
/// Error kBadValue with the first place.   @cost  1 us a brick.
Expected<void> requireOnlyAdded(const MaterialBricks& bricks, const MaterialField& in_case, Material fallback);

/// The labels of a case with these bricks in the place of its own.   @pre requireOnlyAdded().
MaterialField laidOver(MaterialField in_case, MaterialBricks bricks);

}  // namespace kerf
