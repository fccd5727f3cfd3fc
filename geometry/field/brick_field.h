// Sparse scalar field on a regular grid, stored in bricks of 8^3 nodes found by a spatial hash of the brick coordinate.
//
// Node (i, j, k) stands at voxel * (i, j, k) mm in the object's frame. A brick is one OpenVDB leaf node: same size,
// same node order (z fastest), so fields go to and from .vdb files by copying. Without a stored brick the field is
// constant: `background` outside, -`background` in bricks marked as interior.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/field/brick_index.h"

namespace kerf {

inline constexpr int kBrickLog = 3;
inline constexpr int kBrickSide = 1 << kBrickLog;
inline constexpr int kBrickNodes = kBrickSide * kBrickSide * kBrickSide;

using BrickValues = std::array<float, kBrickNodes>;

/// Offset of a node inside its brick, z fastest. Negative coordinates wrap the right way (two's complement).
constexpr int nodeOffset(int i, int j, int k) { return ((i & 7) << 6) | ((j & 7) << 3) | (k & 7); }
/// Brick that holds a node: floor(node / 8).
inline Vec3i brickOf(const Vec3i& node) { return {node[0] >> kBrickLog, node[1] >> kBrickLog, node[2] >> kBrickLog}; }

/// The field. Reading is safe from many threads; adding bricks is not, writing into different bricks is.
class BrickField {
 public:
  BrickField() = default;
  /// @param voxel  node spacing, mm, > 0.   @param background  value far outside, mm, > 0.
  /// @param interior  value deep inside, mm, < 0; minus the background unless given.
  BrickField(double voxel, float background) : BrickField(voxel, background, -background) {}
  BrickField(double voxel, float background, float interior)
      : voxel_(voxel), background_(background), interior_(interior) {}

  double voxel() const { return voxel_; }
  float background() const { return background_; }
  float interior() const { return interior_; }
  /// As the constructor's. @pre no brick is marked interior
  void setInterior(float value) { interior_ = value; }
  std::size_t brickCount() const { return coords_.size(); }
  bool isEmpty() const { return coords_.empty(); }

  Vec3d position(const Vec3i& node) const { return voxel_ * node.cast<double>(); }
  /// Coordinate of brick b (in bricks); its first node is 8 times that.
  const Vec3i& brickCoord(std::size_t b) const { return coords_[b]; }
  const BrickValues& brick(std::size_t b) const { return values_[b]; }
  BrickValues& brick(std::size_t b) { return values_[b]; }

  /// Index of the brick at a brick coordinate, or -1: no brick there.
  int find(const Vec3i& brick_coord) const { return index_.find(brick_coord); }
  /// Values of the brick at a brick coordinate; null: no brick there. Good until a brick is added.
  const BrickValues* valuesAt(const Vec3i& brick_coord) const {
    const int b = find(brick_coord);
    return b < 0 ? nullptr : &values_[static_cast<std::size_t>(b)];
  }
  /// The constant that stands for a missing brick.
  float constantAt(const Vec3i& brick_coord) const { return index_.isInterior(brick_coord) ? interior_ : background_; }
  /// Value at a node: O(1), one hash look-up.
  float at(const Vec3i& node) const {
    const Vec3i c = brickOf(node);
    const int b = find(c);
    return b < 0
               ? constantAt(c)
               : values_[static_cast<std::size_t>(b)][static_cast<std::size_t>(nodeOffset(node[0], node[1], node[2]))];
  }
  /// The brick at a coordinate, created if missing, filled with the constant of that place.
  std::size_t touch(const Vec3i& brick_coord);
  /// Adds a brick with these values. @pre none is there yet.
  std::size_t add(const Vec3i& brick_coord, std::span<const float, kBrickNodes> values);
  /// Marks a missing brick as lying wholly inside.
  void markInterior(const Vec3i& brick_coord) { index_.markInterior(brick_coord); }
  /// Coordinates of the bricks marked as interior and not stored, sorted.
  std::vector<Vec3i> interiorBricks() const { return index_.interior(); }
  void reserve(std::size_t bricks) {
    coords_.reserve(bricks);
    values_.reserve(bricks);
    index_.reserve(bricks);
  }

  /// Trilinear value at a point, mm.
  double sample(const Vec3d& p) const;
  /// Box of all stored nodes, mm; empty when there is none.
  Box3 bounds() const;
  /// Order-independent hash of all stored bricks: same field, same number, on any thread count.
  std::uint64_t stateHash() const;

 private:
  double voxel_ = 0;
  float background_ = 0, interior_ = 0;
  std::vector<Vec3i> coords_;
  std::vector<BrickValues> values_;
  BrickIndex index_;
};

}  // namespace kerf
