// One object while it is cut: the current field and its point shell, brick by brick, copied from the baked one where
// they change.
//
// Belongs to one thread. Everything the 1 kHz step calls is marked @rt: no allocation, lock, exception or system call.
// What it needs is reserved beforehand; when that runs out the step says so and goes on without cutting further bricks:
// their overlap stays, and is cut as soon as reserve() or take() has been called.
#pragma once

#include <memory>
#include <vector>

#include "sim/object/brick_faces.h"
#include "sim/object/brick_feed.h"
#include "sim/object/brick_pool.h"
#include "sim/object/piece_bricks.h"
#include "sim/object/shell_nodes.h"

namespace kerf {

/// Objects a scene can hold; what would come apart into more stays in one.
inline constexpr std::size_t kMostObjects = 64;

/// Who is told of changed bricks.
enum class BrickSubscriber : std::uint8_t { kMesher, kPieces };

class CutObject {
 public:
  struct Slot {
    Vec3i brick;
    const float* phi;               ///< 512 values, baked or own
    float* own;                     ///< the same once they changed, else null
    const std::uint8_t* materials;  ///< 512 numbers, baked or own
    std::uint8_t* own_materials;    ///< the same once material was added, else null
    BrickVersion* version;          ///< which holds both of its own, or null
    const float* baked;             ///< 512 values as loaded: what undo goes back to
    const std::uint8_t* baked_materials;
    std::array<const ShellChunk*, kShellChunks> chunks;
    std::int16_t shell_count;
    bool owns_shell, is_dirty, is_exported_dirty, is_watched_dirty, is_touched, has_one_material;
    std::uint8_t changed_faces;  ///< bits of -x, +x, -y, +y, -z, +z: values there changed since the last repair()
    float least;                 ///< lower bound of the values
    /// The brick can neither touch nor be cut before the tool has moved this far in all, mm on the odometer: distances
    /// change no faster than the tool moves.
    double sleeps_until_contact, sleeps_until_cut;
    std::uint64_t hash_term;   ///< what the brick adds to hashNow()
    std::uint32_t hash_round;  ///< of repair(), when the brick changed last
    bool is_hash_stale;
  };

  /// BrickPool for changes, in bricks. 16384 of them are some 140 MB.
  explicit CutObject(std::shared_ptr<const BakedObject> baked, std::size_t bricks = 16384);

  /// What a piece is made from: it knows the bricks as they were loaded, and has none of them; with room for `bricks`
  /// of them to change. Every page is written to: new memory is slow to come, and a piece should not wait for it.
  static CutObject blank(std::shared_ptr<const BakedObject> baked, std::size_t bricks);
  /// One piece of an object as an object of its own, with its pose; what was not cut is shared with the whole. Its
  /// ledger starts anew. Allocates. Another thread may step the whole meanwhile, if it is held: see isFrozen().
  /// @param bricks  of bricksOfPieces(), the finder being up to date with `whole`. Quicker if its shells are repaired.
  /// @param blank  of the same baked object, to be used up; null: one is made. @param is_parallel  by all cores.
  static CutObject piece(const CutObject& whole, const PieceBricks& bricks, std::unique_ptr<CutObject> blank = nullptr,
                         bool is_parallel = false);

  const BakedObject& baked() const { return *baked_; }
  const std::shared_ptr<const BakedObject>& sharedBaked() const { return baked_; }
  double voxel() const { return baked_->voxel(); }
  Rigid3 T_world_object;  ///< mm; changed between ticks by moveTo(), which wakes the bricks
  std::uint32_t id = 0;   ///< of this object for good, whatever its place in the scene: see State::next_id
  void moveTo(const Rigid3& pose) noexcept {
    T_world_object = pose;
    wake();
  }
  /// Wakes all bricks: see `odometer`. @rt
  void wake() noexcept { odometer += 1e6; }

  /// Held: neither cut nor filled, so that another thread may read values, materials and shells. It is felt as ever.
  bool isFrozen() const noexcept { return is_frozen_; }
  /// @pre dirtyCount() is 0: nothing is left to write. @rt
  void freeze() noexcept { is_frozen_ = true; }
  void unfreeze() noexcept { is_frozen_ = false; }

  /// Where HapticThread sends what changes; null: nobody follows. They go where the object goes, into undo and back.
  BrickFeed *feed = nullptr, *watch_feed = nullptr;

  /// Makes room for that many more changed bricks. Allocates: not @rt. False without memory.
  bool reserve(std::size_t bricks);
  /// The same with room that was made elsewhere. @rt O(1)
  void take(std::unique_ptr<BrickPool> room) noexcept;
  /// More bricks that can change without reserve(): values and shells, of neighbours too. @rt
  std::size_t freeBricks() const noexcept;

