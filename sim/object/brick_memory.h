// An object's memory for changes: its pools and their free items.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>

#include "sim/object/brick_pool.h"

namespace kerf {

/// Gives out brick versions, shell chunks and stroke records, and takes them back. Owns all of them: each stays valid
/// as long as this object. One thread. Everything except reserve() is O(1) and @rt.
class BrickMemory {
 public:
  /// Reserves memory for `bricks` more changed bricks. Allocates: not @rt. False without memory.
  bool reserve(std::size_t bricks);
  /// Adds a pool that BrickPool::make() built.
  void take(std::unique_ptr<BrickPool> pool) noexcept;

  /// Number of bricks that can change without reserve(): values and shells, including the neighbours' shells.
  std::size_t freeBricks() const noexcept {
    return std::min(free_versions_.count, free_chunks_.count / BrickPool::kChunksPerBrick);
  }
  std::size_t freeChunks() const noexcept { return free_chunks_.count; }
  std::size_t freeRecords() const noexcept { return free_records_.count; }

  /// Null when none is free.
  BrickVersion* takeVersion() noexcept { return free_versions_.isEmpty() ? nullptr : free_versions_.popFront(); }

  /// Null when none is free.
  ShellChunk* takeChunk() noexcept { return free_chunks_.isEmpty() ? nullptr : &free_chunks_.popFront()->chunk; }
  /// @pre `chunk` came from takeChunk().
  void giveBack(ShellChunk* chunk) noexcept { free_chunks_.pushFront(reinterpret_cast<PoolChunk*>(chunk)); }

  /// A record to fill in. Null when none is free: call reserve() first.
  StrokeRecord* takeRecord() noexcept { return free_records_.isEmpty() ? nullptr : free_records_.popFront(); }
  /// Takes back a record and the versions of its stroke, after a final undo.
  void release(StrokeRecord* record) noexcept {
    free_versions_.append(record->bricks);
    free_records_.pushFront(record);
  }

 private:
  std::unique_ptr<BrickPool> pools_;  // newest pool; each owns the one before
  LinkedList<BrickVersion> free_versions_;
  LinkedList<PoolChunk> free_chunks_;
  LinkedList<StrokeRecord> free_records_;
};

}  // namespace kerf
