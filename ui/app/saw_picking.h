// How a person points out a plane in the view: three points, a line, a face. What was picked so far, and what to do
// next. No drawing, no window.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/live_surface.h"

namespace kerf {

class Sawing;

class SawPicking {
 public:
  enum class What { kNothing, kPoints, kLine, kFace };

  /// Leaves what was begun before.
  void begin(What what);
  What what() const { return what_; }
  /// What to do next, for a line of text; empty: nothing is being picked.
  std::string hint() const;
  /// The button went down, moves, is let go. When enough is picked the plane is made, and picking ends; what can not
  /// be picked is answered with the error, and the same is asked for again.
  Expected<void> press(Sawing& saw, const Ray& ray);
  void move(const Ray& ray);
  Expected<void> release(Sawing& saw, const Ray& ray);

  /// On the surface, mm: picked so far.
  const std::vector<Vec3d>& points() const { return points_; }
  /// The line that is being drawn; none: the button is up.
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
