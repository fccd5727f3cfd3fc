// Whether a solid is still the scan it was made of: what closing added or lost beyond what any remedy intends.
#pragma once

#include <string>
#include <vector>

#include "preprocess/close/close.h"

namespace kerf::internal {

/// A solid may have so many times the volume of a mesh that was as good as closed. Less is told below a half: pieces
/// that overlap and shells within shells count once in a solid, and more than once in a mesh.
inline constexpr double kMostGrowth = 1.1, kLeastShrink = 0.5;
/// An exact solid may lack this part of the scan's vertices.
inline constexpr double kMostLost = 0.1;

/// Sentences, each with what to try; none: the solid is what was scanned, as far as this can tell.
/// @param report  of the same closing: its vertices_lost are counted.   @cost  that of sorting the edges.
std::vector<std::string> guardWarnings(const Mesh& imported_mm, const Mesh& solid, const CloseReport& report);

}  // namespace kerf::internal
