// Compares a tool's removal with its nominal volume: the measurement of `kerf tool check`.
#pragma once

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/tool/tool.h"

namespace kerf {

struct ToolCheck {
  double voxel_mm = 0, depth_mm = 0;
  double block_width_mm = 0;  ///< blades: the part of the blade's length that meets the block
  double expected_mm3 = 0;    ///< plungeVolume; for a blade the block's share of it
  double removed_mm3 = 0;     ///< volume of the meshed removed solid
  double errorPercent() const { return 100 * (removed_mm3 - expected_mm3) / expected_mm3; }
  bool passed() const { return errorPercent() <= kLargestError && errorPercent() >= -kLargestError; }
  static constexpr double kLargestError = 0.5;  ///< percent
};

/// Voxel that resolves a tool well, mm: diameter of its cutting part / 20 (a flat one's height / 6), a blade's
/// thickness / 10.
double defaultVoxel(const Tool& tool);

/// Plunges the tool along plunge_direction into a block sampled at `voxel_mm` (0: defaultVoxel), by 1.5 head lengths,
/// at most 3 mm (blade: 3 mm), and measures the removed volume. Block and tool stand askew to the grid, so that no wall
/// gains from alignment. Long blades meet a block 4 mm wide.
/// Errors: kBadValue when the voxel is not positive or larger than a third of the tool's head diameter or kerf;
/// kCancelled. @cost  a second or two at the default voxel; a minute for a mesh of a million triangles.
Expected<ToolCheck> checkTool(const Tool& tool, double voxel_mm = 0, const Progress& progress = {});

}  // namespace kerf
