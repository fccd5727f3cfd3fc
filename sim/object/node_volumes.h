// The volume of each node of a field, as the ledger counts it.
//
// A node stands for its cell, a cube of one voxel around it. The cell counts whole inside and not at all outside.
// Exception: a neighbour along an axis has the other sign. There the surface crosses the edge between the two; linear
// interpolation gives the place, as in the mesher. Let r be the distance to the nearest crossing along an edge, in
// voxels, at most a half: inside a node counts 1/2 + r, outside 1/2 - r.
//
// On a plane that edge is along the axis nearest to its normal. Each column along it is exact, so their sum is exact at
// any scale of the field. Values on other edges do not count: a field that is small, or no distance, far from a change
// of sign has the volume of its mesh. No volume grows when a value grows. Volumes are continuous where the surface
// passes a node.
//
// Volumes are whole numbers of 1 / 65536 of a cell. So sums and differences are exact, and their order does not matter.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "sim/object/baked_object.h"
#include "sim/object/shell_nodes.h"

namespace kerf {

/// Parts of a node's cell: the unit of all volumes here.
inline constexpr int kCellParts = 1 << 16;

/// Materials of the bricks of a BrickNeighborhood, 512 numbers each. Null: a brick of air, without inside nodes.
struct MaterialNeighborhood {
  const std::uint8_t* self;
  const std::uint8_t* face[6];  ///< -x, +x, -y, +y, -z, +z
  bool is_one;                  ///< all of them have one material

  /// @param brick  beyond that face: a slot, of any kind.
  template <class Slot>
  void add(int beyond, const Slot& brick) noexcept {
    face[beyond] = brick.materials;
    is_one = is_one && brick.has_one_material && brick.materials[0] == self[0];
  }
};

/// Per material number, in parts of a cell.
using PartsByNumber = std::array<std::int64_t, 256>;

/// mm^3 of a part.
inline double volumeOfPart(double voxel) { return voxel * voxel * voxel / kCellParts; }

/// Adds parts to a volume that is a sum of parts: exact below 2^50 parts, so that equal gains and losses cancel.
inline double addParts(double volume, std::int64_t parts, double part) {
  return part * static_cast<double>(std::llround(volume / part) + parts);
}

/// Adds the volumes of a brick's nodes, each to the node's material, outside nodes too: no material grows when values
/// grow. Baking labels the nodes on both sides of the surface.   @param band  mm: clamps the values to the value of air
/// without a brick, which thus has no volume beside a deep node. @rt safe. @cost 0.3 us, at a surface 2 us.
void addVolumes(const BrickNeighborhood& bricks, const MaterialNeighborhood& materials, float band,
                PartsByNumber& sum) noexcept;

namespace internal {

/// The nodes with a negative value.
NodeBits insideNodes(const float* values) noexcept;

/// The volumes of `count` nodes.   @param value  of the nodes.   @param beside  of their neighbours, -x, +x, -y, +y,
/// -z, +z. All arrays reach to the next multiple of eight.   @param out  parts of a cell. The same with any instruction
/// set.
void nodeVolumes(const float* value, const float* const beside[6], int count, float band, std::int32_t* out) noexcept;

/// Nodes to be measured. Scratch: 30 KB, uninitialised.
struct SurfaceNodes {
  static constexpr int kMost = kBrickNodes + 6 * kBrickSide * kBrickSide;
  alignas(64) float value[kMost];
  alignas(64) float beside[6][kMost];
  alignas(64) std::int32_t parts[kMost];
  std::uint8_t material[kMost];

  void set(int at, int node, const BrickNeighborhood& bricks) noexcept;
  /// @pre set().
  void label(int at, int node, const MaterialNeighborhood& materials) noexcept;
  void measure(int count, float band) noexcept;
};

}  // namespace internal

/// Effect of a change of one brick's values on volumes: its own, and those of the nodes beside it in other bricks.
/// Scratch of 60 KB for one thread.
class VolumeChange {
 public:
  /// Call before writing anything. Keeps the pointers.
  /// @param changed  the nodes at which `after` differs from the brick's values.
  /// @param materials_after  512 numbers. A number may differ only at a node that was outside and changes its value.
  ///   @rt
  VolumeChange(const BrickNeighborhood& before, const float* after, const internal::NodeBits& changed,
               const MaterialNeighborhood& materials, const std::uint8_t* materials_after, float band) noexcept;

  /// Bits of -x, +x, -y, +y, -z, +z: the bricks in which nodes change their volume, for addBeyond(). @rt
  std::uint8_t faces() const noexcept { return faces_; }
  /// @param brick  beyond that face, before anything is written. @rt
  void addBeyond(int face, const BrickNeighborhood& brick, const MaterialNeighborhood& materials) noexcept;

  /// Volume before minus volume after, in parts of a cell, of all materials. @pre each of faces() was added. @rt
  std::int64_t lost() noexcept;
  /// Whether all of it has one material: the brick's. @rt
  bool isOfOneMaterial() const noexcept { return is_one_; }
  /// Adds the same by material. @pre lost() was called, and isOfOneMaterial() is false. @rt
  void addLost(PartsByNumber& sum) const noexcept;

 private:
  const float* const before_values_;
  const float* const after_values_;
  const std::uint8_t* const materials_before_;
  const std::uint8_t* const materials_after_;
  const float band_;
  bool is_one_;
  std::uint8_t faces_ = 0;
  std::array<std::uint64_t, 6> beyond_;  // of faces_: the nodes, bit 8 a + b, a and b the other axes in their order
  int count_ = 0;
  internal::SurfaceNodes before_, after_;  // the nodes whose volume may change, the same in both
};

}  // namespace kerf
