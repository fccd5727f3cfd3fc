#include "sim/object/brick_pool.h"

#include <algorithm>
#include <new>
#include <type_traits>

#include "sim/object/huge_pages.h"

namespace kerf {

static_assert(std::is_standard_layout_v<PoolChunk>, "a ShellChunk of a pool is taken for the PoolChunk it begins");

std::unique_ptr<BrickPool> BrickPool::make(std::size_t bricks) noexcept {
  bricks = std::max<std::size_t>(bricks, 1);
  try {
    std::unique_ptr<BrickPool> pool(new BrickPool);
    // Zeroed: every page then exists before the real-time thread writes to it.
    internal::reserveLarge(pool->versions_, bricks);
    pool->versions_.resize(bricks);
    internal::reserveLarge(pool->chunks_, bricks * kChunksPerBrick);
    pool->chunks_.resize(bricks * kChunksPerBrick);
    const std::size_t records = 4 + bricks / kBricksPerRecord;
    pool->records_.resize(records);

    for (std::size_t n = records; n-- > 0;) pool->free_records_.pushFront(&pool->records_[n]);
    for (std::size_t n = bricks; n-- > 0;) pool->free_versions_.pushFront(&pool->versions_[n]);
    for (std::size_t n = bricks * kChunksPerBrick; n-- > 0;) pool->free_chunks_.pushFront(&pool->chunks_[n]);
    pool->bricks_ = bricks;
    return pool;
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

BrickPool::~BrickPool() {
  while (next_) next_ = std::move(next_->next_);  // one by one: a long chain must not nest as deep
}

}  // namespace kerf
