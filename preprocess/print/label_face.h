// The surface of a solid under the rectangle of a label.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "geometry/mesh/mesh.h"
#include "preprocess/print/label.h"

namespace kerf::internal {

/// The plane of a label, or a cylinder around an axis along `up`: x to the right, y up, z outwards, seen from outside.
struct LabelFrame {
  Vec3d point = Vec3d::Zero();                                                 ///< mm
  Vec3d right = Vec3d::UnitX(), up = Vec3d::UnitY(), normal = Vec3d::UnitZ();  ///< right-handed, unit
  double radius_mm = 0;  ///< of the cylinder; < 0: the wall is hollow, its axis lies outside; 0: a plane

  Vec3d normalAt(double x) const;
  Vec3d at(double x, double y, double z) const;
};

/// Heights above a frame at the knots of a grid from corner to corner of a rectangle, mm.
struct HeightGrid {
  Point2d low = Point2d::Zero(), high = Point2d::Zero();
  int columns = 0, rows = 0;  ///< at least 2 each, or 0: height 0 everywhere
  std::vector<double> z{};    ///< column by column

  double& knot(int c, int r) { return z[static_cast<std::size_t>(c * rows + r)]; }
  double knot(int c, int r) const { return z[static_cast<std::size_t>(c * rows + r)]; }
  double at(const Point2d& p) const;  ///< bilinear; beyond the rectangle that of its border
  HeightGrid smoothed() const;        ///< the mean over 1.4 x 1.4 mm
  double steepest() const;            ///< the largest slope between neighbours
};

struct FaceHeights {
  static constexpr double kReach = 1.5;  ///< mm: surface farther from the frame counts as missing
  std::size_t missing = 0;               ///< knots without surface
  HeightGrid surface;
  std::vector<double> back, front;  ///< per knot: the far side of the wall, another surface in front; or infinite
};

/// Knots at steps of about 0.2 mm.   @param deep_mm  how far behind the frame to look.
/// @cost  3 ns a triangle, 1 us a knot.   @thread any.
FaceHeights faceHeights(const Mesh& solid, const LabelFrame& frame, const Point2d& low, const Point2d& high,
                        double deep_mm);

/// kGeometry, place "label".
Error labelError(std::string found, std::string expected, std::string hint);

/// The letters' solid reaches from `low` to `high` above the ground, mm along z.
struct LabelSpan {
  double low = 0, high = 0;
  HeightGrid ground{};  ///< the smoothed surface, if it is not even; else 0
};
/// Judges a face, and fills the report's unevenness, depths and wall.
/// @param report  width_mm and height_mm are set.   Errors: kGeometry, as of withLabel().
Expected<LabelSpan> spanOn(const FaceHeights& face, const LabelOptions& label, LabelReport& report);

/// How far behind a label to look, mm.
inline constexpr double kLabelDeep = 10;

}  // namespace kerf::internal
