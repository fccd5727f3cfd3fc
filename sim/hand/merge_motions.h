// Merges motions of a finely recorded path: a sweep costs as much for a motion of a micrometre as for one of a
// millimetre.
#pragma once

#include <cstddef>

#include "sim/hand/path.h"

namespace kerf {

struct MergeLimits {
  double short_mm = 0;      ///< merges only motions during which no point of the tool moves farther; 0: none
  double tolerance_mm = 0;  ///< largest deviation of any point of the tool from the path
  double reach_mm = 0;      ///< distance of the tool's farthest point from its tip
};

struct MergedPath {
  CutPath path;            ///< some of the poses of the path, unchanged
  std::size_t merged = 0;  ///< cutting motions merged into longer ones
};

/// Joins runs of short cutting motions to one motion each, if every point of the tool stays within the tolerance of the
/// path, to and fro. Returns a path without short motions unchanged.
/// @cost about 1 us a pose.  @thread any; deterministic.
MergedPath mergeShortMotions(const CutPath& path, const MergeLimits& limits);

}  // namespace kerf
