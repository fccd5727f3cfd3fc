#include "geometry/tool/plunge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace kerf::internal {
namespace {

using Piece = RevolvedProfile::Piece;

// Integral of r(z)^2 over [a, b] inside one piece.
double squareIntegral(const Piece& piece, double a, double b) {
  if (piece.arc_radius > 0) {
    const double c = piece.center[0], q = piece.arc_radius * piece.arc_radius, side = piece.is_hollow ? -1 : 1;
    const auto primitive = [&](double z) {  // of (c +- sqrt(q - u^2))^2, u = z - centre
      const double u = std::clamp(z - piece.center[1], -piece.arc_radius, piece.arc_radius);
      const double root = std::sqrt(std::max(0.0, q - u * u));
      return c * c * u + side * c * (u * root + q * std::asin(u / piece.arc_radius)) + q * u - u * u * u / 3;
    };
    return primitive(b) - primitive(a);
  }
  const double ra = piece.radiusAt(a), rb = piece.radiusAt(b);
  return (b - a) * (ra * ra + ra * rb + rb * rb) / 3;
}

// The part of a piece in which it gets wider upwards, as heights; empty if first >= second.
std::pair<double, double> risingPart(const Piece& piece) {
  if (piece.arc_radius > 0) {
    const double middle = std::clamp(piece.center[1], piece.from[1], piece.to[1]);
    return piece.is_hollow ? std::pair(middle, piece.to[1]) : std::pair(piece.from[1], middle);
  }
  return {piece.from[1], piece.to[0] > piece.from[0] ? piece.to[1] : piece.from[1]};
}

// Height in the rising part of a piece where it gets as wide as r: from there on it cuts wider than before.
double heightOfRadius(const Piece& piece, double r) {
  if (piece.arc_radius > 0) {
    const double dr = r - piece.center[0], q = piece.arc_radius * piece.arc_radius;
    const double off = std::sqrt(std::max(0.0, q - dr * dr));
    if (piece.is_hollow) return dr <= -piece.arc_radius ? piece.center[1] : piece.center[1] + off;
    return dr <= 0 ? piece.from[1] : piece.center[1] - off;
  }
  return piece.from[1] + (r - piece.from[0]) / (piece.to[0] - piece.from[0]) * (piece.to[1] - piece.from[1]);
}

// Integral of f over [a, b], Gauss-Legendre in five points, halved until the sum no longer changes.
template <class F>
double integral(const F& f, double a, double b, double accuracy, int depth = 0) {
  static constexpr double kAt[] = {0, 0.5384693101056831, 0.9061798459386640};
  static constexpr double kWeight[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const auto rule = [&](double low, double high) {
    const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
    double sum = kWeight[0] * f(middle);
    for (int n = 1; n < 3; ++n) sum += kWeight[n] * (f(middle - kAt[n] * half) + f(middle + kAt[n] * half));
    return sum * half;
  };
  const double middle = 0.5 * (a + b), whole = rule(a, b), halves = rule(a, middle) + rule(middle, b);
  if (std::abs(whole - halves) <= accuracy || depth > 40) return halves;
  return integral(f, a, middle, 0.5 * accuracy, depth + 1) + integral(f, middle, b, 0.5 * accuracy, depth + 1);
}

}  // namespace

double revolvedPlunge(const RevolvedProfile& head, double depth) {
  double sum = 0, widest = 0, z = head.lowest();
  const double top = head.lowest() + depth;
  for (const Piece& piece : head.pieces()) {
    if (piece.from[1] >= top) break;
    if (piece.to[1] <= piece.from[1]) {  // a step
      widest = std::max({widest, piece.from[0], piece.to[0]});
      continue;
    }

    const double end = std::min(piece.to[1], top);
    widest = std::max(widest, piece.from[0]);
    const auto [rise, peak] = risingPart(piece);
    const double rises_to = std::min(peak, end);
    if (rises_to > rise && piece.radiusAt(rises_to) > widest) {
      const double meets = std::clamp(heightOfRadius(piece, widest), rise, rises_to);
      sum += widest * widest * (meets - z) + squareIntegral(piece, meets, rises_to);
      widest = piece.radiusAt(rises_to);
      z = rises_to;
    }
    sum += widest * widest * (end - z);
    z = end;
  }
  return std::numbers::pi * (sum + widest * widest * (top - z));
}

double pushedCircle(double r, double offset, double limit) {
  if (offset >= r) return 0;
  const double end = std::min(limit, offset > 0 ? std::sqrt(r * r - offset * offset) : r);
  return end * std::sqrt(std::max(0.0, r * r - end * end)) + r * r * std::asin(std::min(1.0, end / r)) -
         2 * offset * end;
}

double sidewaysPlunge(const RevolvedProfile& head, double depth) {
  const double offset = head.largestRadius() - depth;  // of the half-plane, seen from the axis when it is all in
  const double accuracy = 1e-11 * depth * head.largestRadius() * (head.highest() - head.lowest());
  double sum = 0;
  for (const Piece& piece : head.pieces())
    if (piece.to[1] > piece.from[1])
      sum += integral(
          [&](double z) {
            const double r = piece.radiusAt(z);
            return pushedCircle(r, offset, r);
          },
          piece.from[1], piece.to[1], accuracy);
  return sum;
}

namespace {

// Box of the part of a mesh below a height.
Box3 boxBelow(const Mesh& mesh, double top) {
  Box3 part;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Vec3d a = mesh.corner(t, k), b = mesh.corner(t, (k + 1) % 3);
      if (a[2] <= top) part.add(a);
      if ((a[2] < top) != (b[2] < top)) part.add(Vec3d(a + (top - a[2]) / (b[2] - a[2]) * (b - a)));
    }
  return part;
}

// A picture of heights from below: per cell the lowest point of a mesh, infinite without a point below `top`.
class HeightPicture {
 public:
  static constexpr int kCells = 1200;

