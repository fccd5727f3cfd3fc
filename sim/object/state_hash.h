// The hash of an object's state, kept up to date brick by brick.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sim/object/brick_store.h"

namespace kerf {

/// What the materials of a brick add to the hash of the state. @pre they are its own.
std::uint64_t materialsHash(const BrickSlot& slot) noexcept;

/// The number of BrickStore::stateHash(), from the bricks that changed alone: a sum of one term per brick, which is
/// taken out and put in anew when the brick changes. One thread.
class StateHash {
 public:
  /// Of an object as loaded. @param voxel  mm.
  explicit StateHash(double voxel);
  /// For that many slots in all. @param is_touched  writes to every page as well.
  void reserve(std::size_t slots, bool is_touched);

  /// The brick has changed in this round of repair(). @rt
  void add(BrickSlot& slot, int s, std::uint32_t round) noexcept {
    stale_.add(slot, s);
    slot.hash_round = round;
  }
  /// Bricks whose term is not that of their values.
  std::size_t staleCount() const noexcept { return stale_.count(); }

  /// Computes the terms of up to that many stale bricks. Those that changed in the last `rounds` of repair() may change
  /// again, and are left for later. @param round  of repair(), now. @cost 1 us a brick. @rt
  void prepare(BrickStore& bricks, std::size_t most, std::uint32_t rounds, std::uint32_t round) noexcept;
  /// The sum, without the terms of stale bricks' newest values. @rt
  std::uint64_t sum() const noexcept { return sum_; }

 private:
  SlotList stale_{SlotBit::kHashStale};
  std::size_t next_ = 0;  // in stale_: where the next prepare() begins
  std::uint64_t sum_;
};

}  // namespace kerf
