#include "sim/object/brick_memory.h"

#include <utility>

namespace kerf {

bool BrickMemory::reserve(std::size_t bricks) {
  auto pool = BrickPool::make(bricks);
  if (!pool) return false;
  take(std::move(pool));
  return true;
}

void BrickMemory::take(std::unique_ptr<BrickPool> pool) noexcept {
  free_versions_.append(pool->free_versions_);
  free_chunks_.append(pool->free_chunks_);
  free_records_.append(pool->free_records_);
  pool->next_ = std::move(pools_);
  pools_ = std::move(pool);
}

}  // namespace kerf
