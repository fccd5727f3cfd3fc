// What every node of a field stands for: the volume that the ledger counts.
//
// A node stands for its cell, a cube of one voxel about it. The cell counts whole inside and not at all outside, but
// where a neighbour along an axis has the other sign. There the surface crosses the edge between the two, at the place
// that linear interpolation gives, as the mesher has it. Let r be the distance to the nearest crossing along an edge,
// in voxels, at most a half: inside a node counts 1/2 + r, outside 1/2 - r.
//
// Of a plane that edge is along the axis nearest to its normal. Columns along it are right one by one, so their sum is,
// whatever the scale of the field. Values on other edges do not count: a field that is small, or no distance, far from
// a change of sign has the volume of its mesh. No volume grows when a value does, and where the surface passes a node
// volumes are continuous.
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

/// Materials of the bricks of a BrickNeighborhood, 512 numbers each. Null: a brick of air, which has no inside.
struct MaterialNeighborhood {
  const std::uint8_t* self;
  const std::uint8_t* face[6];  ///< -x, +x, -y, +y, -z, +z
  bool is_one;                  ///< all of them are of one material

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

/// Adds parts to a volume that is the sum of such: exact below 2^50 parts, so that what comes and goes leaves nothing.
inline double addParts(double volume, std::int64_t parts, double part) {
  return part * static_cast<double>(std::llround(volume / part) + parts);
}

/// Adds the volumes of a brick's nodes, each to the material of the node, outside too: so no material grows when values
/// do. Baking labels the nodes on both sides of the surface.   @param band  mm: values count as no farther than this,
/// that of air without a brick, which so has no volume beside what is deep. @rt safe. @cost 0.3 us, at a surface 2 us.
void addVolumes(const BrickNeighborhood& bricks, const MaterialNeighborhood& materials, float band,
                PartsByNumber& sum) noexcept;

namespace internal {

/// The nodes with a negative value.
NodeBits insideNodes(const float* values) noexcept;

/// The volumes of `count` nodes.   @param value  of the nodes.   @param beside  of their neighbours, -x, +x, -y, +y,
/// -z, +z. All arrays reach to the next multiple of eight.   @param out  parts of a cell. The same with any instruction
/// set.
void nodeVolumes(const float* value, const float* const beside[6], int count, float band, std::int32_t* out) noexcept;

/// Nodes whose volume is to be measured. Scratch: 30 KB, not set to anything.
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

/// What changing the values of one brick does to volumes: its own, and those of the nodes beside it in others. Scratch
/// of 60 KB for one thread.
class VolumeChange {
 public:
  /// Before anything is written. Keeps the pointers.
  /// @param changed  the nodes at which `after` differs from the brick's values.
  /// @param materials_after  512 numbers. One that differs is of a node that was outside, and changes its value. @rt
  VolumeChange(const BrickNeighborhood& before, const float* after, const internal::NodeBits& changed,
               const MaterialNeighborhood& materials, const std::uint8_t* materials_after, float band) noexcept;

  /// Bits of -x, +x, -y, +y, -z, +z: the bricks in which nodes change their volume, to be added. @rt
  std::uint8_t faces() const noexcept { return faces_; }
  /// @param brick  beyond that face, as it is before anything is written. @rt
  void addBeyond(int face, const BrickNeighborhood& brick, const MaterialNeighborhood& materials) noexcept;

  /// What was there less what is there now, in parts of a cell, of all materials. @pre each of faces() was added. @rt
  std::int64_t lost() noexcept;
  /// Whether all of that is of one material: the brick's. @rt
  bool isOfOneMaterial() const noexcept { return is_one_; }
  /// The same by material: adds it. @pre lost() was called, and it is not of one material. @rt
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
