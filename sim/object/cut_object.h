// One object during cutting: the current field and its point shell, brick by brick, copied from the baked one on
// change.
//
// A façade over parts with one duty each:
//
//   BrickStore   the bricks, and where their values are now
//   BrickMemory  memory for versions of bricks, shells and records of strokes, reserved beforehand
//   ShellRepair  shells that are out of date, and their repair
//   LoadedShells shells of unchanged bricks, made where the tool is
//   DirtyLog     changes that a subscriber (mesher, piece finder) has not received yet
//   StrokeLog    bricks written since the last stroke ended: undo takes them back
//   StateHash    the hash of the state, brick by brick
//
// A write goes through this class, which informs each part. Readers use the parts directly.
//
// Belongs to one thread. Everything the 1 kHz step calls is marked @rt: no allocation, lock, exception or system call.
// When memory runs out, the step reports it and cuts no further bricks. Their overlap stays, and the step cuts it after
// reserve() or BrickMemory::take().
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
#include "sim/object/plane_sides.h"
#include "sim/object/shell_repair.h"
#include "sim/object/state_hash.h"
#include "sim/object/stroke_log.h"

namespace kerf {

/// Most objects in a scene. An object that would split into more stays whole.
inline constexpr std::size_t kMostObjects = 64;

class CutObject {
 public:
  using Slot = BrickSlot;
  static constexpr int kMostAdded = BrickStore::kMostAdded;

  /// @param bricks  that can change without reserve(). 4096 of them are about 35 MB; longer cuts need more in time.
  explicit CutObject(std::shared_ptr<const BakedObject> baked, std::size_t bricks = 4096);

  const BakedObject& baked() const { return bricks_.baked(); }
  double voxel() const { return baked().voxel(); }

  // Pose, and removed volume.

  Rigid3 T_world_object;  ///< mm; call moveTo() between ticks: it wakes the bricks
  std::uint32_t id = 0;   ///< permanent, independent of the place in the scene: see State::next_id
  /// The ledger, mm^3 per material number. Current volume = volume as loaded (for a piece: at the split) - removed +
  /// added. Whole numbers of volumeOfPart(): adding and cutting the same material cancels, bit for bit. Volume of a
  /// node: sim/object/node_volumes.h.
  std::array<double, 256> removed_mm3{}, added_mm3{};
  /// For a piece: volume removed before the split from its parent and that one's parents, mm^3 per material. The first
  /// piece has all of it, so that a sum over the scene counts it once. For reports: neither in the hash nor in
  /// snapshots.
  std::array<double, 256> removed_before_mm3{};
  /// Plane cuts that made this piece. For export and reports: not in the hash, which has their values.
  PlaneSides plane_sides;
  /// Tool motion so far relative to this object, mm: see BrickSlot::sleeps_until_contact. @rt
  double odometer = 0;
  /// Load on the cutting part of the tool's core in the last contact evaluation, N: sim/step/core_contact.h. @rt
  double core_load = 0;
  /// Recent cuts of the tool: corrects the areas of nodes. @rt
  CutArea cut_area;
  /// Whether the tool's core has been outside the object since the last change of either, except by cutting. Until then
  /// nothing holds the core out: an undo of a cavity must not shoot out the bur in it. @rt
  bool is_core_clear = false;
  /// The same since the tool came to rest, for contact that only holds then: thin points, and stops in soft tissue. @rt
  bool is_tip_clear = false;

  void moveTo(const Rigid3& pose) noexcept {
    T_world_object = pose;
    wake();
  }
  /// Wakes all bricks: the tool may now touch or cut any of them. @rt
  void wake() noexcept {
    odometer += 1e6;
    forgetCore();
  }
  /// Accepts the core at its place. @rt
  void forgetCore() noexcept {
    core_load = 0;
    cut_area = {};
    is_core_clear = is_tip_clear = false;
    ++contact_epoch_;
  }
  /// Changes on every forgetCore(): earlier knowledge of the contact is then void. @rt
  std::uint32_t contactEpoch() const noexcept { return contact_epoch_; }

  /// Frozen: neither cut nor filled, so that another thread may read values, materials and shells. Contact still works.
  bool isFrozen() const noexcept { return is_frozen_; }
  /// @pre dirtyCount() is 0: no write is pending. @rt
  void freeze() noexcept { is_frozen_ = true; }
  void unfreeze() noexcept { is_frozen_ = false; }

  // Bricks.

