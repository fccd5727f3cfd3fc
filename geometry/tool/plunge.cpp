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

double turnedPlunge(const RevolvedProfile& outline, const std::vector<RevolvedProfile>& hollows, double depth) {
  constexpr int kSteps = 20000;
  double sum = 0, widest = 0, narrowest = std::numeric_limits<double>::infinity();
  for (int n = 0; n < kSteps; ++n) {
    const double z = outline.lowest() + (n + 0.5) * depth / kSteps;
    double hollow = 0;
    for (const RevolvedProfile& one : hollows) hollow = std::max(hollow, one.radiusAt(z));
    const double radius = outline.radiusAt(z);
    widest = std::max(widest, radius);
    if (radius > hollow) narrowest = std::min(narrowest, hollow);
    if (narrowest < widest) sum += widest * widest - narrowest * narrowest;
  }
  return std::numbers::pi * sum * depth / kSteps;
}

}  // namespace kerf::internal
