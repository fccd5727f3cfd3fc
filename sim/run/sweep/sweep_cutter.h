// Geometry-only cutting: the union of all tool sweeps, on the object's own grid.
#pragma once

#include <functional>

#include "geometry/field/brick_field.h"
#include "geometry/tool/sweep.h"
#include "sim/hand/merge_motions.h"

namespace kerf {

inline constexpr double kMergeTolerance = 0.01;  ///< voxels; see mergedFor()

/// Merges details of the path below the grid's resolution: motions of half a voxel and less, to within a hundredth of a
/// voxel. A sweep so far beside its path removes 0.1 % more or less.
/// @param cut  the tool's cutting part.
MergedPath mergedFor(const ToolShape& cut, const CutPath& path, double voxel_mm);

struct SweepCutterOptions {
  double band_voxels = 4;           ///< the sweep's field is kept this far to either side of its surface
  double tolerance_voxels = 0.004;  ///< of the minimum over a motion; 0.004 changes a removed volume by < 0.1 %
};

/// Holds psi = min over all motions so far of the swept tool's distance (mm, negative where the tool has been), in
/// those bricks of the object that the tool came near. The cut is phi = max(phi0, -psi). Every node takes the minimum
/// over the continuous motion: there is no scalloping between poses, and the result does not depend on the division of
/// the path. Nodes are independent: same bits on any number of threads. Air farther than the object's band is not
/// stored.
class SweepCutter {
 public:
  /// @param phi0  the baked field; kept by reference, must outlive the cutter. A field without bricks is tissue
  ///   everywhere.
  explicit SweepCutter(const BrickField& phi0, const SweepCutterOptions& options = {});

  /// Called now and then on the calling thread with the finished part of a motion, 0 to 1; false stops it.
  using GoesOn = std::function<bool(double done)>;

  /// Adds one motion. O(bricks near it), parallel inside. Allocates: not for the haptic thread.
  /// @param goes_on  for a tool with a slow distance, such as a mesh of a million triangles. After a stop the motion is
  ///   incomplete: discard the cutter.
  /// @return whether it removed anything: a tenth of a voxel or more off a node that was tissue until then.
  bool advance(const SweptTool& sweep, const GoesOn& goes_on = {});

  /// psi, mm.
  const BrickField& sweep() const { return psi_; }
  /// phi = max(phi0, -psi) in the bricks where it differs from phi0 by a bit; elsewhere phi = phi0.
  BrickField cutField() const;

 private:
  const BrickField& phi0_;
  SweepCutterOptions options_;
  BrickField psi_;
  Box3 object_;  // of phi0's bricks, stored or interior
};

}  // namespace kerf