  const BrickStore& bricks() const noexcept { return bricks_; }
  int slotCount() const noexcept { return bricks_.slotCount(); }
  const Slot& slot(int s) const noexcept { return bricks_.slot(s); }
  Slot& slot(int s) noexcept { return bricks_.slot(s); }
  /// Slot of a brick, or -1: air. @rt
  int find(const Vec3i& brick) const noexcept { return bricks_.find(brick); }

  // Writing: shells follow with the next repair(); subscribers and the hash fetch changes on demand.

  /// The values of a brick for writing, copied on the first write of a stroke; null without memory. Marks the brick as
  /// dirty and all of its faces as changed; a caller that knows better sets `changed_faces`. @rt
  float* write(int slot) noexcept;
  /// The materials of a brick for writing, copied on the first write. @pre write() gave its values. @rt
  std::uint8_t* writeMaterials(int slot) noexcept;
  /// BrickStore::addAir(). @rt
  int addAir(const Vec3i& brick) noexcept { return bricks_.addAir(brick); }
  /// Sets the values of a cut brick, none below its old value. Updates ledger, hash and sleep.
  /// @param least  of `values`.  @param removed_mm3  increased by the removed volume. False: no memory, and nothing has
  ///   changed. @rt
  bool carve(int slot, const float* values, float least, double& removed_mm3) noexcept;
  /// Sets the values of a filled brick, none above its old value. Updates ledger, hash and sleep.
  /// @param materials  512 numbers; null: unchanged. A number may differ only at a node that was outside and changes.
  /// @param added_mm3  increased by the added volume. False: no memory, and nothing has changed. @rt
  bool fill(int slot, const float* values, const std::uint8_t* materials, double& added_mm3) noexcept;
  /// Changes values outside the step and wakes the brick. The caller restores the ledger. False without memory.
  /// Allocates.
  /// @param materials  512 numbers; null: as baked.
  bool restore(int slot, const BrickValues& values, const std::uint8_t* materials);

  /// Brings the shells of the dirty bricks and of their face neighbours up to date. False when memory ran out: they
  /// stay dirty. @rt
  bool repair() noexcept { return shell_.repair(bricks_, memory_); }
  /// The same for those alone whose slot is wanted(slot). The neighbours of the others wait with them. A caller must
  /// want a shell before it reads it. @rt
  template <class Wanted>
  bool repair(const Wanted& wanted) noexcept {
    return shell_.repair(bricks_, memory_, wanted);
  }
  /// Ensures the shell of a brick with nodes: BrickSlot::shell, valid until the next needShell(). @rt
  void needShell(int slot) noexcept {
    if (!this->slot(slot).shell) loaded_shells_.make(bricks_, slot);
  }
  /// Bricks whose shells wait for repair(). @rt
  std::size_t dirtyCount() const noexcept { return shell_.dirtyCount(); }

  // Memory.

  /// BrickMemory::reserve() for that many more changed bricks. Allocates: not @rt. False without memory.
  bool reserve(std::size_t bricks) { return memory_.reserve(bricks); }
  /// BrickMemory::freeBricks(). @rt
  std::size_t freeBricks() const noexcept { return memory_.freeBricks(); }
  BrickMemory& memory() noexcept { return memory_; }
  const BrickMemory& memory() const noexcept { return memory_; }

  /// Changes that a subscriber has not received yet. @rt
  BrickChanges changes(BrickSubscriber who) noexcept {
    return {who == BrickSubscriber::kMesher ? for_mesher_ : for_pieces_, bricks_};
  }

  // Strokes: SessionHistory keeps them.

  StrokeLog& strokes() noexcept { return strokes_; }
  const StrokeLog& strokes() const noexcept { return strokes_; }
  /// Restores every brick of a stroke to its state before (`is_undo` false: after) the stroke. Hash and sleep follow at
  /// once, shells with the next repair(). The caller restores the ledger. @pre later writes to those bricks were
  /// undone. No allocation.  @cost 4 us a brick.
  void swapStroke(const LinkedList<BrickVersion>& stroke, bool is_undo) noexcept;

  // The hash of the state: order-independent, of changed values and materials.

  /// Computed anew from all bricks.
  std::uint64_t stateHash() const { return bricks_.stateHash(); }
  /// The same number, from the bricks that changed since their last hash. @rt except for stale bricks: 1 us each.
  /// prepareHash() keeps them few.
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
  // Makes pieces: fills several parts at once on many threads, before any other code sees the piece.
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
