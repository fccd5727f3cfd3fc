#include "geometry/tool/sweep.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kerf {
namespace {
constexpr double kNoTurn = 1e-12;  // rad: below, even a metre of lever moves by a picometre
}

SweptTool::SweptTool(const ToolShape& shape, const Rigid3& from, const Rigid3& to)
    : shape_(shape),
      is_convex_(shape.isConvex()),
      from_inverse_(from.rotation.conjugate().toRotationMatrix()),
      start_(from.translation),
      travel_(to.translation - from.translation),
      axis_(Vec3d::UnitZ()),
      from_(from),
      to_(to) {
  Eigen::Quaterniond turn = to.rotation * from.rotation.conjugate();
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  angle_ = 2 * std::atan2(sine, turn.w());
  if (angle_ > kNoTurn)
    axis_ = turn.vec() / sine;
  else
    angle_ = 0;
}

double SweptTool::at(const Vec3d& x, double s) const noexcept {
  Vec3d d = x - start_ - s * travel_;
  if (angle_ > 0) {  // Rodrigues, by -s * angle
    const double c = std::cos(s * angle_), n = std::sin(s * angle_);
    d = c * d - n * axis_.cross(d) + (1 - c) * axis_.dot(d) * axis_;
  }
  return shape_.distance(from_inverse_ * d);
}

double SweptTool::distance(const Vec3d& x, double cutoff, double tolerance, double floor) const noexcept {
  // Largest speed of the point relative to the tool, per unit of s.
  double lever = 0;
  if (angle_ > 0)  // the distance from the turning axis through the tip is convex along the way: largest at an end
    lever = std::max(axis_.cross(x - start_).norm(), axis_.cross(x - start_ - travel_).norm());
  const double speed = travel_.norm() + angle_ * lever;
  const double best = at(x, 0.5);
  const double lower = best - 0.5 * speed;
  if (lower >= cutoff || lower >= best - tolerance || best <= floor) return best;

  // Acceleration of the point in the tool's frame, per unit of s squared: centripetal and Coriolis.
  const double curvature = angle_ * (angle_ * lever + 2 * travel_.norm());
  return is_convex_ ? refineConvex(x, best, curvature, cutoff, tolerance, floor)
                    : refineLipschitz(x, best, speed, cutoff, tolerance, floor);
}

// f(s) = distance at s. For a convex shape f(s) + curvature s^2 / 2 is convex: a tangent plane of the distance at one
// pose lies below it at all others, and the path leaves its own tangent by at most curvature s^2 / 2. On a part of
// width w, f is thus convex up to curvature w^2 / 8; the motion is cut into parts where that is within half the
// tolerance.
double SweptTool::refineConvex(const Vec3d& x, double best, double curvature, double cutoff, double tolerance,
                               double floor) const noexcept {
  const double slack = 0.5 * tolerance;
  const int parts = std::clamp(static_cast<int>(std::ceil(std::sqrt(curvature / (8 * slack)))), 1, 4096);
  const double bend = curvature / (8.0 * parts * parts);

  double left = at(x, 0);
  for (int part = 0; part < parts; ++part) {
    double a = part / static_cast<double>(parts), c = (part + 1) / static_cast<double>(parts), b = 0.5 * (a + c);
    double fa = left, fc = at(x, c), fb = at(x, b);
    left = fc;
    best = std::min({best, fa, fb, fc});

    for (int round = 0; round < 60 && best > floor; ++round) {
      // Convexity: beyond b, f stays above the line through the two points on the other side.
      const double slope_left = (fb - fa) / (b - a), slope_right = (fc - fb) / (c - b);
      const double low_right = fb + std::min(0.0, slope_left) * (c - b);  // on [b, c]
      const double low_left = fb - std::max(0.0, slope_right) * (b - a);  // on [a, b]
      const double open_right = slope_left < 0 ? low_right : fb, open_left = slope_right > 0 ? low_left : fb;
      const double lower = std::min({open_left, open_right, fb}) - bend;
      if (lower >= cutoff || lower >= best - slack - bend) break;

      // Look into the half whose bound is lower; keep three points with the lowest in the middle.
      if (open_right < open_left) {
        const double s = 0.5 * (b + c), f = at(x, s);
        best = std::min(best, f);
        if (f < fb) {
          a = b;
          fa = fb;
          b = s;
          fb = f;
        } else {
          c = s;
          fc = f;
        }
      } else {
        const double s = 0.5 * (a + b), f = at(x, s);
        best = std::min(best, f);
        if (f < fb) {
          c = b;
          fc = fb;
          b = s;
          fb = f;
        } else {
          a = s;
          fa = f;
        }
      }
    }
    if (best <= floor) break;
  }
  return best;
}

double SweptTool::refineLipschitz(const Vec3d& x, double best, double speed, double cutoff, double tolerance,
                                  double floor) const noexcept {
  const auto settled = [&](double lower_bound) {
    return lower_bound >= cutoff || lower_bound >= best - tolerance || best <= floor;
  };
  struct Interval {
    double s0, f0, s1, f1;
  };

  const double middle = best, f0 = at(x, 0), f1 = at(x, 1);
  best = std::min({best, f0, f1});
  std::array<Interval, 64> stack;  // depth first, the more promising half last in: never deeper than the bisection

  std::size_t size = 0;
  const auto push = [&](const Interval& near, const Interval& far) {
    stack[size++] = far;
    stack[size++] = near;
  };

  const Interval first{0, f0, 0.5, middle}, second{0.5, middle, 1, f1};
  f0 < f1 ? push(first, second) : push(second, first);

  while (size > 0) {
    const Interval i = stack[--size];
    if (settled(0.5 * (i.f0 + i.f1) - 0.5 * speed * (i.s1 - i.s0)) || size + 2 > stack.size()) continue;
    const double s = 0.5 * (i.s0 + i.s1), f = at(x, s);
    best = std::min(best, f);
    const Interval low{i.s0, i.f0, s, f}, high{s, f, i.s1, i.f1};
    i.f0 < i.f1 ? push(low, high) : push(high, low);
  }
  return best;
}

bool SweptTool::mayReach(const Vec3d& center, double radius, double cutoff) const noexcept {
  const double tolerance = 0.1 * radius + 1e-6, limit = cutoff + radius + tolerance;
  return distance(center, limit, tolerance, cutoff) < limit;
}

Box3 SweptTool::bounds() const {
  const Box3 tool = shape_.bounds();
  double lever = 0;
  for (int c = 0; c < 8; ++c) lever = std::max(lever, tool.corner(c).norm());

  const int steps = 1 + static_cast<int>(std::ceil(angle_ / 0.2));
  Box3 box;
  for (int n = 0; n <= steps; ++n) {
    const double s = n / static_cast<double>(steps);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(s * angle_, axis_));
    for (int c = 0; c < 8; ++c) box.add(turn * (from_.rotation * tool.corner(c)) + start_ + s * travel_);
  }
  const double bulge = angle_ / steps;  // arcs stand out from their chords by at most lever * bulge^2 / 8
  box.grow(lever * bulge * bulge / 8);
  return box;
}

}  // namespace kerf
