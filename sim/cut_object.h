// One object while it is cut: the current field and its point shell, brick by brick, copied from the baked one where
// they change.
//
// Belongs to one thread. Everything the 1 kHz step calls is marked @rt: no allocation, lock, exception or system call.
// What it needs is reserved beforehand; when that runs out the step says so and goes on without cutting further bricks:
// their overlap stays, and is cut as soon as reserve() has been called.
#pragma once

#include <memory>
#include <vector>

#include "sim/baked_object.h"
#include "sim/internal/shell_nodes.h"

namespace kerf {

class CutObject {
 public:
  struct Slot {
    Vec3i brick;
    const float* phi;               ///< 512 values, baked or own
    float* own;                     ///< the same once they changed, else null
    const std::uint8_t* materials;  ///< 512 numbers
    std::array<const ShellChunk*, kShellChunks> chunks;
    std::int16_t shell_count;
    bool owns_shell, is_dirty, is_exported_dirty, has_one_material;
    std::uint8_t changed_faces;  ///< bits of -x, +x, -y, +y, -z, +z: values there changed since the last repair()
    float least;                 ///< lower bound of the values
    /// The brick can neither touch nor be cut before the tool has moved this far in all, mm on the odometer: distances
    /// change no faster than the tool moves.
    double sleeps_until_contact, sleeps_until_cut;
  };

  /// Room for changes, in bricks. 16384 of them are some 100 MB.
  explicit CutObject(std::shared_ptr<const BakedObject> baked, std::size_t bricks = 16384);

  const BakedObject& baked() const { return *baked_; }
  double voxel() const { return baked_->voxel(); }
  Rigid3 T_world_object;  ///< mm; changed between ticks by moveTo(), which wakes the bricks
  void moveTo(const Rigid3& pose) noexcept { T_world_object = pose, odometer += 1e6; }

  /// Makes room for that many more changed bricks. Allocates: not @rt. False without memory.
  bool reserve(std::size_t bricks);
  /// More bricks that can change without reserve(): values and shells, of neighbours too. @rt
  std::size_t freeBricks() const noexcept;

  int slotCount() const { return static_cast<int>(slots_.size()); }
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
    low = (low - first).cwiseMax(0), high = (high - first).cwiseMin(size - Vec3i::Ones());
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y) {
        const std::int32_t* row = directory_.data() + (x * size[1] + y) * size[2];
        for (int z = low[2]; z <= high[2]; ++z)
          if (row[z] >= 0) visit(row[z]);
      }
  }

  /// The values of a brick to write into, copied at the first time; null when no room is left. Marks it dirty, and all
  /// of its faces changed: a caller that knows better says so in `changed_faces`. @rt
  float* write(int slot) noexcept;
  static constexpr std::uint8_t kAllFaces = 63;
  /// The faces on which two bricks of values differ; those that have one of these nodes. @rt
  static std::uint8_t facesThatDiffer(const float* a, const float* b) noexcept {
    return facesOf(internal::differingNodes(a, b));
  }
  static std::uint8_t facesOf(const internal::NodeBits& nodes) noexcept;
  /// Values changed outside the step, by undo for one: the ledger follows, the brick wakes up, and its shell is
  /// repaired with the next repair(). False: no such brick, or memory ran out. Allocates.
  bool restore(const Vec3i& brick, const BrickValues& values);

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

  // The ledger, mm^3 per material number.
  std::array<double, 256> removed_mm3{};

  /// How far the tool has moved relative to this object, mm: see Slot. Adding a large number wakes all bricks. @rt
  double odometer = 0;

  /// The bricks that differ from the baked ones, as a field of the same kind. Allocates.
  BrickField changedField() const;
  /// Order-independent hash of those: same state, same number.
  std::uint64_t stateHash() const;
  /// Volume now per material, summed over all nodes. @cost some ns a node.
  std::array<double, 256> countVolumes() const;
  /// Rebuilds every shell from the field and compares: the number of bricks whose shell differs in any bit. For tests.
  std::size_t shellDefects() const;

 private:
  BrickNeighborhood around(const Slot& slot) const noexcept;
  bool repairShell(Slot& slot) noexcept;
  void mark(int slot) noexcept;

  std::shared_ptr<const BakedObject> baked_;
  std::vector<Slot> slots_;
  std::vector<std::int32_t> directory_;
  std::vector<int> dirty_, export_;
  std::vector<std::unique_ptr<BrickValues[]>> phi_blocks_;
  std::vector<std::unique_ptr<ShellChunk[]>> shell_blocks_;
  std::vector<float*> free_phi_;
  std::vector<ShellChunk*> free_chunks_;
  std::size_t all_bricks_ = 0;  // ever reserved
  std::vector<ShellChunk> scratch_;
  std::vector<int> to_repair_;
  std::vector<std::uint32_t> repair_mark_;
  std::uint32_t repair_round_ = 0;
};

}  // namespace kerf
