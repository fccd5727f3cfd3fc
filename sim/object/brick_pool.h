// BrickPool for what changes: memory for bricks and their shells, made by any thread, taken by the one that cuts.
//
// Making allocates and writes every page; taking links three lists together, whatever the size. So the 1 kHz thread
// gets more room while it runs, from a thread that has the time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "sim/object/baked_object.h"

namespace kerf {

/// Singly linked, through the `next` of what is in it. Owns nothing, allocates nothing.
template <class T>
struct LinkedList {
  T *first = nullptr, *last = nullptr;
  std::size_t count = 0;

  bool isEmpty() const noexcept { return count == 0; }
  void pushFront(T* item) noexcept {
    item->next = first;
    first = item;
    if (!last) last = item;
    ++count;
  }
  /// @pre not empty.
  T* popFront() noexcept {
    T* const item = first;
    first = item->next;
    if (!first) last = nullptr;
    item->next = nullptr;
    --count;
    return item;
  }
  /// Appends all of another list, which is empty then. O(1).
  void append(LinkedList& other) noexcept {
    if (other.isEmpty()) return;
    (last ? last->next : first) = other.first;
    last = other.last;
    count += other.count;
    other = {};
  }
};

/// What a brick is during one stroke. A brick that changes in a later stroke gets another version; the one before stays
/// as it is, so that undo and redo are a change of pointers.
struct BrickVersion {
  BrickValues phi;
  std::array<std::uint8_t, kBrickNodes> materials;  ///< if has_own_materials; else those baked count
  BrickVersion* before;                             ///< what the brick was before the stroke; null: as baked
  BrickVersion* next;                               ///< in the list it is in: free ones, or those of its stroke
  std::uint64_t stroke;                             ///< in which it was made
  int slot;                                         ///< of the brick
  bool has_own_materials;
};

/// What an object has lost and gained, mm^3 per material number.
struct Ledger {
  std::array<double, 256> removed{}, added{};
};

/// What one stroke did to one object.
struct StrokeRecord {
  std::size_t object = 0;  ///< its index
  LinkedList<BrickVersion> bricks;
  Rigid3 pose_before, pose_after;
  Ledger before, after;
  StrokeRecord* next = nullptr;
};
struct PoolChunk {
  ShellChunk chunk;  ///< first: a pointer to it is one to the PoolChunk
  PoolChunk* next;
};

class BrickPool {
 public:
  /// For that many bricks and their shells. Null without memory. @cost writes 8 KiB a brick: 4096 take some 10 ms.
  static std::unique_ptr<BrickPool> make(std::size_t bricks) noexcept;
  ~BrickPool();
  BrickPool(const BrickPool&) = delete;
  BrickPool& operator=(const BrickPool&) = delete;

  std::size_t bricks() const noexcept { return bricks_; }
  static constexpr std::size_t kBricksPerRecord = 32;  ///< a stroke that changes fewer ends the room's records first
  static constexpr std::size_t kChunksPerBrick = 5;    ///< 320 nodes: more than a plane's 8 x 8 x 3, or two of them

 private:
  friend class CutObject;
  BrickPool() = default;
  std::size_t bricks_ = 0;
  std::vector<BrickVersion> versions_;
  std::vector<PoolChunk> chunks_;
  std::vector<StrokeRecord> records_;
  LinkedList<BrickVersion> free_versions_;
  LinkedList<PoolChunk> free_chunks_;
  LinkedList<StrokeRecord> free_records_;
  std::unique_ptr<BrickPool> next_;  // of those an object has taken
};

}  // namespace kerf
