#include "sim/object/state_hash.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "geometry/field/brick_hash.h"

namespace kerf {

std::uint64_t materialsHash(const BrickSlot& slot) noexcept {
  std::uint64_t h = coordKey(slot.brick);
  for (int n = 0; n < kBrickNodes; n += 8) {
    std::uint64_t eight;
    std::memcpy(&eight, slot.own_materials + n, 8);
    h = (h ^ eight) * 0x9e3779b97f4a7c15ull;
    h ^= h >> 29;
  }
  return h;
}

StateHash::StateHash(double voxel) : sum_(hashOfNoBricks(voxel)) {}

void StateHash::reserve(std::size_t slots, bool is_touched) {
  stale_.reserve(slots);
  if (is_touched) stale_.reserveTouched(slots);
}

namespace {

// Hashes the values of bricks, four at a time.
class HashLanes {
 public:
  explicit HashLanes(std::uint64_t& sum) : sum_(sum) {}

  void set(BrickSlot& slot, std::uint64_t term) noexcept {
    sum_ += term - slot.hash_term;
    slot.hash_term = term;
  }

  // @param rest  the brick's other terms, beside its values.
  void add(BrickSlot& slot, std::uint64_t rest) noexcept {
    keys_[waiting_] = coordKey(slot.brick);
    values_[waiting_] = slot.own;
    slots_[waiting_] = &slot;
    rest_[waiting_] = rest;
    if (++waiting_ == kLanes) finish();
  }

  void finish() noexcept {
    if (waiting_ == 0) return;
    for (std::size_t n = waiting_; n < kLanes; ++n) {
      keys_[n] = keys_[0];
      values_[n] = values_[0];
    }
    const auto terms = brickHashes<kLanes>(keys_, values_);
    for (std::size_t n = 0; n < waiting_; ++n) set(*slots_[n], terms[n] + rest_[n]);
    waiting_ = 0;
  }

 private:
  static constexpr std::size_t kLanes = 4;
  std::uint64_t& sum_;
  std::array<std::uint64_t, kLanes> keys_{}, rest_{};
  std::array<const float*, kLanes> values_{};
  std::array<BrickSlot*, kLanes> slots_{};
  std::size_t waiting_ = 0;
};

}  // namespace

void StateHash::prepare(BrickStore& bricks, std::size_t most, std::uint32_t rounds, std::uint32_t round) noexcept {
  HashLanes lanes(sum_);
  // Skipped bricks count against a bound of their own.
  for (std::size_t tries = std::min(stale_.count(), 8 * most); tries > 0 && most > 0; --tries) {
    if (next_ >= stale_.count()) next_ = 0;
    BrickSlot& slot = bricks.slot(stale_.numbers()[next_]);
    if (round - slot.hash_round < rounds) {
      ++next_;
      continue;
    }
    stale_.removeAt(next_, bricks.slots());
    --most;

    const std::uint64_t of_materials = slot.hasChangedMaterials() ? materialsHash(slot) : 0;
    if (slot.hasChangedValues())
      lanes.add(slot, of_materials);
    else
      lanes.set(slot, of_materials);  // as baked: not part of the changed field
  }
  lanes.finish();
}

}  // namespace kerf
