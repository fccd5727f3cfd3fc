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

/// Memory for bricksOfPieces(), kept for the next time. New pages are slow to come: up to 20 us each where all memory
/// is locked and the machine is a virtual one.
class SplitPool {
 public:
  SplitPool();
  ~SplitPool();
  SplitPool(SplitPool&&) noexcept;
  SplitPool& operator=(SplitPool&&) noexcept;

  /// For `pieces` pieces of what the finder has now, every page of it written to. Does nothing when it is there, else
  /// makes more than that. 100 bytes a brick, and 8 to 16 KB for each that was edited.
  void reserve(const PieceFinder& finder, std::size_t pieces);
  /// Takes lists of bricksOfPieces() that are needed no more, for their memory.
  void takeBack(PieceBricks&& bricks);
  /// What bricksOfPieces() works in.
  internal::SplitLists& lists() { return *lists_; }

 private:
  std::unique_ptr<internal::SplitLists> lists_;
};

}  // namespace kerf
