// Random strokes through a block, and a filling that is cut away: what the ledger says, and what there is.
#pragma once

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/base/types.h"

namespace kerf::scenes {

/// Strokes of 8 ticks and up to 0.7 mm, each somewhere in a block askew to the grid.
struct RandomStrokes {
  Vec3d block{5, 5, 3};  ///< mm
  double voxel = 0.1;    ///< mm
  double radius = 0.5;   ///< of the ball, mm
  int count = 300;
  bool geometry_only = false;  ///< else the surface relaxes towards the ball: between strokes films stay
};

/// mm^3.
struct StrokesLedger {
  double loaded = 0, removed = 0, left = 0;  ///< by the ledger; `left` is counted at the end
  double mesh_loaded = 0, mesh_removed = 0;  ///< of the meshes before and after
  std::uint64_t state = 0;                   ///< hash

  /// How far the ledger is off the mesh, of what was removed.
  double errorPercent() const { return 100 * (removed - mesh_removed) / mesh_removed; }
  /// Of what was loaded.
  double imbalance() const;
};

Expected<StrokesLedger> cutAtRandom(const RandomStrokes& strokes, const Progress& progress = {});

/// mm^3 of composite.
struct FillingLedger {
  double added = 0, removed = 0, left = 0;  ///< `left` is counted at the end
};

/// A cavity is drilled and filled; then a larger ball takes away all of the filling.
Expected<FillingLedger> cutFilling(bool geometry_only);

}  // namespace kerf::scenes
