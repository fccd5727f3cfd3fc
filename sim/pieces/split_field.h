// The field of each piece of a cut object as an object of its own.
//
// A line through a kerf between pieces A and B, in voxels, the band 3 voxels wide:
//
//   node               0     1     2     3     4     5     6     7     8     9
//   inside of          A     A     A     .     .     .     .     B     B     B
//   the whole        -2.5  -1.5  -0.5   0.5   1.5   1.5   0.5  -0.5  -1.5  -2.5
//   piece A          -2.5  -1.5  -0.5   0.5   1.5   2.5    3     3     3     3
//                    |_____ kept _____||__ kept _||_ nearer to B: distance to A, at most the background
//                       its inside     next to it, or nearer to A
//   piece B            3     3     3     3    2.5   1.5   0.5  -0.5  -1.5  -2.5
//
// The surface of each piece stays where it is, and no trace of the other piece is left.
#pragma once

#include <vector>

#include "geometry/field/brick_field.h"
#include "sim/object/piece_bricks.h"
#include "sim/pieces/pieces.h"
#include "sim/pieces/split_pool.h"

namespace kerf {

/// The field of one piece alone, for an object of its own.
///
/// Its inside nodes, and the outside nodes next to them along an axis, keep their values: no edge that the surface of
/// the piece crosses changes, so its SolidMeasure stays the same to the bit (marching cubes' chord balance reads one
/// node farther, and may move a vertex by a few hundredths of a voxel where another piece was two voxels away).
///
/// Inside nodes of other pieces become outside: at least |phi|, because the nearest surface is at least that of their
/// own piece, and the wanted one lies beyond it. That alone would leave ghosts: values near zero without a surface. So
/// nodes nearer to another piece get their distance to this piece, and the background value beyond the band. Balls of
/// radius |phi| around the piece's outermost nodes estimate the distance: too large by 0.2 voxels, by 1 at a sharp
/// corner. Where both are about equally near the result is within half a voxel. A brick near another piece and out of
/// this piece's reach becomes background.
/// @param id  piece or crumb of the last find().   O(its bricks); parallel inside; 10 us per brick near another piece.
BrickField splitField(const PieceFinder& pieces, std::uint32_t id);

/// Bricks of the first `count` pieces of the last find(), in one pass: pieces near each other share most of the work.
/// O(all bricks); parallel inside if wanted; 10 us per brick near another piece.
/// @param pool  gives memory and the returned lists; may be null.
std::vector<PieceBricks> bricksOfPieces(const PieceFinder& pieces, std::size_t count, bool is_parallel = true,
                                        SplitPool* pool = nullptr);

}  // namespace kerf
