// One object while it is cut: the current field and its point shell, brick by brick, copied from the baked one where
// they change.
//
// A façade over parts with one duty each:
//
//   BrickStore   which bricks there are, and where their values are now
//   BrickMemory  memory for versions of bricks, shells and records of strokes, reserved beforehand
//   ShellRepair  which shells are not those of their values, and their repair
//   LoadedShells the shells of bricks that did not change, made where the tool is
//   DirtyLog     what a subscriber (mesher, finder of pieces) has not been told yet
//   StrokeLog    what was written since the last stroke ended: what undo takes back
//   StateHash    the hash of the state, brick by brick
//
// A write goes through this class, which tells each of them; what they know is read from them.
//
// Belongs to one thread. Everything the 1 kHz step calls is marked @rt: no allocation, lock, exception or system call.
// When the memory runs out the step says so and goes on without cutting further bricks. Their overlap stays, and is
// cut as soon as reserve() or BrickMemory::take() has been called.
#pragma once

#include <array>
#include <memory>

#include "sim/object/brick_faces.h"
#include "sim/object/brick_memory.h"
#include "sim/object/brick_store.h"
#include "sim/object/cut_area.h"
#include "sim/object/dirty_log.h"
#include "sim/object/loaded_shells.h"
#include "sim/object/piece_bricks.h"
#include "sim/object/shell_repair.h"
#include "sim/object/state_hash.h"
#include "sim/object/stroke_log.h"

namespace kerf {

/// Objects a scene can hold; what would split into more stays in one.
inline constexpr std::size_t kMostObjects = 64;

class CutObject {
 public:
  using Slot = BrickSlot;
  static constexpr int kMostAdded = BrickStore::kMostAdded;

  /// @param bricks  that can change without reserve(). 4096 of them are about 35 MB; who cuts on asks for more in time.
  explicit CutObject(std::shared_ptr<const BakedObject> baked, std::size_t bricks = 4096);

  const BakedObject& baked() const { return bricks_.baked(); }
  double voxel() const { return baked().voxel(); }

  // Where it is, and what has been taken from it.

  Rigid3 T_world_object;  ///< mm; changed between ticks by moveTo(), which wakes the bricks
  std::uint32_t id = 0;   ///< of this object for good, whatever its place in the scene: see State::next_id
  /// The ledger, mm^3 per material number: as loaded, or as the piece came off, - removed + added is what is there now.
  /// Whole numbers of volumeOfPart(): what is added and cut away leaves nothing, bit for bit. What nodes stand for is
  /// said in sim/object/node_volumes.h.
  std::array<double, 256> removed_mm3{}, added_mm3{};
  /// Of a piece: what had been taken from what it is a piece of, and that one's own, before it came off, mm^3 per
  /// material. The first of the pieces has all of it, so a sum over the scene counts it once. For reports: neither in
  /// the hash nor in snapshots.
  std::array<double, 256> removed_before_mm3{};
  /// How far the tool has moved relative to this object, mm: see BrickSlot::sleeps_until_contact. @rt
  double odometer = 0;
  /// Load of what cuts of the tool's core in the last evaluation of contact, N: sim/step/core_contact.h. @rt
  double core_load = 0;
  /// What the tool has cut of late: corrects the areas of nodes. @rt
  CutArea cut_area;
  /// Whether the tool's core has been outside the object since either of them was changed but by cutting. Until it has,
  /// it is not held out: a bur in a cavity that is taken back must not be shot out. @rt
  bool is_core_clear = false;
  /// The same, since the tool came to rest, of what holds only then: thin points, and stops in soft tissue. @rt
  bool is_tip_clear = false;

  void moveTo(const Rigid3& pose) noexcept {
    T_world_object = pose;
    wake();
  }
  /// Wakes all bricks: whatever the tool was away from, it may touch or cut now. @rt
  void wake() noexcept {
    odometer += 1e6;
    forgetCore();
  }
  /// The core is where it is. @rt
  void forgetCore() noexcept {
    core_load = 0;
    cut_area = {};
    is_core_clear = is_tip_clear = false;
    ++contact_epoch_;
  }
  /// Another number when what was known of the contact is void: forgetCore() was called. @rt
  std::uint32_t contactEpoch() const noexcept { return contact_epoch_; }

  /// Frozen: neither cut nor filled, so that another thread may read values, materials and shells. It is felt as ever.
  bool isFrozen() const noexcept { return is_frozen_; }
  /// @pre dirtyCount() is 0: nothing is left to write. @rt
  void freeze() noexcept { is_frozen_ = true; }
  void unfreeze() noexcept { is_frozen_ = false; }

  // Bricks.

  const BrickStore& bricks() const noexcept { return bricks_; }
  int slotCount() const noexcept { return bricks_.slotCount(); }
  const Slot& slot(int s) const noexcept { return bricks_.slot(s); }
  Slot& slot(int s) noexcept { return bricks_.slot(s); }
  /// Slot of a brick, or -1: air. @rt
  int find(const Vec3i& brick) const noexcept { return bricks_.find(brick); }

  // Writing: shells follow with the next repair(), subscribers and the hash when they ask.

