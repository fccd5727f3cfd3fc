// The shells of bricks that are as loaded: made when the tool comes near, and kept until their place is needed.
#pragma once

#include <cstddef>
#include <vector>

#include "sim/object/brick_store.h"

namespace kerf {

/// A ring of chunks. A shell takes the next ones of it; what stood there is made again when it is asked for. Shells are
/// of the values as loaded, so that it makes no difference to any result when one is made, or how often. One thread.
class LoadedShells {
 public:
  /// 40 MB: several times what a blade of 25 mm in bone has about it at 0.05 mm.
  static constexpr std::size_t kMostChunks = 1 << 15;

  /// For the shells of this object, or so many chunks of them. Writes to every page. Does nothing the second time.
  void reserve(const BakedObject& baked, std::size_t most_chunks = kMostChunks);

  /// Makes the shell of a slot that has not changed since it was loaded: BrickSlot::shell. It stays at least until the
  /// next call. @pre reserve(); its shell is not its own, and has nodes. @cost 0.5 us. @rt
  void make(BrickStore& bricks, int s) noexcept;

 private:
  static constexpr int kNobody = -1;
  void free(BrickStore& bricks, std::size_t chunk) noexcept;

  std::vector<ShellChunk> ring_;
  std::vector<int> owners_;  // per chunk: the slot it was made for, or kNobody
  std::size_t next_ = 0;
};

}  // namespace kerf
