// Fewer motions for a path that was recorded finely: a sweep costs as much for a motion of a micrometre as for one of a
// millimetre.
#pragma once

#include <cstddef>

#include "sim/hand/path.h"

namespace kerf {

struct MergeLimits {
  double short_mm = 0;      ///< only motions during which no point of the tool moves farther are merged; 0: none
  double tolerance_mm = 0;  ///< no point of the tool is farther from where the path leads it
  double reach_mm = 0;      ///< distance of the tool's farthest point from its tip
};

struct MergedPath {
  CutPath path;            ///< some of the poses of the path, unchanged
  std::size_t merged = 0;  ///< cutting motions that are parts of longer ones now
};

/// Joins runs of short cutting motions to one motion each, where that leads every point of the tool within the
/// tolerance of the path, to and fro. A path without short motions is returned as it is.
/// @cost about 1 us a pose.  @thread any; deterministic.
MergedPath mergeShortMotions(const CutPath& path, const MergeLimits& limits);

}  // namespace kerf
