// The memory an object has for changes: the pools it was given, and what is free of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>

#include "sim/object/brick_pool.h"

namespace kerf {

/// Gives out brick versions, shell chunks and stroke records, and takes them back. Owns them all, for good: what is
/// given out is valid as long as this is. One thread. Everything but reserve() is O(1). @rt but for reserve()
class BrickMemory {
 public:
  /// Memory for that many more changed bricks. Allocates: not @rt. False without memory.
  bool reserve(std::size_t bricks);
  /// The same with a pool that was made elsewhere.
  void take(std::unique_ptr<BrickPool> pool) noexcept;

  /// Bricks that can change without reserve(): values and shells, of neighbours too.
  std::size_t freeBricks() const noexcept {
    return std::min(free_versions_.count, free_chunks_.count / BrickPool::kChunksPerBrick);
  }
  std::size_t freeChunks() const noexcept { return free_chunks_.count; }
  std::size_t freeRecords() const noexcept { return free_records_.count; }

  /// Null: none is left.
  BrickVersion* takeVersion() noexcept { return free_versions_.isEmpty() ? nullptr : free_versions_.popFront(); }

  /// Null: none is left.
  ShellChunk* takeChunk() noexcept { return free_chunks_.isEmpty() ? nullptr : &free_chunks_.popFront()->chunk; }
  /// @pre it came from takeChunk().
  void giveBack(ShellChunk* chunk) noexcept { free_chunks_.pushFront(reinterpret_cast<PoolChunk*>(chunk)); }

  /// A record to fill in; null: none is left, reserve() first.
  StrokeRecord* takeRecord() noexcept { return free_records_.isEmpty() ? nullptr : free_records_.popFront(); }
  /// Takes back a record, and the versions of its stroke, which was undone for good.
  void release(StrokeRecord* record) noexcept {
    free_versions_.append(record->bricks);
    free_records_.pushFront(record);
  }

 private:
  std::unique_ptr<BrickPool> pools_;  // the one taken last; each owns the one before
  LinkedList<BrickVersion> free_versions_;
  LinkedList<PoolChunk> free_chunks_;
  LinkedList<StrokeRecord> free_records_;
};

}  // namespace kerf
