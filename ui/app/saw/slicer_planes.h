// Planes of 3D Slicer: markups of type Plane in its .mrk.json files (schema markups 1.0).
//
// Kerf's planes are in LPS, mm: the frame of Slicer's mesh files and of Kerf's label volumes. A plane written in RAS
// has its x and y negated. A plane under a transform of Slicer counts as written: harden the transform first.
#pragma once

#include <filesystem>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/saw/saw_plan.h"

namespace kerf {

struct SlicerPlanes {
  std::vector<SawPlane> planes;  ///< in LPS, mm; at least one. Sides limited to SawPlan::kMostSide
  PlanOrigin origin;
};

/// A name that ends in .json.
bool isSlicerFile(const std::filesystem::path& file);
/// Reads centre and normal, or three control points of older files. The teeth of a saw enter along the plane's axis
/// that points down (-z) most. Errors name file, markup and key: kBadFormat, kBadValue, kUnsupported (units, frames),
/// kGeometry (three points on a line), kNotFound.
Expected<SlicerPlanes> readSlicerPlanes(const std::filesystem::path& file);

}  // namespace kerf
