// A pool of memory for what changes: bricks, their shells, records of strokes. Any thread makes it; the thread that
// cuts takes it over.
//
// Making a pool allocates and writes every page. Taking one links three lists together, whatever its size. So the
// 1 kHz thread gets more memory while it runs, from a thread that has the time.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "sim/object/baked_object.h"
#include "sim/object/brick_version.h"

namespace kerf {

struct PoolChunk {
  ShellChunk chunk;  ///< first: a pointer to it is one to the PoolChunk
  PoolChunk* next;
};

class BrickPool {
 public:
  /// For that many bricks and their shells. Null without memory. @cost writes 8 KiB a brick: 4096 take about 10 ms.
  static std::unique_ptr<BrickPool> make(std::size_t bricks) noexcept;
  ~BrickPool();
  BrickPool(const BrickPool&) = delete;
  BrickPool& operator=(const BrickPool&) = delete;

  std::size_t bricks() const noexcept { return bricks_; }
  static constexpr std::size_t kBricksPerRecord = 32;  ///< a stroke that changes fewer uses up the pool's records first
  static constexpr std::size_t kChunksPerBrick = 5;    ///< 320 nodes: more than a plane's 8 x 8 x 3, or two of them

 private:
  friend class BrickMemory;
  BrickPool() = default;
  std::size_t bricks_ = 0;
  std::vector<BrickVersion> versions_;
  std::vector<PoolChunk> chunks_;
  std::vector<StrokeRecord> records_;
  LinkedList<BrickVersion> free_versions_;
  LinkedList<PoolChunk> free_chunks_;
  LinkedList<StrokeRecord> free_records_;
  std::unique_ptr<BrickPool> next_;  // of those taken over by the same BrickMemory
};

}  // namespace kerf
