#include "geometry/tool/tool_shape.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

using ShapePoint = RevolvedProfile::Point;

double cross(const ShapePoint& a, const ShapePoint& b) { return a[0] * b[1] - a[1] * b[0]; }

// Squared distance to a line piece, or the squared difference to an arc.
double pieceDistanceSquared(const RevolvedProfile::Piece& piece, const ShapePoint& p) noexcept {
  if (piece.arc_radius > 0) {
    const ShapePoint d = p - piece.center, begin = (piece.is_hollow ? piece.to : piece.from) - piece.center;
    const ShapePoint end = (piece.is_hollow ? piece.from : piece.to) - piece.center;
    if (cross(begin, d) >= 0 && cross(d, end) >= 0) {
      const double off = d.norm() - piece.arc_radius;
      return off * off;
    }
    return std::min((p - piece.from).squaredNorm(), (p - piece.to).squaredNorm());
  }
  const ShapePoint e = piece.to - piece.from, d = p - piece.from;
  const double length = e.squaredNorm();
  const double t = length > 0 ? std::clamp(d.dot(e) / length, 0.0, 1.0) : 0.0;
  return (d - t * e).squaredNorm();
}

}  // namespace

RevolvedProfile& RevolvedProfile::add(const Piece& piece) {
  if ((piece.to - piece.from).squaredNorm() > 0) pieces_.push_back(piece);
  at_ = piece.to;
  return *this;
}

RevolvedProfile& RevolvedProfile::lineTo(double radius, double height) {
  return add({at_, ShapePoint(radius, height), ShapePoint::Zero(), 0, false});
}

RevolvedProfile& RevolvedProfile::arcTo(const ShapePoint& center, const ShapePoint& end) {
  assert(std::abs((end - center).norm() - (at_ - center).norm()) < 1e-9 * std::max(1.0, (end - center).norm()));
  return add({at_, end, center, (end - center).norm(), false});
}

RevolvedProfile& RevolvedProfile::hollowArcTo(const ShapePoint& center, const ShapePoint& end) {
  assert(std::abs((end - center).norm() - (at_ - center).norm()) < 1e-9 * std::max(1.0, (end - center).norm()));
  return add({at_, end, center, (end - center).norm(), true});
}

double RevolvedProfile::Piece::radiusAt(double height) const {
  if (to[1] <= from[1]) return std::max(from[0], to[0]);
  if (arc_radius > 0) {
    const double dz = height - center[1], across = std::sqrt(std::max(0.0, arc_radius * arc_radius - dz * dz));
    return is_hollow ? center[0] - across : center[0] + across;
  }
  return from[0] + (height - from[1]) / (to[1] - from[1]) * (to[0] - from[0]);
}

double RevolvedProfile::largestRadius() const {
  double largest = 0;
  for (const Piece& piece : pieces_) {
    largest = std::max({largest, piece.from[0], piece.to[0]});
    // A bulging arc is widest level with its centre, if it passes there.
    if (piece.arc_radius > 0 && !piece.is_hollow && piece.from[1] <= piece.center[1] && piece.to[1] >= piece.center[1])
      largest = std::max(largest, piece.center[0] + piece.arc_radius);
  }
  return largest;
}

double RevolvedProfile::radiusAt(double height) const {
  double radius = 0;
  for (const Piece& piece : pieces_)
    if (height >= piece.from[1] && height <= piece.to[1]) radius = std::max(radius, piece.radiusAt(height));
  return radius;
}

double RevolvedProfile::highestAsWideAs(double radius) const {
  for (auto piece = pieces_.rbegin(); piece != pieces_.rend(); ++piece) {
    if (piece->to[0] >= radius) return piece->to[1];
    if (piece->arc_radius > 0 && !piece->is_hollow) {  // its upper half narrows
      const double across = radius - piece->center[0];
      if (across > piece->arc_radius) continue;
      const double height =
          piece->center[1] + std::sqrt(std::max(0.0, piece->arc_radius * piece->arc_radius - across * across));
      if (across >= 0 && height >= piece->from[1] && height <= piece->to[1]) return height;
    } else if (piece->from[0] >= radius) {
      if (piece->arc_radius > 0)  // its lower half narrows
        return piece->center[1] -
               std::sqrt(std::max(0.0, piece->arc_radius * piece->arc_radius -
                                           (piece->center[0] - radius) * (piece->center[0] - radius)));
      return piece->from[1] +
             (piece->from[0] - radius) / (piece->from[0] - piece->to[0]) * (piece->to[1] - piece->from[1]);
    }
  }
  return lowest();
}

