#include "geometry/tool_shape.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace kerf {
namespace {

using Point = RevolvedProfile::Point;

double cross(const Point& a, const Point& b) { return a[0] * b[1] - a[1] * b[0]; }

// Squared distance to a line piece, or the squared difference to an arc.
double pieceDistanceSquared(const RevolvedProfile::Piece& piece, const Point& p) noexcept {
  if (piece.arc_radius > 0) {
    const Point d = p - piece.center;
    if (cross(piece.from - piece.center, d) >= 0 && cross(d, piece.to - piece.center) >= 0) {
      const double off = d.norm() - piece.arc_radius;
      return off * off;
    }
    return std::min((p - piece.from).squaredNorm(), (p - piece.to).squaredNorm());
  }
  const Point e = piece.to - piece.from, d = p - piece.from;
  const double length = e.squaredNorm();
  const double t = length > 0 ? std::clamp(d.dot(e) / length, 0.0, 1.0) : 0.0;
  return (d - t * e).squaredNorm();
}

}  // namespace

RevolvedProfile& RevolvedProfile::lineTo(double radius, double height) {
  const Point to(radius, height);
  if ((to - at_).squaredNorm() > 0) pieces_.push_back({at_, to, Point::Zero(), 0});
  at_ = to;
  return *this;
}

RevolvedProfile& RevolvedProfile::arcTo(const Point& center, const Point& end) {
  assert(std::abs((end - center).norm() - (at_ - center).norm()) < 1e-9);
  pieces_.push_back({at_, end, center, (end - center).norm()});
  at_ = end;
  return *this;
}

double RevolvedProfile::largestRadius() const {
  double largest = 0;
  for (const Piece& piece : pieces_) {
    largest = std::max({largest, piece.from[0], piece.to[0]});
    // An arc is widest level with its centre, if it passes there.
    if (piece.arc_radius > 0 && piece.from[1] <= piece.center[1] && piece.to[1] >= piece.center[1])
      largest = std::max(largest, piece.center[0] + piece.arc_radius);
  }
  return largest;
}

double RevolvedProfile::radiusAt(double height) const {
  double radius = 0;
  for (const Piece& piece : pieces_) {
    if (height < piece.from[1] || height > piece.to[1]) continue;
    if (piece.arc_radius > 0) {
      const double dz = height - piece.center[1];
      radius =
          std::max(radius, piece.center[0] + std::sqrt(std::max(0.0, piece.arc_radius * piece.arc_radius - dz * dz)));
    } else if (piece.to[1] > piece.from[1]) {
      const double t = (height - piece.from[1]) / (piece.to[1] - piece.from[1]);
      radius = std::max(radius, piece.from[0] + t * (piece.to[0] - piece.from[0]));
    } else {
      radius = std::max({radius, piece.from[0], piece.to[0]});
    }
  }
  return radius;
}

bool RevolvedProfile::isConvex() const {
  const auto tangent = [](const Piece& piece, const Point& at) {
    if (piece.arc_radius == 0) return Point((piece.to - piece.from).normalized());
    const Point r = (at - piece.center) / piece.arc_radius;
    return Point(-r[1], r[0]);  // counter-clockwise
  };
  Point before(1, 0);  // the mirror image arrives level, at best
  for (const Piece& piece : pieces_) {
    const Point now = tangent(piece, piece.from);
    if (cross(before, now) < -1e-9) return false;
    before = tangent(piece, piece.to);
  }
  return true;
}

RevolvedShape::RevolvedShape(RevolvedProfile profile)
    : profile_(std::move(profile)), radius_(profile_.largestRadius()), is_convex_(profile_.isConvex()) {
  assert(profile_.end()[0] == 0);
}

double RevolvedShape::distance(const Vec3d& p) const noexcept {
  const Point q(std::hypot(p[0], p[1]), p[2]);
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& piece : profile_.pieces()) nearest = std::min(nearest, pieceDistanceSquared(piece, q));
  nearest = std::sqrt(nearest);
  const bool inside = q[1] > profile_.lowest() && q[1] < profile_.highest() && q[0] < profile_.radiusAt(q[1]);
  return inside ? -nearest : nearest;
}

Box3 RevolvedShape::bounds() const {
  Box3 box;
  box.add(Vec3d(-radius_, -radius_, profile_.lowest()));
  box.add(Vec3d(radius_, radius_, profile_.highest()));
  return box;
}

double BoxShape::distance(const Vec3d& p) const noexcept {
  const Vec3d half = 0.5 * (box_.max - box_.min) - Vec3d::Constant(rounding_);
  const Vec3d d = (p - box_.center()).cwiseAbs() - half;
  return d.cwiseMax(0.0).norm() + std::min(0.0, d.maxCoeff()) - rounding_;
}

double UnionShape::distance(const Vec3d& p) const noexcept {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& part : parts_) nearest = std::min(nearest, part->distance(p));
  return nearest;
}

Box3 UnionShape::bounds() const {
  Box3 box;
  for (const auto& part : parts_) box.add(part->bounds());
  return box;
}

}  // namespace kerf
