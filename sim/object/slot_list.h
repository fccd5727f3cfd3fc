// A list of slots that holds each at most once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/object/brick_slot.h"

namespace kerf {

/// Slots by their numbers, in the order of add(). A bit of the slot marks it as listed. Five such lists hold the
/// pending work for changed bricks. One thread. @rt except for the two reserve functions.
class SlotList {
 public:
  explicit SlotList(SlotBit bit) : bit_(bit) {}

  /// For that many slots in all: add() then never allocates.
  void reserve(std::size_t slots) { numbers_.reserve(slots); }
  /// The same, and writes to every page. @pre empty.
  void reserveTouched(std::size_t slots) {
    numbers_.resize(slots);
    numbers_.clear();
  }

  bool isEmpty() const noexcept { return numbers_.empty(); }
  std::size_t count() const noexcept { return numbers_.size(); }
  const std::vector<int>& numbers() const noexcept { return numbers_; }

  /// Adds a slot unless it is listed. @param s  the slot's number.
  void add(BrickSlot& slot, int s) noexcept {
    if (slot.isListed(bit_)) return;
    slot.listed |= static_cast<std::uint8_t>(bit_);
    numbers_.push_back(s);
  }

  /// Removes the n-th; the last takes its place.
  void removeAt(std::size_t n, std::vector<BrickSlot>& slots) noexcept {
    unlist(slots[static_cast<std::size_t>(numbers_[n])]);
    numbers_[n] = numbers_.back();
    numbers_.pop_back();
  }

  /// Calls take(slot) from the last to the first, and removes those for which it returns true. The first false ends it.
  template <class Take>
  void takeFromBack(std::vector<BrickSlot>& slots, const Take& take) noexcept {
    while (!numbers_.empty()) {
      BrickSlot& slot = slots[static_cast<std::size_t>(numbers_.back())];
      if (!take(static_cast<const BrickSlot&>(slot))) return;
      unlist(slot);
      numbers_.pop_back();
    }
  }

  void clear(std::vector<BrickSlot>& slots) noexcept {
    for (const int s : numbers_) unlist(slots[static_cast<std::size_t>(s)]);
    numbers_.clear();
  }

 private:
  void unlist(BrickSlot& slot) noexcept {
    slot.listed &= static_cast<std::uint8_t>(~static_cast<unsigned>(static_cast<std::uint8_t>(bit_)));
  }

  SlotBit bit_;
  std::vector<int> numbers_;
};

}  // namespace kerf
