// One object as loaded: baked field, labels, and a directory that finds a brick in one step. Never changes.
//
// shellOf() makes the point shell brick by brick on demand. The whole shell would take as much memory as the field, and
// a tool comes near little of it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/field/brick_directory.h"
#include "geometry/field/brick_field.h"
#include "geometry/field/material_field.h"

namespace kerf {

/// Half-width of the shell in voxels: its nodes are those with |phi| < e = 1.5 h.
inline constexpr double kShellHalfWidth = 1.5;

/// One node of the point shell. Its weight is a smoothed delta of phi, delta = 15 (1 - u^2)^2 / (16 e), u = phi/e. The
/// weights fade in and out as the surface passes. Their sum is the area for any voxel size and any attitude of the grid
/// (after Engquist, Tornberg & Tsai, J Comput Phys 2005;207:28).
///
/// Chunks store nodes as one array per number, for the contact loops.
struct ShellChunk {
  static constexpr int kNodes = 64;
  static constexpr int kMostMore = kBrickNodes / kNodes - 1;
  std::array<float, kNodes> x, y, z;  ///< delta grad(phi) h^3, mm^2, outward; its length is the area of the node
  /// mm, when the shell was built. A copy: a read of the brick's values would touch three times as much memory.
  std::array<float, kNodes> phi;
  std::array<std::uint16_t, kNodes> offset;   ///< of the node in its brick
  std::array<std::uint8_t, kNodes> material;  ///< number
  /// In a brick's first chunk only: the chunks after it. Slots do not hold them: most slots have no shell, and the
  /// pointers would take a third of the slot memory.
  std::array<const ShellChunk*, kMostMore> more;
};
/// Most chunks a brick may have.
inline constexpr int kShellChunks = 1 + ShellChunk::kMostMore;
constexpr int chunkCount(int nodes) { return (nodes + ShellChunk::kNodes - 1) / ShellChunk::kNodes; }

/// Bricks around one: itself and its six face neighbours, 512 values each.
struct BrickNeighborhood {
  const float* self;
  const float* face[6];  ///< -x, +x, -y, +y, -z, +z
};

/// Largest distance from an object at which material can be added, mm.
inline constexpr double kAirAround = 2;

/// Finds the shell nodes of a brick, by offset. Copies of the first node's offset fill up the last chunk.
/// @param out  kShellChunks of them.  @return number of nodes. @rt safe.
int shellOfBrick(const BrickNeighborhood& bricks, const std::uint8_t* materials, double voxel,
                 ShellChunk* out) noexcept;

class BakedObject {
 public:
  /// A brick that can change: every stored or interior brick.
  struct Slot {
    Vec3i brick;
    float least;                    ///< smallest value
    const float* phi;               ///< 512 values; a constant in interior bricks
    const std::uint8_t* materials;  ///< 512 numbers
    std::uint16_t shell_count;      ///< nodes
    bool has_one_material;
  };

  /// @param phi0  baked field.   @param materials  labels on the same grid; null: all `fallback`.
  /// Error kBadValue: an empty field, or one whose box takes more than 2^26 bricks.
  static Expected<std::shared_ptr<const BakedObject>> make(BrickField phi0, const MaterialField* materials,
                                                           Material fallback = Material::kGeneric);
  /// The same. Frees the memory of the labels after copying them.
  static Expected<std::shared_ptr<const BakedObject>> make(BrickField phi0, MaterialField&& materials,
                                                           Material fallback = Material::kGeneric);

  const BrickField& phi0() const { return phi0_; }
  double voxel() const { return phi0_.voxel(); }
  const std::vector<Slot>& slots() const { return slots_; }
  /// Makes the loaded shell of a brick from its loaded values and those of its neighbours.   @param slot  one of
  /// slots().
  /// @param out  kShellChunks of them.  @return number of nodes. @cost 0.5 us. @rt safe.
  int shellOf(const Slot& slot, ShellChunk* out) const noexcept;
  /// Number of chunks of all shells.
  std::size_t shellChunks() const { return shell_chunks_; }
  const float* outsideBrick() const { return outside_.data(); }  ///< values of any brick that is not stored

  /// The slot of a brick of air.
  Slot air(const Vec3i& brick) const {
    return {brick, phi0_.background(), outside_.data(), fallbackMaterials(), 0, true};
  }
  Material fallback() const { return fallback_; }
  const std::uint8_t* fallbackMaterials() const { return uniform_[static_cast<std::size_t>(fallback_)].get(); }

  /// Finds slots by brick coordinate. Covers the object, kAirAround and one more layer of air.
  const BrickDirectory& directory() const { return directory_; }
  const Vec3i& directoryLow() const { return directory_.low(); }
  const Vec3i& directorySize() const { return directory_.size(); }

  /// Volume per material, mm^3: the sum of its nodes' volumes, sim/object/node_volumes.h.
  const std::array<double, 256>& volumes() const { return volumes_; }

 private:
  BakedObject() = default;
  static Expected<std::shared_ptr<BakedObject>> start(BrickField phi0, Material fallback);
  Expected<void> laySlots();
  void label(const MaterialField& materials);
  void countShells();
  void measureVolumes();
  bool isInterior(const Slot& slot) const { return slot.phi == inside_.data(); }
  BrickNeighborhood around(const Slot& slot) const noexcept;

  BrickField phi0_;
  BrickValues outside_{}, inside_{};
  std::vector<Slot> slots_;
  std::size_t shell_chunks_ = 0;
  std::vector<std::array<std::uint8_t, kBrickNodes>> materials_;
  std::array<std::unique_ptr<std::uint8_t[]>, 256> uniform_;
  Material fallback_ = Material::kGeneric;
  BrickDirectory directory_;
  std::array<double, 256> volumes_{};
};

/// The objects of a scene, in their order.
using LoadedObjects = std::vector<std::shared_ptr<const BakedObject>>;

}  // namespace kerf
