// Compares a solid with its scan: reach to each side, and pieces.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/close/chain.h"

namespace kerf::internal {

/// Reach of a solid beyond its scan.
struct SideChange {
  Vec3d side;     ///< unit, out of the model
  double mm = 0;  ///< below 0: the solid ends short of the scan
};

/// Changes at the six sides of the box; with a base at the five other sides, in the frame of the base.
/// @param scan  places, mm.   @pre  neither is empty.
std::vector<SideChange> sideChanges(const std::vector<Vec3d>& scan, const Mesh& solid,
                                    const std::optional<Vec3d>& base_direction);

/// "+z", or "(0.10, 0.00, 0.99)" for a direction off the axes.
std::string nameOfSide(const Vec3d& side);

/// Lost and joined pieces of a scan. Triangles that share an edge, or meet, are one piece. Pieces with less than a
/// thousandth of the area do not count.
struct PieceChanges {
  std::size_t pieces = 0;
  std::size_t lost = 0;             ///< neither in the solid nor inside it
  std::size_t joined = 0;           ///< decrease of the number of pieces: they did not meet before, and are one solid
                                    ///< now
  Vec3d lost_at = Vec3d::Zero();    ///< mm: middle of the largest lost piece
  Vec3d joined_at = Vec3d::Zero();  ///< mm: middle of the smallest joined piece
};

/// @param closed  the chain of an exact solid; only its source triangles count.
/// @pre the solid is closed.   @cost  that of crossingPairs() if the scan has several pieces, else of sorting its
/// edges.
PieceChanges comparePieces(const Chain& closed, const Mesh& solid);

/// The same for a wrap, which has no source vertex: counts the fifty largest pieces of the closed chain, nested pieces
/// excluded, that are one solid now. No piece is lost, since a wrap encloses all of them.
PieceChanges compareWrappedPieces(const Chain& closed, const Mesh& wrap);

}  // namespace kerf::internal
