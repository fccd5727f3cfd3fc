// Materials of single bricks of an object that differ from its case, after material was added there.
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

/// Whole bricks: each node has a material, inside and outside.
struct MaterialBricks {
  using Numbers = std::array<std::uint8_t, kBrickNodes>;

  double voxel = 0;                           ///< mm
  std::vector<Vec3i> bricks;                  ///< each once, by growing coordKey(), as find() requires
  std::vector<Numbers> numbers;               ///< numbers of these bricks: 1 to 255, in the order of a brick's nodes
  std::map<std::uint8_t, std::string> added;  ///< number and id of the added materials, by the table of that time
  std::filesystem::path file;                 ///< source file, for messages; not stored

  bool isEmpty() const { return bricks.empty(); }
  /// Null: that brick is as in the case.   @cost  O(log n).
  const Numbers* find(const Vec3i& brick) const;
};

/// Reads the int32 grid `material` of a run's file. A file without such a grid has no bricks.
/// Errors with the place: numbers without a material, materials beyond whole bricks, another type, more than a uniform
/// scale, and files with an inconsistent structure. The structure is checked before allocation.
Expected<MaterialBricks> readMaterialBricks(const std::filesystem::path& vdb);

/// Rejects bricks of another case: another voxel size, or a node whose material is neither the case's nor an added one.
/// @param in_case  kNone counts as `fallback`.
/// Error kBadValue with the first place.   @cost  1 us a brick.
Expected<void> requireOnlyAdded(const MaterialBricks& bricks, const MaterialField& in_case, Material fallback);

/// The labels of a case, with these bricks replacing its own.   @pre requireOnlyAdded().
MaterialField laidOver(MaterialField in_case, MaterialBricks bricks);

}  // namespace kerf