  /// Slots it began with; those after them were air. Of a piece see has().
  int firstSlotCount() const { return static_cast<int>(most_slots_) - kMostAdded; }
  int slotCount() const { return static_cast<int>(slots_.size()); }
  /// Bricks it has.
  std::size_t brickCount() const { return brick_count_; }
  /// Whether a slot's brick is there: a piece may keep the slots of all that was loaded, but has its own bricks only.
  bool has(int s) const { return find(slot(s).brick) == s; }
  const Slot& slot(int s) const { return slots_[static_cast<std::size_t>(s)]; }
  Slot& slot(int s) { return slots_[static_cast<std::size_t>(s)]; }
  /// Slot of a brick, or -1: air. @rt
  int find(const Vec3i& brick) const noexcept {
    const Vec3i at = brick - baked_->directoryLow();
    const Vec3i& size = baked_->directorySize();
    if ((at.array() < 0).any() || (at.array() >= size.array()).any()) return -1;
    return directory_[static_cast<std::size_t>((at[0] * size[1] + at[1]) * size[2] + at[2])];
  }
  /// Calls visit(slot) for the bricks of a box of bricks, in order of their coordinate. @rt
  template <class Visit>
  void forEachIn(Vec3i low, Vec3i high, const Visit& visit) const noexcept {
    const Vec3i& first = baked_->directoryLow();
    const Vec3i& size = baked_->directorySize();
    low = (low - first).cwiseMax(0);
    high = (high - first).cwiseMin(size - Vec3i::Ones());
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y) {
        const std::int32_t* row = directory_.data() + (x * size[1] + y) * size[2];
        for (int z = low[2]; z <= high[2]; ++z)
          if (row[z] >= 0) visit(row[z]);
      }
  }

  /// The values of a brick to write into, copied at the first time in a stroke; null when no room is left. Marks it
  /// dirty, and all of its faces changed: a caller that knows better says so in `changed_faces`. @rt
  float* write(int slot) noexcept;
  /// The numbers of a brick to write into, copied at the first time. @pre write() gave its values. @rt
  std::uint8_t* writeMaterials(int slot) noexcept;
  /// A brick of air that shall take material: its slot, all outside. -1: it lies farther out than kAirAround, or
  /// kMostAdded bricks were added already. @rt
  int addAir(const Vec3i& brick) noexcept;
  /// Bricks of air that can be made solid during a session: 16384, some 8 cm^3 at 0.1 mm, 1 cm^3 at 0.05 mm.
  static constexpr int kMostAdded = 1 << 14;
  /// Puts in place what is left of a brick, every value at least what it was: ledger, hash and sleep follow, its shell
  /// with the next repair().  @param least  of `values`.  @param removed_mm3  what is gone is added to it, node by
  /// node. False: no room, and nothing has changed. @rt
  bool carve(int slot, const float* values, float least, double& removed_mm3) noexcept;
  /// Values changed outside the step, by undo for one: the brick wakes up, and its shell is repaired with the next
  /// repair(). The ledger is the caller's to put back. False: memory ran out. Allocates.
  /// @param materials  512 numbers; null: as baked.
  bool restore(int slot, const BrickValues& values, const std::uint8_t* materials);

  // Strokes: see SessionHistory, which keeps them.
  /// Whether a brick was written since the last endStroke(). @rt
  bool isInStroke() const noexcept { return !in_stroke_.isEmpty(); }
  /// What was written since the last call. @rt O(1)
  LinkedList<BrickVersion> endStroke() noexcept;
  /// Every brick of a stroke as it was before (or, with `is_undo` false, after) it. Hash and sleep follow, shells with
  /// the next repair(); the ledger is the caller's to put back. @pre what was written since to those bricks was taken
  /// back. No allocation.  @cost 4 us a brick.
  void swapStroke(const LinkedList<BrickVersion>& stroke, bool is_undo) noexcept;
  /// A record to fill in; null: room first. @rt
  StrokeRecord* takeRecord() noexcept { return free_records_.isEmpty() ? nullptr : free_records_.popFront(); }
  std::size_t freeRecords() const noexcept { return free_records_.count; }
  /// The room of a stroke that was taken back for good. @rt O(1)
  void release(StrokeRecord* record) noexcept {
    free_versions_.append(record->bricks);
    free_records_.pushFront(record);
  }

  /// Brings the shells of the dirty bricks and of their face neighbours up to date. False when room ran out: they stay
  /// dirty. @rt
  bool repair() noexcept;
  /// Dirty bricks so far. @rt
  std::size_t dirtyCount() const { return dirty_.size(); }

  /// Bricks changed since they were last taken: what a mesher wants. Each is given once, newest values; take(slot)
  /// returning false keeps it, and ends the call. @rt if take is.
  template <class Take>
  void exportDirty(const Take& take) noexcept {
    std::size_t kept = export_.size();
    while (kept > 0) {
      Slot& s = slot(export_[kept - 1]);
      if (!take(s)) break;
      s.is_exported_dirty = false;
      --kept;
    }
    export_.resize(kept);
  }
  /// Bricks that wait for exportDirty(). @rt
  std::size_t exportCount() const noexcept { return export_.size(); }

  /// The ledger, mm^3 per material number: as loaded, or as the piece came off, - removed + added is what is there now.
  /// A node of the surface that material is put on changes its number: `added` is negative for the one it had.
  std::array<double, 256> removed_mm3{}, added_mm3{};

