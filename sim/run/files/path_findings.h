// Likely mistakes of a path, found during its cut.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "geometry/base/types.h"

namespace kerf {

/// A stroke is an uninterrupted cut of a path; strokes count from 1.
struct PathFindings {
  std::size_t strokes = 0;  ///< number of strokes begun
  /// Strokes that took less than a tenth of a voxel off every node. Exception: a geometry cut that no node counts is
  /// judged between the nodes (sim/run/sweep/thin_cut.h), each stroke by itself.
  std::vector<std::size_t> idle;
  std::optional<Vec3d>
      comes_out_at;  ///< mm, where the tip first came out of the object on the side away from the shank
};

}  // namespace kerf
