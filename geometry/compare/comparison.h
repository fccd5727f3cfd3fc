// Two meshes compared by their distance: planned and achieved, or before and after.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh_distance.h"

namespace kerf {

struct ComparisonOptions {
  double tolerance_mm = 0.1;  ///< > 0: deviations up to it, either way, are within the band
  /// Longest edge of the parts that triangles are divided into, each measured at its middle; smaller is finer and
  /// slower. 0: about 200 000 parts of equal size; more of a mesh of needles, at most 5 million.
  double spacing_mm = 0;
};

struct DeviationAt {
  double mm = 0;
  Vec3d at = Vec3d::Zero();
};

/// Deviations of the points of one mesh from the other mesh. Positive: the second mesh has more material than the
/// first; negative: it lacks material. Means and shares are weighted by area.
struct Deviations {
  double area_mm2 = 0;      ///< compared
  double excluded_mm2 = 0;  ///< left out: their nearest point lies on a boundary, so the other mesh may end there
  double mean_mm = 0, mean_abs_mm = 0, rms_mm = 0;
  double p95_mm = 0;                       ///< 95 % of the area deviate less than this, either way
  DeviationAt most, least;                 ///< largest and smallest, at samples and vertices
  double within = 0, over = 0, under = 0;  ///< shares of the area, within the band, above and below it; sum 1
  double unchanged = 0;                    ///< share of the area that deviates by 0
  std::size_t samples = 0;
  double spacing_mm = 0;           ///< ComparisonOptions::spacing_mm in use
  double normals_agree = 0;        ///< mean cosine between both surfaces; negative: one of them is inside out
  std::vector<float> at_vertex;    ///< mm; NaN where excluded
  std::vector<float> value, area;  ///< of each sample, mm and mm^2; excluded ones are missing

  static constexpr double kSame = 1e-6;  ///< mm: up to it a distance is rounding, and counts as 0
  /// max(|most|, |least|): the one-sided Hausdorff distance, to the spacing.
  const DeviationAt& largest() const { return std::abs(most.mm) >= std::abs(least.mm) ? most : least; }
};

struct Comparison {
  Deviations of_first;   ///< points of the first mesh from the second
  Deviations of_second;  ///< points of the second mesh from the first
  double hausdorff_mm() const { return std::max(std::abs(of_first.largest().mm), std::abs(of_second.largest().mm)); }
};

/// Measures both ways: every vertex, and triangles in parts of equal size. Distances are exact. The largest deviation
/// between two samples is at most spacing_mm larger than the largest one reported, because distances change by at most
/// 1 mm per mm.
/// Open meshes: of a point whose nearest point lies on the boundary of the other mesh nothing is known; it is excluded.
/// Fails with kEmpty if a mesh has no area, or if everything is excluded; with kCancelled.
/// @param first_distance, second_distance  of the same meshes.
/// @cost 4 us a sample on one core, parallel; deterministic on any number of threads.
Expected<Comparison> compareMeshes(const Mesh& first, const MeshDistance& first_distance, const Mesh& second,
                                   const MeshDistance& second_distance, const ComparisonOptions& options = {},
                                   const Progress& progress = {});

}  // namespace kerf
