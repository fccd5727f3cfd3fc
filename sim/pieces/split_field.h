// One piece of a cut object as an object of its own.
#pragma once

#include <memory>
#include <vector>

#include "geometry/field/brick_field.h"
#include "sim/object/piece_bricks.h"
#include "sim/pieces/pieces.h"

namespace kerf {

/// The field of one piece alone, to be an object of its own.
///
/// Its inside nodes, and the outside nodes next to them along an axis, keep their values: no edge that the surface of
/// the piece crosses changes, so its SolidMeasure stays the same to the bit (marching cubes' chord balance reads one
/// node farther, and may move a vertex by a few hundredths of a voxel where another piece was two voxels away). Inside
/// nodes of other pieces become outside: at least |phi|, for the nearest surface is at least that of their own piece
/// and the wanted one lies beyond it. That alone would leave the others behind as ghosts, a field that is nearly zero
/// where nothing is. So nodes nearer to another piece than to this one get their distance to this one, the
/// background beyond the band. It is estimated by the balls of radius |phi| around the piece's outermost nodes: too
/// large by 0.2 voxels, by 1 at a sharp corner. Where both are about equally near the result is within half a voxel. A
/// brick near another piece that this one does not reach is background, whatever it was.
/// @param id  piece or crumb of the last find().   O(its bricks); parallel inside; 10 us per brick near another piece.
BrickField splitField(const PieceFinder& pieces, std::uint32_t id);

/// Memory for bricksOfPieces(), made beforehand and kept for the next time. New pages are slow to come: up to 20 us
/// each where all memory is locked and the machine is a virtual one.
class SplitPool {
 public:
  SplitPool();
  ~SplitPool();
  SplitPool(SplitPool&&) noexcept;
  SplitPool& operator=(SplitPool&&) noexcept;
  /// For `pieces` pieces of what the finder has now, every page of it written to. Does nothing when it is there, else
  /// makes more than that. 100 bytes a brick, and 8 to 16 KB for each that was edited.
  void reserve(const PieceFinder& finder, std::size_t pieces);
  /// Lists of bricksOfPieces(), for their memory, when nobody needs them any more.
  void takeBack(PieceBricks&& bricks);

  struct Lists;

 private:
  friend std::vector<PieceBricks> bricksOfPieces(const PieceFinder&, std::size_t, bool, SplitPool*);
  std::unique_ptr<Lists> lists_;
};

/// Of the first `count` pieces of the last find(): together, since pieces near each other share most of the work.
/// O(all bricks); parallel inside if wanted; 10 us per brick near another piece.
/// @param room  what it has of memory is used, and the lists that are returned are taken from it; may be null.
std::vector<PieceBricks> bricksOfPieces(const PieceFinder& pieces, std::size_t count, bool is_parallel = true,
                                        SplitPool* room = nullptr);

}  // namespace kerf
