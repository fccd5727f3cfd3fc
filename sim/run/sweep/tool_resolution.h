// Are an object's voxels fine enough for a tool?
#pragma once

#include <optional>
#include <string>

#include "geometry/tool/tool.h"

namespace kerf {

/// Limits of an object's voxels for a tool.
struct CoarseVoxels {
  std::string what;     ///< a sentence without its full stop: "round-005 cuts 1.2 voxels wide: ..."
  double finer_mm = 0;  ///< sufficient voxel size, mm; for a pointed tool in a hand: half of the current size, to try
};

/// How the tool is led.
enum class Held {
  kByHand,  ///< pushed: contact determines the depth
  kOnPath,  ///< moved along its path at any resistance, as by a machine
};

/// Distance from a tool's lowest cutting point along z until a ball of that width fits into it, mm. The whole cutting
/// length if it never gets so wide. 0: a blade, or a mesh with its axis outside.
double pointLength(const Tool& tool, double width_mm);

/// A ball of 0.3 mm fits only 0.4 mm and more behind its tip: flames and needles of the rack. A Response that holds
/// only the surface may let such a tool in uncut.
bool isPointed(const Tool& tool);

/// None: the voxels are fine enough. Otherwise one of two.
/// Thin: the cutting part is less than 1.8 voxels across. Measured with a ball of 0.5 mm and two saws in a block: above
/// this limit the removed volume is within 4 % of that of fine voxels (6 % with a feeding hand), below it up to 39 %
/// off.
/// Pointed: four voxels behind its tip it is not yet three voxels wide, or a bur's head never is. Pushed in point first
/// by 0.5 to 3 N for a quarter of a second, flames and needles remove with voxels of 0.1 mm up to 33 % less than with
/// 0.05 mm. With 0.15 and 0.25 mm they and other slender burs are off by up to 56 %, either way. Sideways they cut like
/// others, and on a path they are off only above 0.1 mm: a needle by 12 % at 0.25 mm.
/// @cost  some microseconds; for a mesh with many triangles some milliseconds.
std::optional<CoarseVoxels> tooCoarseFor(const Tool& tool, double voxel_mm, Held held);

}  // namespace kerf
