// Keeps an object's point shell up to date with its values: the bricks that need repair, and the repair.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/object/brick_memory.h"
#include "sim/object/brick_store.h"

namespace kerf {

/// Bricks whose values changed since the last repair(). Counts the rounds of repair(). One thread.
class ShellRepair {
 public:
  ShellRepair() : scratch_(kShellChunks) {}
  /// For that many slots in all. @param is_touched  also writes to every page.
  void reserve(std::size_t slots, bool is_touched);

  /// Call after a change of a brick's values; BrickSlot::changed_faces holds the changed faces. @rt
  void add(BrickSlot& slot, int s) noexcept { dirty_.add(slot, s); }
  std::size_t dirtyCount() const noexcept { return dirty_.count(); }
  /// Calls of repair() so far.
  std::uint32_t round() const noexcept { return round_; }

  /// Rebuilds the shells of the dirty bricks and of their face neighbours. False when memory ran out: they all stay
  /// dirty. Writes to no brick when none is dirty: another thread may read a frozen object. @rt
  bool repair(BrickStore& bricks, BrickMemory& memory) noexcept;

  /// The same for those dirty bricks alone for which wanted(slot) is true. Neighbours become dirty, and a call that
  /// wants them repairs them.
  template <class Wanted>
  bool repair(BrickStore& bricks, BrickMemory& memory, const Wanted& wanted) noexcept {
    ++round_;
    spread(bricks);
    bool is_done = true;
    for (std::size_t n = dirty_.count(); n-- > 0;) {  // the last takes the place of the removed one
      const int s = dirty_.numbers()[n];
      if (!wanted(s)) continue;
      is_done = is_done && repairOne(s, bricks, memory);
      if (is_done) dirty_.removeAt(n, bricks.slots());
    }
    return is_done;
  }

 private:
  /// Marks the neighbours as dirty whose gradients the dirty bricks change, and clears all changed_faces. @rt
  void spread(BrickStore& bricks) noexcept;
  bool repairOne(int s, BrickStore& bricks, BrickMemory& memory) noexcept;

  SlotList dirty_{SlotBit::kDirty};
  std::uint32_t round_ = 0;
  // Scratch of repair().
  std::vector<int> to_repair_;
  std::vector<std::uint32_t> wanted_in_;  // per slot, the last round in which it was in to_repair_
  std::vector<ShellChunk> scratch_;
};

}  // namespace kerf
