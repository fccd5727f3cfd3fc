// Uncertainty of the volume of a small cut.
#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>

namespace kerf {

inline constexpr double kUnchanged = 1e-6;  ///< mm^3; a smaller volume counts as none

/// Half a voxel. The volume of a cut of few voxels varies by this much with the place of the grid, and differs as much
/// from the volume of its mesh. Measured with balls, a cylinder and a pear, 0.02 to 0.4 mm deep, voxels of 0.05 to 0.15
/// mm. Larger cuts have errors of 1 % beside curved walls, 3 % beside flat ones along the grid.
inline double volumeUncertainty(double voxel_mm) { return 0.5 * voxel_mm * voxel_mm * voxel_mm; }

/// A warning without its full stop if the uncertainty exceeds 3 % of the removed volume.
inline std::optional<std::string> smallCut(double removed_mm3, double voxel_mm) {
  constexpr double kMost = 0.03;
  const double uncertainty = volumeUncertainty(voxel_mm);
  if (!(removed_mm3 > kUnchanged) || uncertainty <= kMost * removed_mm3) return {};
  return fmt::format(
      "the cut is only {:.2g} voxels of {:g} mm: its volume is known to {:.2g} mm3 ({:.0f} %). Smaller voxels give a "
      "more exact volume",
      removed_mm3 / (2 * uncertainty), voxel_mm, uncertainty, 100 * uncertainty / removed_mm3);
}

}  // namespace kerf