  /// The values of a brick to write into, copied at the first time in a stroke; null when no memory is left. Marks it
  /// dirty, and all of its faces changed: a caller that knows better says so in `changed_faces`. @rt
  float* write(int slot) noexcept;
  /// The materials of a brick to write into, copied at the first time. @pre write() gave its values. @rt
  std::uint8_t* writeMaterials(int slot) noexcept;
  /// BrickStore::addAir(). @rt
  int addAir(const Vec3i& brick) noexcept { return bricks_.addAir(brick); }
  /// Puts in place what is left of a brick, every value at least what it was: ledger, hash and sleep follow.
  /// @param least  of `values`.  @param removed_mm3  what is gone is added to it. False: no memory, and nothing has
  /// changed. @rt
  bool carve(int slot, const float* values, float least, double& removed_mm3) noexcept;
  /// Puts in place a brick with more in it, every value at most what it was: ledger, hash and sleep follow.
  /// @param materials  512 numbers; null: as they are. One that differs is of a node that was outside, and changes.
  /// @param added_mm3  what is there now and was not is added to it. False: no memory, and nothing has changed. @rt
  bool fill(int slot, const float* values, const std::uint8_t* materials, double& added_mm3) noexcept;
  /// Values changed outside the step: the brick wakes up. The ledger is the caller's to put back. False: memory ran
  /// out. Allocates.
  /// @param materials  512 numbers; null: as baked.
  bool restore(int slot, const BrickValues& values, const std::uint8_t* materials);

  /// Brings the shells of the dirty bricks and of their face neighbours up to date. False when memory ran out: they
  /// stay dirty. @rt
  bool repair() noexcept { return shell_.repair(bricks_, memory_); }
  /// The same for those of them alone whose slot is wanted(slot); the neighbours of the others wait with them. Who
  /// reads a shell must have wanted it. @rt
  template <class Wanted>
  bool repair(const Wanted& wanted) noexcept {
    return shell_.repair(bricks_, memory_, wanted);
  }
  /// Makes sure that the shell of a brick with nodes is there: BrickSlot::shell, until another one is asked for. @rt
  void needShell(int slot) noexcept {
    if (!this->slot(slot).shell) loaded_shells_.make(bricks_, slot);
  }
  /// Bricks whose shells wait for repair(). @rt
  std::size_t dirtyCount() const noexcept { return shell_.dirtyCount(); }

  // Memory.

  /// BrickMemory::reserve(): that many more changed bricks. Allocates: not @rt. False without memory.
  bool reserve(std::size_t bricks) { return memory_.reserve(bricks); }
  /// BrickMemory::freeBricks(). @rt
  std::size_t freeBricks() const noexcept { return memory_.freeBricks(); }
  BrickMemory& memory() noexcept { return memory_; }
  const BrickMemory& memory() const noexcept { return memory_; }

  /// What a subscriber has not been told yet. @rt
  BrickChanges changes(BrickSubscriber who) noexcept {
    return {who == BrickSubscriber::kMesher ? for_mesher_ : for_pieces_, bricks_};
  }

  // Strokes: SessionHistory keeps them.

  StrokeLog& strokes() noexcept { return strokes_; }
  const StrokeLog& strokes() const noexcept { return strokes_; }
  /// Every brick of a stroke as it was before (or, with `is_undo` false, after) it. Hash and sleep follow, shells with
  /// the next repair(); the ledger is the caller's to put back. @pre what was written since to those bricks was taken
  /// back. No allocation.  @cost 4 us a brick.
  void swapStroke(const LinkedList<BrickVersion>& stroke, bool is_undo) noexcept;

  // The hash of the state: order-independent, of changed values and materials.

  /// From all bricks, anew.
  std::uint64_t stateHash() const { return bricks_.stateHash(); }
  /// The same number, from the bricks that have changed since their hash was computed last. @rt but for the bricks
  /// whose hash is stale: 1 us each. prepareHash() keeps them few.
  std::uint64_t hashNow() noexcept {
    prepareHash(bricks_.slots().size(), 0);
    return hash_.sum() + bricks_.pieceKey();
  }
  /// StateHash::prepare(). @rt
  void prepareHash(std::size_t bricks, std::uint32_t rounds) noexcept {
    hash_.prepare(bricks_, bricks, rounds, shell_.round());
  }
  std::size_t staleHashes() const noexcept { return hash_.staleCount(); }

 private:
  // Makes pieces: it fills several of the parts at once, brick by brick on many threads, before the piece is anyone's.
  friend class PieceBuilder;
  explicit CutObject(BrickStore bricks);
  void reserveLists(bool is_touched);
  void mark(int slot) noexcept;
  bool put(int slot, const float* values, const std::uint8_t* materials, int sign, std::array<double, 256>& book,
           double& sum) noexcept;

  bool is_frozen_ = false;
  std::uint32_t contact_epoch_ = 0;
  BrickStore bricks_;
  BrickMemory memory_;
  ShellRepair shell_;
  LoadedShells loaded_shells_;
  DirtyLog for_mesher_{SlotList(SlotBit::kForMesher)}, for_pieces_{SlotList(SlotBit::kForPieces)};
  StrokeLog strokes_;
  StateHash hash_;
};

}  // namespace kerf
