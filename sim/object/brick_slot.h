// One brick of an object that is cut: where its values, materials and shell are now.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>

#include "sim/object/baked_object.h"
#include "sim/object/brick_version.h"

namespace kerf {

/// The lists that a slot can be in: bits of BrickSlot::listed.
enum class SlotBit : std::uint8_t {
  kDirty = 1,      ///< its shell is not that of its values: ShellRepair
  kForMesher = 2,  ///< changed since the mesher took it: DirtyLog
  kForPieces = 4,  ///< changed since the finder of pieces took it: DirtyLog
  kHashStale = 8,  ///< its hash term is not that of its values: StateHash
  kTouched = 16    ///< its values or shell are, or were, not those loaded: BrickStore
};

struct BrickSlot {
  Vec3i brick;
  const float* phi = nullptr;               ///< 512 values, baked or own
  float* own = nullptr;                     ///< the same once they changed, else null
  const std::uint8_t* materials = nullptr;  ///< 512 numbers, baked or own
  std::uint8_t* own_materials = nullptr;    ///< the same once material was added, else null
  BrickVersion* version = nullptr;          ///< which holds both of its own, or null
  const float* baked = nullptr;             ///< 512 values as loaded: what undo goes back to
  const std::uint8_t* baked_materials = nullptr;
  /// Its shell. As loaded, it may be there or not: CutObject::needShell().
  std::array<const ShellChunk*, kShellChunks> chunks{};
  std::int16_t shell_count = 0;
  bool owns_shell = false, has_one_material = false;
  std::uint8_t listed = 0;         ///< bits of SlotBit
  std::uint8_t changed_faces = 0;  ///< bits of -x, +x, -y, +y, -z, +z: values there changed since the last repair()
  float least = 0;                 ///< lower bound of the values
  /// The brick can neither touch nor be cut before the tool has moved this far in all, mm on the odometer: distances
  /// change no faster than the tool moves.
  double sleeps_until_contact = -1, sleeps_until_cut = -1;
  std::uint64_t hash_term = 0;   ///< what the brick adds to the hash of the state
  std::uint32_t hash_round = 0;  ///< of repair(), when the brick changed last

  bool isListed(SlotBit bit) const noexcept { return (listed & static_cast<std::uint8_t>(bit)) != 0; }
  /// Whether any value is other than loaded.
  bool hasChangedValues() const noexcept { return own && std::memcmp(own, baked, sizeof(BrickValues)) != 0; }
  /// Whether any material is other than loaded.
  bool hasChangedMaterials() const noexcept {
    return own_materials && std::memcmp(own_materials, baked_materials, kBrickNodes) != 0;
  }
};

}  // namespace kerf
