// Random strokes through a block, and a cut of a filling: the ledger against the actual volume.
#pragma once

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/base/types.h"

namespace kerf::scenes {

/// Strokes of 8 ticks and up to 0.7 mm, at random places of a block askew to the grid.
struct RandomStrokes {
  Vec3d block{5, 5, 3};  ///< mm
  double voxel = 0.1;    ///< mm
  double radius = 0.5;   ///< of the ball, mm
  int count = 300;
  bool geometry_only = false;  ///< else the surface relaxes towards the ball and leaves films between strokes
};

/// mm^3.
struct StrokesLedger {
  double loaded = 0, removed = 0, left = 0;  ///< by the ledger; `left` by a count at the end
  double mesh_loaded = 0, mesh_removed = 0;  ///< of the meshes before and after
  std::uint64_t state = 0;                   ///< hash

  /// Error of the ledger against the mesh, in percent of the removed volume.
  double errorPercent() const { return 100 * (removed - mesh_removed) / mesh_removed; }
  /// Relative to the loaded volume.
  double imbalance() const;
};

Expected<StrokesLedger> cutAtRandom(const RandomStrokes& strokes, const Progress& progress = {});

/// mm^3 of composite.
struct FillingLedger {
  double added = 0, removed = 0, left = 0;  ///< `left` by a count at the end
};

/// Drills a cavity, fills it, and removes the filling with a larger ball.
Expected<FillingLedger> cutFilling(bool geometry_only);

}  // namespace kerf::scenes
