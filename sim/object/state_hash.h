// The hash of an object's state, kept up to date brick by brick.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sim/object/brick_store.h"

namespace kerf {

/// The term of a brick's materials in the state hash. @pre the slot owns its materials.
std::uint64_t materialsHash(const BrickSlot& slot) noexcept;

/// The number of BrickStore::stateHash(), from the changed bricks alone: a sum of one term per brick. A change of the
/// brick replaces its term. One thread.
class StateHash {
 public:
  /// For an object as loaded. @param voxel  mm.
  explicit StateHash(double voxel);
  /// For that many slots in all. @param is_touched  also writes to every page.
  void reserve(std::size_t slots, bool is_touched);

  /// The brick has changed in this round of repair(). @rt
  void add(BrickSlot& slot, int s, std::uint32_t round) noexcept {
    stale_.add(slot, s);
    slot.hash_round = round;
  }
  /// Bricks whose term is out of date.
  std::size_t staleCount() const noexcept { return stale_.count(); }

  /// Computes the terms of up to `most` stale bricks. Skips those that changed in the last `rounds` of repair(): they
  /// may change again. @param round  current number of repair(). @cost 1 us a brick. @rt
  void prepare(BrickStore& bricks, std::size_t most, std::uint32_t rounds, std::uint32_t round) noexcept;
  /// The sum; stale bricks count with an outdated term. @rt
  std::uint64_t sum() const noexcept { return sum_; }

 private:
  SlotList stale_{SlotBit::kHashStale};
  std::size_t next_ = 0;  // index in stale_ at which the next prepare() begins
  std::uint64_t sum_;
};

}  // namespace kerf
