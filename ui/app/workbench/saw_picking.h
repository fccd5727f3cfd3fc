// Picking a plane in the view: three points, a line, a face, a tooth for a die. Keeps the picked points and gives the
// next hint. No drawing, no window.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/view/live_surface.h"

namespace kerf {

class Sawing;

class SawPicking {
 public:
  enum class What { kNothing, kPoints, kLine, kFace, kDie };

  /// Discards an unfinished pick.
  void begin(What what);
  What what() const { return what_; }
  /// Hint for the next pick, one line; empty: no pick is active.
  std::string hint() const;
  /// Button press, move and release. A complete pick makes the plane and ends picking. A failed pick returns its error
  /// and can be repeated.
  Expected<void> press(Sawing& saw, const Ray& ray);
  void move(const Ray& ray);
  Expected<void> release(Sawing& saw, const Ray& ray);

  /// Picked points on the surface, mm.
  const std::vector<Vec3d>& points() const { return points_; }
  /// Start of the line being drawn; none: the button is up.
  const std::optional<Ray>& lineFrom() const { return from_; }
  const Ray& lineTo() const { return to_; }

 private:
  What what_ = What::kNothing;
  std::vector<Ray> rays_;
  std::vector<Vec3d> points_;
  std::optional<Ray> from_;
  Ray to_;
};

}  // namespace kerf
