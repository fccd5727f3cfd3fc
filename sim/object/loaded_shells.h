// Shells of unchanged bricks: made when the tool comes near, and kept until the ring reuses their place.
#pragma once

#include <cstddef>
#include <vector>

#include "sim/object/brick_store.h"

namespace kerf {

/// A ring of chunks. A shell takes the next ones; a shell that stood there is made again on demand. Shells depend on
/// loaded values only, so no result depends on when or how often one is made. One thread.
class LoadedShells {
 public:
  /// 40 MB: several times the shells around a blade of 25 mm in bone at 0.05 mm.
  static constexpr std::size_t kMostChunks = 1 << 15;

  /// Reserves chunks for all shells of this object, at most `most_chunks`. Writes to every page. A second call does
  /// nothing.
  void reserve(const BakedObject& baked, std::size_t most_chunks = kMostChunks);

  /// Makes the shell of a slot that has not changed since loading: BrickSlot::shell. It stays at least until the next
  /// call. @pre reserve(); the slot owns no shell, and its shell has nodes. @cost 0.5 us. @rt
  void make(BrickStore& bricks, int s) noexcept;

 private:
  static constexpr int kNobody = -1;
  void free(BrickStore& bricks, std::size_t chunk) noexcept;

  std::vector<ShellChunk> ring_;
  std::vector<int> owners_;  // per chunk: the slot of its shell, or kNobody
  std::size_t next_ = 0;
};

}  // namespace kerf
