// The smoothed delta and the step that turn a distance field into areas and volumes.
#pragma once

#include <algorithm>
#include <cmath>

namespace kerf::internal {

/// Half width of the delta, in voxels: nodes nearer to the surface than this make up the point shell.
inline constexpr double kShellVoxels = 1.5;

/// Smoothed delta of Engquist, Tornberg & Tsai 2005 in its polynomial form, 1/mm. @param e half width, mm.
inline double smoothDelta(double phi, double e) {
  const double u = phi / e, w = 1 - u * u;
  return std::abs(u) < 1 ? w * w * 15 / (16 * e) : 0;
}
/// Inner share of a node's voxel: a ramp one voxel wide. Any step of half width e counts a curved surface's outside
/// more than its inside: relative to a ball of radius r by 3 m (h / r)^2, where m is the second moment of the step's
/// slope: h^2 / 12 here, 0.32 h^2 for the step whose slope is smoothDelta().
inline double insideFraction(double phi, double h) { return std::clamp(0.5 - phi / h, 0.0, 1.0); }

}  // namespace kerf::internal
