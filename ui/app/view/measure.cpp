#include "ui/app/view/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {

double Measure::angle(std::size_t n) const {
  const Vec3d before = points_[n - 1] - points_[n], after = points_[n + 1] - points_[n];
  return std::atan2(before.cross(after).norm(), before.dot(after)) * 180 / std::numbers::pi;
}

double Measure::length() const {
  double out = 0;
  for (std::size_t n = 0; n + 1 < points_.size(); ++n) out += distance(n);
  return out;
}

std::string Measure::text() const {
  std::string out;
  for (std::size_t n = 0; n + 1 < points_.size(); ++n) {
    if (n > 0) out += fmt::format("; angle at {}: {:.1f} degrees", n + 1, angle(n));
    out += fmt::format("{}{} to {}: {:.2f} mm", n > 0 ? "; " : "", n + 1, n + 2, distance(n));
  }
  if (points_.size() > 2) out += fmt::format("; together {:.2f} mm", length());
  return out;
}

}  // namespace kerf
