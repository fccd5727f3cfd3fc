// Points set by the user, with distances and angles between them.
#pragma once

#include <string>
#include <vector>

#include "geometry/base/types.h"

namespace kerf {

class Measure {
 public:
  void add(const Vec3d& point) { points_.push_back(point); }
  void clear() { points_.clear(); }
  const std::vector<Vec3d>& points() const { return points_; }  ///< world, mm

  /// From point n to the next, mm.
  double distance(std::size_t n) const { return (points_[n + 1] - points_[n]).norm(); }
  /// Angle at point n between the directions to its two neighbours, degrees, 0 to 180. @pre 0 < n < last.
  double angle(std::size_t n) const;
  /// Total length, mm.
  double length() const;
  /// "1 to 2: 3.46 mm; angle at 2: 56.3 degrees; 2 to 3: 1.20 mm; together 4.66 mm"; empty with less than two points.
  std::string text() const;

 private:
  std::vector<Vec3d> points_;
};

}  // namespace kerf
