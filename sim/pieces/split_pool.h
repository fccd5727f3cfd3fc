// Memory for splitting an object, made beforehand.
#pragma once

#include <cstddef>
#include <memory>

#include "sim/object/piece_bricks.h"
#include "sim/pieces/pieces.h"

namespace kerf {

namespace internal {
struct SplitLists;
}

/// Memory for bricksOfPieces(), kept between calls. New pages are slow to come: up to 20 us each on a virtual machine
/// with all memory locked.
class SplitPool {
 public:
  SplitPool();
  ~SplitPool();
  SplitPool(SplitPool&&) noexcept;
  SplitPool& operator=(SplitPool&&) noexcept;

  /// For `pieces` pieces of the finder's current field; writes to every page. Does nothing if the memory is there, else
  /// makes it with a reserve. 100 bytes a brick, and 8 to 16 KB for each edited brick.
  void reserve(const PieceFinder& finder, std::size_t pieces);
  /// Takes back unneeded lists of bricksOfPieces(), for their memory.
  void takeBack(PieceBricks&& bricks);
  /// Scratch of bricksOfPieces().
  internal::SplitLists& lists() { return *lists_; }

 private:
  std::unique_ptr<internal::SplitLists> lists_;
};

}  // namespace kerf
