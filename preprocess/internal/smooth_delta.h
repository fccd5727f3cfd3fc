// The smoothed delta and step that turn a distance field into areas and volumes.
#pragma once

#include <algorithm>
#include <cmath>

namespace kerf::internal {

/// Half width of both, in voxels: nodes nearer to the surface than this make up the point shell.
inline constexpr double kShellVoxels = 1.5;

/// Smoothed delta of Engquist, Tornberg & Tsai 2005 in its polynomial form, 1/mm. @param e half width, mm.
inline double smoothDelta(double phi, double e) {
  const double u = phi / e, w = 1 - u * u;
  return std::abs(u) < 1 ? w * w * 15 / (16 * e) : 0;
}
/// The step it is the slope of: 1 inside, 0 outside.
inline double smoothInside(double phi, double e) {
  const double u = std::clamp(phi / e, -1.0, 1.0);
  return 0.5 - (15 * u - 10 * u * u * u + 3 * u * u * u * u * u) / 16;
}

}  // namespace kerf::internal
