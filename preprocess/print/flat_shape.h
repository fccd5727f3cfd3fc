// A flat shape: polygons united and triangulated.
#pragma once

#include <vector>

#include "geometry/base/error.h"
#include "geometry/mesh/mesh.h"
#include "preprocess/print/glyph_outlines.h"

namespace kerf::internal {

/// Every edge has one or two triangles, and no two parts touch in a point.
struct FlatShape {
  std::vector<Point2d> points;      ///< mm
  std::vector<Triangle> triangles;  ///< counter-clockwise

  /// Edges with one triangle; the shape lies on the left.
  std::vector<std::array<std::uint32_t, 2>> border() const;
  double area() const;  ///< mm^2
  Point2d low() const, high() const;
  /// Width of the narrowest stroke, mm: between opposite edges over a length of its width, so corners and joins are
  /// none. At most `most_mm`.
  double leastStroke(double most_mm) const;
};

/// Places where the polygons wind around a point other than 0 times. Where parts of it touch in a point, a square of
/// 0.06 mm joins them. The constrained triangulation and its rounds are those of preprocess/close/plane_arrangement.h.
/// @param square_mm  if not 0, no triangle is wider or higher: for a shape that is bent afterwards.
/// Errors: kGeometry.   @cost  5 ms for 20 letters.   @thread any; deterministic.
Expected<FlatShape> united(const std::vector<Contour>& contours, double square_mm = 0);

}  // namespace kerf::internal