  HeightPicture(const Box3& part, double cell)
      : part_(part),
        cell_(cell),
        lowest_(static_cast<std::size_t>(kCells) * kCells, std::numeric_limits<double>::infinity()) {}

  void add(const Mesh& mesh, std::size_t t, double top) {
    const Vec3d a = mesh.corner(t, 0), u = mesh.corner(t, 1) - a, v = mesh.corner(t, 2) - a;
    const double twice = u[0] * v[1] - u[1] * v[0];
    if (twice >= 0 || std::min({a[2], a[2] + u[2], a[2] + v[2]}) > top) return;  // seen from below it is turned away

    const auto range = [&](int axis) {
      const double low = a[axis] + std::min({0.0, u[axis], v[axis]}),
                   high = a[axis] + std::max({0.0, u[axis], v[axis]});
      return std::pair(std::clamp(static_cast<int>((low - part_.min[axis]) / cell_), 0, kCells),
                       std::clamp(static_cast<int>((high - part_.min[axis]) / cell_) + 1, 0, kCells));
    };
    const auto [i0, i1] = range(0);
    const auto [j0, j1] = range(1);
    for (int i = i0; i < i1; ++i)
      for (int j = j0; j < j1; ++j) {
        const double x = part_.min[0] + (i + 0.5) * cell_ - a[0], y = part_.min[1] + (j + 0.5) * cell_ - a[1];
        const double s = (x * v[1] - y * v[0]) / twice, r = (u[0] * y - u[1] * x) / twice;
        if (s < 0 || r < 0 || s + r > 1) continue;
        double& z = lowest_[static_cast<std::size_t>(i) * kCells + static_cast<std::size_t>(j)];
        z = std::min(z, a[2] + s * u[2] + r * v[2]);
      }
  }

  const std::vector<double>& lowest() const { return lowest_; }

 private:
  Box3 part_;
  double cell_;
  std::vector<double> lowest_;
};

}  // namespace

double meshPlunge(const Mesh& mesh, double top, double depth) {
  const Box3 part = boxBelow(mesh, top);
  if (part.isEmpty()) return 0;
  const double cell = std::max(part.size()[0], part.size()[1]) / HeightPicture::kCells;
  if (!(cell > 0)) return 0;

  HeightPicture picture(part, cell);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) picture.add(mesh, t, top);

  double sum = 0;
  for (const double z : picture.lowest())
    if (z < top) sum += std::max(0.0, depth - z);
  return sum * cell * cell;
}

}  // namespace kerf::internal
