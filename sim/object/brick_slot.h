// One brick of an object during cutting: where its current values, materials and shell are.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>

#include "sim/object/baked_object.h"
#include "sim/object/brick_version.h"

namespace kerf {

/// The lists that a slot can be in: bits of BrickSlot::listed.
enum class SlotBit : std::uint8_t {
  kDirty = 1,      ///< its shell is out of date: ShellRepair
  kForMesher = 2,  ///< changed since the mesher took it: DirtyLog
  kForPieces = 4,  ///< changed since the piece finder took it: DirtyLog
  kHashStale = 8,  ///< its hash term is out of date: StateHash
  kTouched = 16    ///< its values or shell differ, or differed, from those loaded: BrickStore
};

/// An object at 0.05 mm has a million slots, most of which never change. The struct has no padding.
struct BrickSlot {
  Vec3i brick;
  float least = 0;                          ///< lower bound of the values
  const float* phi = nullptr;               ///< 512 values, baked or own
  float* own = nullptr;                     ///< the same after a change, else null
  const std::uint8_t* materials = nullptr;  ///< 512 numbers, baked or own
  std::uint8_t* own_materials = nullptr;    ///< the same after material was added, else null
  BrickVersion* version = nullptr;          ///< holds `own` and `own_materials`; or null
  const float* baked = nullptr;             ///< 512 values as loaded: undo goes back to these
  const std::uint8_t* baked_materials = nullptr;
  /// The first chunk of its shell. A loaded shell can be missing: CutObject::needShell().
  const ShellChunk* shell = nullptr;
  std::int16_t shell_count = 0;
  std::uint8_t listed = 0;             ///< bits of SlotBit
  std::uint8_t changed_faces : 6 = 0;  ///< bits of -x, +x, -y, +y, -z, +z: values there changed since the last repair()
  bool owns_shell : 1 = false, has_one_material : 1 = false;
  std::uint32_t hash_round = 0;  ///< number of the repair() at the brick's last change
  /// The tool cannot touch or cut the brick before the odometer reaches this, mm: a distance changes no faster than the
  /// tool moves.
  double sleeps_until_contact = -1, sleeps_until_cut = -1;
  std::uint64_t hash_term = 0;  ///< the brick's term in the state hash

  /// @pre the shell is there and has more than `n` chunks. @rt
  const ShellChunk& chunk(std::size_t n) const noexcept { return n == 0 ? *shell : *shell->more[n - 1]; }
  /// Sets the shell to these chunks. Empty: no shell, or the loaded one is not made yet. @rt
  void setShell(std::span<ShellChunk* const> chunks) noexcept {
    shell = chunks.empty() ? nullptr : chunks[0];
    for (std::size_t n = 1; n < chunks.size(); ++n) chunks[0]->more[n - 1] = chunks[n];
  }

  bool isListed(SlotBit bit) const noexcept { return (listed & static_cast<std::uint8_t>(bit)) != 0; }
  /// Whether any value differs from the loaded one.
  bool hasChangedValues() const noexcept { return own && std::memcmp(own, baked, sizeof(BrickValues)) != 0; }
  /// Whether any material differs from the loaded one.
  bool hasChangedMaterials() const noexcept {
    return own_materials && std::memcmp(own_materials, baked_materials, kBrickNodes) != 0;
  }
};
static_assert(sizeof(BrickSlot) == 112);

}  // namespace kerf
