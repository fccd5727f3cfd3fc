// The bricks of an object during cutting: one slot each, found by coordinate, with values copied on change.
//
// A new slot points into the BakedObject. The first write of a stroke makes a version with the brick's own values. Undo
// and redo point the slot at another version. A brick of air gets a slot when material is added to it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "geometry/field/brick_directory.h"
#include "sim/object/node_volumes.h"
#include "sim/object/slot_list.h"

namespace kerf {

/// Slots and their directory. CutObject::write() informs subscribers of changes. One thread; many may read while
/// nothing changes.
class BrickStore {
 public:
  /// Bricks of air that can become solid in a session: 16384, about 8 cm^3 at 0.1 mm, 1 cm^3 at 0.05 mm.
  static constexpr int kMostAdded = 1 << 14;

  enum class Begin { kWithAllBricks, kEmpty };
  /// @param begin  kEmpty: without slots and directory; PieceBuilder makes them. Allocates about 300 B a brick.
  BrickStore(std::shared_ptr<const BakedObject> baked, Begin begin);

  const BakedObject& baked() const noexcept { return *baked_; }
  const std::shared_ptr<const BakedObject>& sharedBaked() const noexcept { return baked_; }

  // Bricks.

  /// Whether this object is a piece of the loaded one.
  bool isPiece() const noexcept { return is_piece_; }
  int slotCount() const noexcept { return static_cast<int>(slots_.size()); }
  /// Number of initial slots; later slots were air. For a piece see has().
  int firstSlotCount() const noexcept { return static_cast<int>(most_slots_) - kMostAdded; }
  /// Upper bound of the number of slots.
  std::size_t mostSlots() const noexcept { return most_slots_; }
  /// Number of bricks of this object.
  std::size_t brickCount() const noexcept { return brick_count_; }
  /// Whether the object has the slot's brick. A piece may keep the slots of the whole, but has its own bricks only.
  bool has(int s) const noexcept { return find(slot(s).brick) == s; }

  const BrickSlot& slot(int s) const noexcept { return slots_[static_cast<std::size_t>(s)]; }
  BrickSlot& slot(int s) noexcept { return slots_[static_cast<std::size_t>(s)]; }
  std::vector<BrickSlot>& slots() noexcept { return slots_; }
  /// Slot of a brick, or -1: air. @rt
  int find(const Vec3i& brick) const noexcept { return directory_.find(brick); }
  /// Calls visit(slot) for the bricks of a box of bricks, in order of their coordinate. @rt
  template <class Visit>
  void forEachIn(const Vec3i& low, const Vec3i& high, const Visit& visit) const noexcept {
    directory_.forEachIn(low, high, visit);
  }
  /// Slot of the brick beyond a face, or -1: air. @rt
  int findBeside(const BrickSlot& slot, int face) const noexcept {
    return directory_.at(directory_.indexBeside(directory_.indexOf(slot.brick), face));
  }
  /// The values of a brick and of the six beside it. @rt
  BrickNeighborhood around(const BrickSlot& slot) const noexcept;
  /// Their materials. @rt
  MaterialNeighborhood materialsAround(const BrickSlot& slot) const noexcept;

  /// Slots whose values or shell differ, or differed, from those loaded. A piece can share all others as loaded.
  const SlotList& touched() const noexcept { return touched_; }

  // Changes. All of it is @rt.

  /// Slot for a brick of air that takes material, all outside. -1: the brick lies farther out than kAirAround, or
  /// kMostAdded bricks were added already.
  int addAir(const Vec3i& brick) noexcept;
  /// Makes the version the slot's own: a copy of the current brick.
  void copyInto(BrickVersion& version, int s, std::uint64_t stroke) noexcept;
  /// Points the slot of a version at it, or at the one before it. @return the faces on which the values differ.
  std::uint8_t swapIn(BrickVersion& version, bool is_undo) noexcept;
  /// The slot's own materials for writing, copied on first use. @pre it has a version of its own of this stroke.
  std::uint8_t* ownMaterials(int s) noexcept;
  void touch(int s) noexcept { touched_.add(slot(s), s); }

  // The whole state. Slow, for results, tests and benches: not @rt.

  /// All current values. Allocates, 2 KB a brick.
  BrickField field() const;
  /// The bricks that differ from the baked ones, as a field of the same kind. For a piece: its own bricks only.
  /// Allocates.
  BrickField changedField() const;
  /// Order-independent hash of changed values and materials: same state, same number. StateHash gives it faster.
  std::uint64_t stateHash() const;
  /// The hash term of a piece's choice of bricks; 0 for other objects.
  std::uint64_t pieceKey() const noexcept { return piece_key_; }
  /// Current volume per material, mm^3, from all nodes: addVolumes().
  std::array<double, 256> countVolumes() const;
  /// Rebuilds every shell from the field. Returns the number of bricks whose shell differs in any bit. For tests.
  std::size_t shellDefects() const;

 private:
  // Fills slots, directory and counts of a piece on many threads: a function for one brick cannot do that.
  friend class PieceBuilder;
  /// For `bricks` bricks and kMostAdded more.
  void reserveSlots(std::size_t bricks);
  void addLoaded(const BakedObject::Slot& from);

  std::shared_ptr<const BakedObject> baked_;
  std::vector<BrickSlot> slots_;
  BrickDirectory directory_;
  SlotList touched_{SlotBit::kTouched};
  std::size_t most_slots_ = 0, brick_count_ = 0;
  bool is_piece_ = false;
  std::uint64_t piece_key_ = 0;
};

}  // namespace kerf
