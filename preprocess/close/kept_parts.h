// What of a scan its solid still has: how far it reaches to each side, and its pieces.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/close/chain.h"

namespace kerf::internal {

/// How much farther a solid reaches than its scan.
struct SideChange {
  Vec3d side;     ///< unit, out of the model
  double mm = 0;  ///< below 0: it ends short of the scan
};

/// Of the six sides of the box; with a base of the five that are not its own, in the frame of the base.
/// @param scan  places, mm.   @pre  neither is empty.
std::vector<SideChange> sideChanges(const std::vector<Vec3d>& scan, const Mesh& solid,
                                    const std::optional<Vec3d>& base_direction);

/// "+z", or "(0.10, 0.00, 0.99)" where it is no axis.
std::string nameOfSide(const Vec3d& side);

/// What became of the pieces of a scan. Triangles that share an edge, or meet, are one piece; pieces with less than a
/// thousandth of the area are not looked at.
struct PieceChanges {
  std::size_t pieces = 0;
  std::size_t lost = 0;             ///< neither in the solid nor inside it
  std::size_t joined = 0;           ///< as many pieces less than there were: they did not meet, and are one solid now
  Vec3d lost_at = Vec3d::Zero();    ///< mm: middle of the largest of them
  Vec3d joined_at = Vec3d::Zero();  ///< mm: middle of the smallest of them
};

/// @param closed  the chain that an exact solid was made of: only its triangles of the source are looked at.
/// @pre the solid is closed.   @cost  that of crossingPairs() if the scan has several pieces, else of sorting its
/// edges.
PieceChanges comparePieces(const Chain& closed, const Mesh& solid);

/// The same for a wrap, which has no vertex of the source: of the fifty largest pieces of the closed chain, pieces in
/// others aside, those that are one solid now. None is lost: a wrap lies around all of them.
PieceChanges compareWrappedPieces(const Chain& closed, const Mesh& wrap);

}  // namespace kerf::internal
