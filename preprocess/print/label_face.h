// The surface of a solid under the rectangle of a label.
#pragma once

#include <cstddef>
#include <limits>

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

struct FaceHeights {
  static constexpr double kReach = 1.5;  ///< mm: surface farther from the frame counts as missing
  std::size_t samples = 0, missing = 0;
  double low = std::numeric_limits<double>::infinity(), high = -low;  ///< mm, of the surface
  double back = -std::numeric_limits<double>::infinity();  ///< highest surface of the far side of the wall behind it
  double front = std::numeric_limits<double>::infinity();  ///< lowest other surface in front of it
};

/// Samples at steps of about 0.2 mm, borders included.   @param deep_mm  how far behind the frame to look.
/// @cost  3 ns a triangle, 1 us a sample.   @thread any.
FaceHeights faceHeights(const Mesh& solid, const LabelFrame& frame, const Point2d& low, const Point2d& high,
                        double deep_mm);

/// kGeometry, place "label".
Error labelError(std::string found, std::string expected, std::string hint);

/// The letters' solid reaches from `low` to `high`, mm along z.
struct LabelSpan {
  double low = 0, high = 0;
};
/// Judges a face, and fills the report's unevenness, depths and wall.
/// @param report  width_mm and height_mm are set.   Errors: kGeometry, as of withLabel().
Expected<LabelSpan> spanOn(const FaceHeights& face, const LabelOptions& label, LabelReport& report);

/// How far behind a label to look, mm.
inline constexpr double kLabelDeep = 10;

}  // namespace kerf::internal
