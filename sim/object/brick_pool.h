// A pool of memory for changed bricks, their shells and stroke records. Any thread makes it; the cutting thread takes
// it over.
//
// Making a pool allocates and writes every page. Taking it over links three lists, at constant cost. So another thread
// can supply the 1 kHz thread with memory while it runs.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "sim/object/baked_object.h"
#include "sim/object/brick_version.h"

namespace kerf {

struct PoolChunk {
  ShellChunk chunk;  ///< first: a pointer to it also points to the PoolChunk
  PoolChunk* next;
};

class BrickPool {
 public:
  /// For `bricks` bricks and their shells. Null without memory. @cost writes 8 KiB a brick: 4096 take about 10 ms.
  static std::unique_ptr<BrickPool> make(std::size_t bricks) noexcept;
  ~BrickPool();
  BrickPool(const BrickPool&) = delete;
  BrickPool& operator=(const BrickPool&) = delete;

  std::size_t bricks() const noexcept { return bricks_; }
  static constexpr std::size_t kBricksPerRecord = 32;  ///< strokes that change fewer bricks use up the records first
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
  std::unique_ptr<BrickPool> next_;  // an older pool of the same BrickMemory
};

}  // namespace kerf
