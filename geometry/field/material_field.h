// The labels of a baked object: the material of every node.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "geometry/base/error.h"
#include "geometry/field/material.h"

namespace kerf {

/// Node (i, j, k) stands at voxel * (i, j, k) mm, as in the distance field beside it. Copies share the labels.
class MaterialField {
 public:
  struct Grid;
  explicit MaterialField(std::shared_ptr<const Grid> grid);

  double voxel() const;  ///< mm
  /// kNone outside the object and its shell. Any thread; about 50 ns.
  Material at(const Vec3i& node) const;
  /// The material of a whole brick, kNone included; empty if it has several. Any thread; about 50 ns.
  std::optional<Material> oneOf(const Vec3i& brick) const;
  /// The numbers of a whole brick's materials, in the order of its nodes (brick_field.h); those above 255 as 0. True if
  /// all of them are the same. Any thread; microseconds.
  bool copyBrick(const Vec3i& brick, std::span<std::uint8_t, 512> out) const;
  /// Material of the node nearest to a point, mm; if that is kNone, of the nearest labelled one within two voxels.
  Material near(const Vec3d& p) const;

 private:
  std::shared_ptr<const Grid> grid_;
};

/// Reads the int32 grid `material` of a .vdb file. Errors: no such grid, another type, more than a uniform scale.
Expected<MaterialField> readMaterialField(const std::filesystem::path& vdb);

}  // namespace kerf
