// Whether a solid is still the scan it was made of: what closing added or lost beyond what any remedy intends.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "preprocess/close/chain.h"
#include "preprocess/close/close.h"

namespace kerf::internal {

/// A solid may have so many times the volume that the mesh encloses, or that was wrapped. Less is told below a
/// half: pieces that overlap and shells within shells count once in a solid, and more than once in a mesh.
inline constexpr double kMostGrowth = 1.1, kLeastShrink = 0.5;
/// Beyond these it is refused. Then the volume of the mesh is counted by winding numbers as well, so that shells which
/// lie in each other count once, and both have to be exceeded.
inline constexpr double kRefusedGrowth = 2, kRefusedShrink = 0.25;
/// An exact solid may lack this part of the scan's vertices; those inside a solid without base do not count, a union
/// swallows them. Beyond the second limit it is refused, unless the mesh encloses what the solid does.
inline constexpr double kMostLost = 0.1, kRefusedLost = 0.6;  // a layer that is there twice loses half
/// It may reach this part of the scan's diagonal beyond the scan, or end as short of it, but 0.5 mm in any case (less
/// on objects smaller than dental ones): on real scans walls reach 0.2 mm out, and 0.5 mm are lost. On the side of the
/// base it reaches as far as that was asked for.
inline constexpr double kMostReach = 0.02, kLeastReach = 0.5;
/// A wrap of no more volume than so many times its area by its offset is a skin around a surface that encloses nothing:
/// a sheet, wrapped from both sides, has 1. It is refused.
inline constexpr double kSkin = 1.5;
/// So many holes right through the solid that the scan has not are told in capitals: real scans get 9 at most.
inline constexpr int kMostHandles = 20;

/// Volume of where the mesh winds around at least once, whichever way, mm3: shells in each other count once. Counted at
/// 50 000 places of its box, at fewer where very many triangles lie behind each other. @pre closed, or hardly open:
/// rays cross it as often one way as the other.
double windingVolume(const Mesh& mesh);

/// What the guard has to say. Nothing: the solid is what was scanned, as far as this can tell.
struct Judgement {
  std::vector<std::string> warnings;  ///< sentences, each with what to try
  std::vector<std::string> notes;     ///< what is right, and worth to be known
  std::optional<Error> refusal;       ///< kGeometry; names CloseOptions::accept_doubtful as the way to take it as it is
};

/// @param report  of the same closing: its vertices_lost are counted.
/// @param closed  the chain that the solid was made of, turned outwards, or that was wrapped: without crumbs, and what
/// was trimmed. Null: extent and pieces are not compared.
/// @cost  that of sorting the edges; where the volume is doubtful up to a second more; for a scan in several pieces
/// that of crossingPairs().
Judgement judgeSolid(const Mesh& imported_mm, const Mesh& solid, const CloseReport& report,
                     const Chain* closed = nullptr);

}  // namespace kerf::internal
