// Lays the pieces of a model on the bed of a printer.
#pragma once

#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/base/types.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct PrintBed {
  std::string name;               ///< "Form 3"
  Vec3d size_mm = Vec3d::Zero();  ///< width, depth, height of the build volume
};

/// The printers of print/beds.toml in Kerf's data.   Errors: those of reading it.
Expected<std::vector<PrintBed>> printBeds();
/// The bed of a printer by its name, in any case, or of a size such as "145x145x185" mm. Error kNotFound with the
/// names.
Expected<PrintBed> printBedOf(const std::string& words);

struct LaidPiece {
  Rigid3 T_bed_scan;              ///< its motion from the frame of the scan
  Vec3d size_mm = Vec3d::Zero();  ///< of its box on the bed
  bool is_on_base = false;        ///< its flat base lies on the bed; else it stands along `up`
};

struct Laid {
  Mesh mesh;                      ///< in the order of the input; x and y from the corner of the bed, z from its surface
  std::vector<LaidPiece> pieces;  ///< in order of their first triangle
};

/// Lays each piece on its flat base, best one away from `up`, or without a base upright along `up`, side by side with 3
/// mm between the boxes, in the middle of the bed. Turns each about the vertical, in steps of 5 degrees, into the
/// smallest box. The bottom of a base is exactly flat, at z = 0.
/// @pre  ready to print.   Errors: kBadValue if the pieces do not fit, with their size; kGeometry of rigidlyMoved();
/// kCancelled.   @cost  1 s for 300k triangles. @thread any; deterministic.
/// @param keeps_up  lays only on bases within 25 degrees of `up`.
Expected<Laid> laidOnBed(const Mesh& mesh, const Vec3d& up, const PrintBed& bed, const Progress& progress = {},
                         bool keeps_up = false);

}  // namespace kerf