RevolvedProfile RevolvedProfile::clipped(double low, double high) const {
  RevolvedProfile out(low);
  for (const Piece& piece : pieces_) {
    if (piece.to[1] <= piece.from[1]) {  // a step or a flat end
      if (piece.from[1] > low && piece.from[1] < high) out.lineTo(piece.to[0], piece.to[1]);
      if (piece.from[1] == low && low == lowest()) out.lineTo(piece.to[0], piece.to[1]);
      continue;
    }

    const double from = std::max(low, piece.from[1]), to = std::min(high, piece.to[1]);
    if (from >= to) continue;

    const ShapePoint begin = from == piece.from[1] ? piece.from : ShapePoint(piece.radiusAt(from), from);
    const ShapePoint end = to == piece.to[1] ? piece.to : ShapePoint(piece.radiusAt(to), to);
    out.lineTo(begin[0], begin[1]);
    out.add({begin, end, piece.center, piece.arc_radius, piece.is_hollow});
  }
  return out.close();
}

bool RevolvedProfile::isConvex() const {
  const auto tangent = [](const Piece& piece, const ShapePoint& at) {
    if (piece.arc_radius == 0) return ShapePoint((piece.to - piece.from).normalized());
    const ShapePoint r = (at - piece.center) / piece.arc_radius;
    return ShapePoint(-r[1], r[0]);  // counter-clockwise
  };
  ShapePoint before(1, 0);  // the mirror image arrives level, at best
  for (const Piece& piece : pieces_) {
    if (piece.is_hollow) return false;
    const ShapePoint now = tangent(piece, piece.from);
    if (cross(before, now) < -1e-9) return false;
    before = tangent(piece, piece.to);
  }
  return true;
}

std::vector<ShapePoint> RevolvedProfile::polyline(double tolerance) const {
  std::vector<ShapePoint> out{{0.0, lowest()}};
  for (const Piece& piece : pieces_) {
    if (piece.arc_radius > 0) {
      const auto angle = [&](const ShapePoint& p) {
        return std::atan2(p[1] - piece.center[1], p[0] - piece.center[0]);
      };

      const double a = angle(piece.from);
      double b = angle(piece.to);
      if (piece.is_hollow && b > a) b -= 2 * std::numbers::pi;  // clockwise, across the angle pi

      const double step = 2 * std::acos(1 - std::min(0.5, tolerance / piece.arc_radius));
      const int count = std::max(2, static_cast<int>(std::ceil(std::abs(b - a) / step)));
      for (int n = 1; n < count; ++n) {
        const double t = a + (b - a) * n / count;
        out.push_back(piece.center + piece.arc_radius * ShapePoint(std::cos(t), std::sin(t)));
      }
    }
    out.push_back(piece.to);
  }
  return out;
}

double RevolvedProfile::distance(const ShapePoint& p) const noexcept {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Piece& piece : pieces_) nearest = std::min(nearest, pieceDistanceSquared(piece, p));
  nearest = std::sqrt(nearest);
  const bool inside = p[1] > lowest() && p[1] < highest() && p[0] < radiusAt(p[1]);
  return inside ? -nearest : nearest;
}

RevolvedShape::RevolvedShape(RevolvedProfile profile)
    : profile_(std::move(profile)), radius_(profile_.largestRadius()), is_convex_(profile_.isConvex()) {
  assert(profile_.end()[0] == 0);
}

double RevolvedShape::distance(const Vec3d& p) const noexcept {
  return profile_.distance({std::hypot(p[0], p[1]), p[2]});
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

ExtrudedShape::ExtrudedShape(RevolvedProfile profile, double thickness)
    : profile_(std::move(profile)), half_(0.5 * thickness), is_convex_(profile_.isConvex()) {
  assert(profile_.end()[0] == 0);
}

double ExtrudedShape::distance(const Vec3d& p) const noexcept {
  const double flat = profile_.distance({std::abs(p[0]), p[2]}), off = std::abs(p[1]) - half_;
  return std::hypot(std::max(flat, 0.0), std::max(off, 0.0)) + std::min(0.0, std::max(flat, off));
}

Box3 ExtrudedShape::bounds() const {
  const double radius = profile_.largestRadius();
  Box3 box;
  box.add(Vec3d(-radius, -half_, profile_.lowest()));
  box.add(Vec3d(radius, half_, profile_.highest()));
  return box;
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

ToolShape::Symmetry UnionShape::symmetry() const {
  const bool is_revolved = std::all_of(parts_.begin(), parts_.end(),
                                       [](const auto& part) { return part->symmetry() == Symmetry::kRevolved; });
  return is_revolved ? Symmetry::kRevolved : Symmetry::kNone;
}

}  // namespace kerf
