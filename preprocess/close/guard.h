// Compares a solid with its scan: finds volume, vertices and pieces that closing should not have added or lost.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "preprocess/close/chain.h"
#include "preprocess/close/close.h"

namespace kerf::internal {

/// Limits of a warning: volume of the solid over that of the mesh, or of the wrapped chain. The lower limit is a half,
/// because overlapping pieces and nested shells count once in a solid, and more than once in a mesh.
inline constexpr double kMostGrowth = 1.1, kLeastShrink = 0.5;
/// Limits of an error. The guard then also computes the mesh volume by winding numbers, which count nested shells once.
/// An error requires both ratios beyond the limit.
inline constexpr double kRefusedGrowth = 2, kRefusedShrink = 0.25;
/// Share of the scan's vertices missing from an exact solid: limits of a warning and of an error. Vertices inside a
/// solid without base do not count, since a union swallows them. No error if the mesh encloses the volume of the solid.
inline constexpr double kMostLost = 0.1, kRefusedLost = 0.6;  // a double layer loses half
/// A solid may reach this share of the scan's diagonal beyond the scan or end short of it, and at least 0.5 mm (less on
/// objects smaller than dental ones). On real scans walls reach 0.2 mm out, and 0.5 mm are lost. On the side of the
/// base the limit follows the requested base.
inline constexpr double kMostReach = 0.02, kLeastReach = 0.5;
/// A wrap with at most this many times area times offset as its volume is a skin around an open surface, an error. A
/// sheet, wrapped from both sides, has 1.
inline constexpr double kSkin = 1.5;
/// Above this number of new through-holes of the solid, the warning is in capitals. Real scans get 9 at most.
inline constexpr int kMostHandles = 20;

/// Volume with a winding number other than 0, mm3: nested shells count once. Samples 50 000 places of the box, fewer if
/// very many triangles lie behind each other. @pre closed, or hardly open: rays cross it as often one way as the other.
double windingVolume(const Mesh& mesh);

/// Findings of the guard. Empty: no difference from the scan found.
struct Judgement {
  std::vector<std::string> warnings;  ///< sentences, each with a remedy
  std::vector<std::string> notes;     ///< correct results worth a mention
  std::optional<Error> refusal;       ///< kGeometry; names CloseOptions::accept_doubtful, which accepts the solid
};

/// @param report  of the same closing, with vertices_lost counted.
/// @param closed  the chain before the solid or the wrap, turned outwards, without crumbs and trimmed parts. Null: no
/// comparison of extent and pieces.
/// @cost  that of sorting the edges; up to a second more if the volume is doubtful; that of crossingPairs() for a scan
/// in several pieces.
Judgement judgeSolid(const Mesh& imported_mm, const Mesh& solid, const CloseReport& report,
                     const Chain* closed = nullptr);

}  // namespace kerf::internal
