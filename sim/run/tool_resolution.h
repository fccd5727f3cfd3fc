// Are an object's voxels fine enough for a tool?
#pragma once

#include <optional>
#include <string>

#include "geometry/tool/tool.h"

namespace kerf {

/// What an object's voxels do not tell of a tool.
struct CoarseVoxels {
  std::string what;     ///< a sentence without its full stop: "round-005 cuts 1.2 voxels wide: ..."
  double finer_mm = 0;  ///< voxels that do, mm; of a point that a hand pushes those to try, half of what there are
};

/// What leads the tool.
enum class Held {
  kByHand,  ///< pushed: how deep it gets is up to contact
  kOnPath,  ///< moved along its path whatever resists, as a machine does
};

/// How far a tool's point goes back until a ball of that width fits into it, mm. The way is along z from what cuts
/// lowest; all of what cuts if it never gets so wide. 0: a blade, a mesh whose axis is outside it.
double pointLength(const Tool& tool, double width_mm);

/// A ball of 0.3 mm fits only 0.4 mm and more behind its tip: flames and needles of the rack. Where nothing but its
/// surface is held (Response), such a tool may go in uncut.
bool isPointed(const Tool& tool);

/// None: they are fine enough. Otherwise one of two.
/// Thin: what cuts is less than 1.8 voxels across. Measured with a ball of 0.5 mm and two saws in a block: from there
/// on the removed volume is within 4 % of that of fine voxels (6 % with a feeding hand), below it up to 39 % off.
/// Pointed: four voxels behind its tip it is not yet three voxels wide, or a bur's head never is. Pushed in point first
/// by 0.5 to 3 N for a quarter of a second, flames and needles remove with voxels of 0.1 mm up to 33 % less than with
/// 0.05 mm; with 0.15 and 0.25 mm they and other slender burs are off by up to 56 %, either way. Sideways they cut as
/// others do, and on a path they are off only above 0.1 mm: a needle by 12 % at 0.25 mm.
/// @cost  some microseconds; of a mesh with many triangles some milliseconds.
std::optional<CoarseVoxels> tooCoarseFor(const Tool& tool, double voxel_mm, Held held);

}  // namespace kerf