  /// How far the tool has moved relative to this object, mm: see Slot. Adding a large number wakes all bricks. @rt
  double odometer = 0;

  /// As exportDirty(), for a follower of its own: of who looks for pieces.
  template <class Take>
  void watchDirty(const Take& take) noexcept {
    std::size_t kept = watch_.size();
    while (kept > 0) {
      Slot& s = slot(watch_[kept - 1]);
      if (!take(static_cast<const Slot&>(s))) break;
      s.is_watched_dirty = false;
      --kept;
    }
    watch_.resize(kept);
  }
  bool isWatchDirty() const noexcept { return !watch_.empty(); }

  // The parts by the names they are about to have.
  const CutObject& bricks() const noexcept { return *this; }
  CutObject& memory() noexcept { return *this; }
  const CutObject& memory() const noexcept { return *this; }
  CutObject& strokes() noexcept { return *this; }
  const CutObject& strokes() const noexcept { return *this; }
  bool isOpen() const noexcept { return isInStroke(); }
  LinkedList<BrickVersion> end() noexcept { return endStroke(); }
  struct Changes {
    CutObject& object;
    bool is_mesher;
    template <class Take>
    void take(const Take& taker) const noexcept {
      if (is_mesher)
        object.exportDirty(taker);
      else
        object.watchDirty(taker);
    }
    bool isEmpty() const noexcept { return count() == 0; }
    std::size_t count() const noexcept { return is_mesher ? object.export_.size() : object.watch_.size(); }
    BrickFeed* feed() const noexcept { return is_mesher ? object.feed : object.watch_feed; }
    void setFeed(BrickFeed* to) const noexcept { (is_mesher ? object.feed : object.watch_feed) = to; }
  };
  Changes changes(BrickSubscriber who) noexcept { return {*this, who == BrickSubscriber::kMesher}; }

  bool isPiece() const { return is_piece_; }
  /// The whole field as it is now. Allocates, 2 KB a brick.
  BrickField field() const;

  /// The bricks that differ from the baked ones, as a field of the same kind; of a piece, its own only. Allocates.
  BrickField changedField() const;
  /// Something was added somewhere: materials are not those baked.
  bool hasOwnMaterials() const;
  /// Order-independent hash of changed values and materials: same state, same number.
  std::uint64_t stateHash() const;
  /// The same number, from what is known of the bricks that have not changed since they were looked at last.
  /// @rt but for the bricks whose hash is stale: 1 us each. prepareHash() keeps them few.
  std::uint64_t hashNow() noexcept {
    prepareHash(slots_.size(), 0);
    return hash_sum_ + piece_key_;
  }
  std::size_t staleHashes() const noexcept { return stale_.size(); }
  /// Looks at up to that many bricks whose hash is stale; those that changed in the last `rounds` of repair() may
  /// change again, and are left for later. @rt
  void prepareHash(std::size_t bricks, std::uint32_t rounds) noexcept;
  /// Volume now per material, summed over all nodes. @cost some ns a node.
  std::array<double, 256> countVolumes() const;
  /// Rebuilds every shell from the field and compares: the number of bricks whose shell differs in any bit. For tests.
  std::size_t shellDefects() const;

 private:
  BrickNeighborhood around(const Slot& slot) const noexcept;
  bool repairShell(Slot& slot) noexcept;
  void mark(int slot) noexcept;
  void fillVersion(BrickVersion& version, int slot, BrickVersion* before, std::uint64_t stroke) noexcept;
  void reserveSlots(std::size_t bricks);
  void touch(int s) noexcept {
    if (!slot(s).is_touched) {
      slot(s).is_touched = true;
      touched_.push_back(s);
    }
  }
  void addLoaded(const BakedObject::Slot& from);
  class PieceMaking;
  struct OfPiece {};
  CutObject(OfPiece, std::shared_ptr<const BakedObject> baked);

  bool is_piece_ = false, is_frozen_ = false;
  std::uint64_t piece_key_ = 0;  // which bricks it has
  std::shared_ptr<const BakedObject> baked_;
  std::vector<Slot> slots_;
  std::vector<std::int32_t> directory_;
  std::vector<int> dirty_, export_, watch_;
  std::vector<int> touched_;  // whose values or shell are, or were, not those loaded
  std::unique_ptr<BrickPool> pools_;
  LinkedList<BrickVersion> free_versions_, in_stroke_;
  LinkedList<PoolChunk> free_chunks_;
  LinkedList<StrokeRecord> free_records_;
  std::uint64_t stroke_ = 1;  // 0: what a piece began with
  std::uint64_t hash_sum_;
  std::vector<int> stale_;
  std::size_t next_stale_ = 0;
  std::size_t most_slots_ = 0, brick_count_ = 0;
  std::vector<ShellChunk> scratch_;
  std::vector<int> to_repair_;
  std::vector<std::uint32_t> repair_mark_;
  std::uint32_t repair_round_ = 0;
};

}  // namespace kerf
