// What an object that has come apart becomes: prepared by any thread, put in its place by the one that cuts.
#pragma once

#include <memory>
#include <vector>

#include "sim/pieces/split.h"
#include "sim/pieces/split_field.h"

namespace kerf {

/// An object as it came off: enough to build its field, mesh it and look for its own pieces later, by any thread.
struct PieceOrigin {
  std::uint32_t id = 0, of = 0;  ///< CutObject::id of the piece, and of what it was a piece of
  std::shared_ptr<const BakedObject> baked;
  std::vector<Vec3i> bricks, interior;      ///< that it has: with values, and constant
  std::vector<BrickEdit> cut, near_others;  ///< what differs from `baked`: none in both
  /// 2 KB a brick with values.
  BrickField field() const;
};

/// Either of the two.
struct ObjectPieces {
  std::unique_ptr<Split> parts;                       ///< two pieces or more
  std::vector<std::shared_ptr<PieceOrigin>> origins;  ///< of them, in their order
  std::vector<BrickEdit> without_crumbs;              ///< one piece: what changes when its crumbs go
  std::size_t crumbs = 0;
  SolidMeasure crumb_measure;
};

/// What the pieces of an object are made in, beforehand: they are waited for, and new memory is slow to come.
struct PiecePool {
  std::vector<std::unique_ptr<CutObject>> blanks;  ///< for the first pieces: CutObject::blank()
  std::vector<std::vector<BrickEdit>> cuts;        ///< for their PieceOrigin::cut
  SplitPool lists;
  /// For two pieces, as most objects fall in, of what the finder has now; each with `bricks` free at least. Makes what
  /// is missing, and more than that. @cost 0.9 to 1.1 s for a mandible of 148 000 bricks with all memory locked, the
  /// first time and after each split; 3 us when nothing is missing.
  void reserve(const std::shared_ptr<const BakedObject>& baked, const PieceFinder& finder, std::size_t bricks);
  /// A copy of what a piece came off as, as large as it must be; the memory of the other comes back.
  std::shared_ptr<const PieceOrigin> takeBack(PieceOrigin& origin);
};

/// @param whole  with its shells repaired. Another thread may step it meanwhile if it is frozen.
/// @param finder  up to date with it.
/// @param first_id  of the pieces: State::next_id.
/// @param room  used up as far as the pieces need it; null: all is made now.
/// Null: it is whole, without crumbs, or in more pieces than `most`. The same object gives the same pieces, bit for
/// bit. Parallel inside if wanted. @cost a mandible of 130 000 bricks at 0.1 mm: 22 to 29 ms of two cores beside a
/// haptic thread, with a room.
std::unique_ptr<ObjectPieces> makePieces(const CutObject& whole, PieceFinder& finder, std::uint32_t first_id,
                                         std::size_t most, PiecePool* room = nullptr, bool is_parallel = true);

}  // namespace kerf
