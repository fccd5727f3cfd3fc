#include "geometry/sweep.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kerf {
namespace {
constexpr double kNoTurn = 1e-12;  // rad: below, even a metre of lever moves by a picometre
}

SweptTool::SweptTool(const ToolShape& shape, const Rigid3& from, const Rigid3& to)
    : shape_(shape),
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
  // Nothing of the point's motion relative to the tool is faster than this per unit of s.
  double speed = travel_.norm();
  if (angle_ > 0) {
    // The distance from the turning axis through the tip is convex along the way: largest at an end.
    const double a = axis_.cross(x - start_).norm(), b = axis_.cross(x - start_ - travel_).norm();
    speed += angle_ * std::max(a, b);
  }
  double best = at(x, 0.5);
  const auto settled = [&](double lower_bound) {
    return lower_bound >= cutoff || lower_bound >= best - tolerance || best <= floor;
  };
  if (settled(best - 0.5 * speed)) return best;

  struct Interval {
    double s0, f0, s1, f1;
  };
  const double middle = best;
  const double f0 = at(x, 0), f1 = at(x, 1);
  best = std::min({best, f0, f1});
  std::array<Interval, 64> stack;  // depth first, the more promising half last in: never deeper than the bisection
  std::size_t size = 0;
  if (f0 < f1)
    stack[size++] = {0.5, middle, 1, f1}, stack[size++] = {0, f0, 0.5, middle};
  else
    stack[size++] = {0, f0, 0.5, middle}, stack[size++] = {0.5, middle, 1, f1};
  while (size > 0) {
    const Interval i = stack[--size];
    if (settled(0.5 * (i.f0 + i.f1) - 0.5 * speed * (i.s1 - i.s0)) || size + 2 > stack.size()) continue;
    const double s = 0.5 * (i.s0 + i.s1), f = at(x, s);
    best = std::min(best, f);
    if (i.f0 < i.f1)
      stack[size++] = {s, f, i.s1, i.f1}, stack[size++] = {i.s0, i.f0, s, f};
    else
      stack[size++] = {i.s0, i.f0, s, f}, stack[size++] = {s, f, i.s1, i.f1};
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
  for (int c = 0; c < 8; ++c)
    lever = std::max(lever, Vec3d(c & 1 ? tool.max[0] : tool.min[0], c & 2 ? tool.max[1] : tool.min[1],
                                  c & 4 ? tool.max[2] : tool.min[2])
                                .norm());
  const int steps = 1 + static_cast<int>(std::ceil(angle_ / 0.2));
  Box3 box;
  for (int n = 0; n <= steps; ++n) {
    const double s = n / static_cast<double>(steps);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(s * angle_, axis_));
    for (int c = 0; c < 8; ++c) {
      const Vec3d corner(c & 1 ? tool.max[0] : tool.min[0], c & 2 ? tool.max[1] : tool.min[1],
                         c & 4 ? tool.max[2] : tool.min[2]);
      box.add(turn * (from_.rotation * corner) + start_ + s * travel_);
    }
  }
  const double bulge = angle_ / steps;  // arcs stand out from their chords by at most lever * bulge^2 / 8
  box.grow(lever * bulge * bulge / 8);
  return box;
}

}  // namespace kerf
