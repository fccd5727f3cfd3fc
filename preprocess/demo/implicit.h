// Building blocks of implicit solids: values negative inside, in mm, cheap, without state. For Kerf's demo anatomy.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "geometry/base/types.h"

namespace kerf::internal {

using Vec2d = Eigen::Vector2d;

// ------------------------------------------------------------------------------------------------------ numbers

/// 0 up to `from`, 1 beyond `to`, smooth between.
inline double smoothStep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}
inline double mix(double a, double b, double t) { return a + (b - a) * t; }
inline double square(double x) { return x * x; }
/// 1 at 0, 1/e at `width`.
inline double bell(double x, double width) { return std::exp(-(x / width) * (x / width)); }

/// A number in [-1, 1) that depends on three integers and a seed, and looks random.
inline double latticeNoise(int i, int j, int k, std::uint32_t seed) {
  std::uint32_t h = seed * 0x9e3779b9u ^ static_cast<std::uint32_t>(i) * 0x85ebca6bu ^
                    static_cast<std::uint32_t>(j) * 0xc2b2ae35u ^ static_cast<std::uint32_t>(k) * 0x27d4eb2fu;
  h ^= h >> 15;
  h *= 0x2c1b3c6du;
  h ^= h >> 12;
  h *= 0x297a2d39u;
  h ^= h >> 15;
  return h / 2147483648.0 - 1;
}
/// Smooth noise in [-1, 1) with bumps one unit wide: lattice noise blended between the corners of unit cubes.
inline double valueNoise(const Vec3d& p, std::uint32_t seed) {
  const Vec3d low = p.array().floor(), f = p - low;
  double sum = 0;
  for (int c = 0; c < 8; ++c) {
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double t = smoothStep(0, 1, f[axis]);
      weight *= c >> axis & 1 ? t : 1 - t;
    }
    sum += weight * latticeNoise(static_cast<int>(low.x()) + (c & 1), static_cast<int>(low.y()) + (c >> 1 & 1),
                                 static_cast<int>(low.z()) + (c >> 2 & 1), seed);
  }
  return sum;
}

// -------------------------------------------------------------------------------------------------- combinations

/// Smooth minimum (union) and maximum (intersection): differ from the sharp ones by at most k / 4, where both arguments
/// are equal, and not at all where they differ by k or more.
inline double smoothMin(double a, double b, double k) {
  const double h = std::max(0.0, k - std::abs(a - b));
  return std::min(a, b) - h * h / (4 * k);
}
inline double smoothMax(double a, double b, double k) { return -smoothMin(-a, -b, k); }
/// `a` without `b`.
inline double smoothMinus(double a, double b, double k) { return smoothMax(a, -b, k); }

// -------------------------------------------------------------------------------------------------------- curves

struct Knot {
  double z, value;
};
/// Smooth curve through knots in order of z (Catmull-Rom tangents), constant beyond the ends.
inline double curve(std::span<const Knot> knots, double z) {
  if (z <= knots.front().z) return knots.front().value;
  if (z >= knots.back().z) return knots.back().value;
  std::size_t i = 1;
  while (knots[i].z < z) ++i;
  const Knot a = knots[i - 1], b = knots[i];
  const auto slope = [&](std::size_t j) {
    if (j == 0 || j + 1 == knots.size()) return 0.0;
    return (knots[j + 1].value - knots[j - 1].value) / (knots[j + 1].z - knots[j - 1].z);
  };
  const double w = b.z - a.z, t = (z - a.z) / w, u = 1 - t;
  return (1 + 2 * t) * u * u * a.value + t * t * (1 + 2 * u) * b.value + w * t * u * (u * slope(i - 1) - t * slope(i));
}

/// Distance to a chain of segments in the plane.
inline double distanceToChain(std::span<const Vec2d> chain, const Vec2d& p) {
  double nearest = 1e9;
  for (std::size_t i = 1; i < chain.size(); ++i) {
    const Vec2d a = chain[i - 1], d = chain[i] - a;
    const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - a - t * d).norm());
  }
  return nearest;
}

/// (|u|^n + |v|^n)^(1/n): 1 on a rounded rectangle.
inline double roundedNorm(double u, double v, double n) {
  return std::pow(std::pow(std::abs(u), n) + std::pow(std::abs(v), n), 1 / n);
}

// -------------------------------------------------------------------------------------------------------- bodies

/// Ellipsoid along the axes about the origin; the distance itself on the surface, first order near it.
inline double ellipsoid(const Vec3d& p, const Vec3d& half) {
  const double k = p.cwiseQuotient(half).norm(), g = p.cwiseQuotient(half.cwiseAbs2()).norm();
  return g > 1e-9 ? k * (k - 1) / g : -half.minCoeff();
}

/// A place on the axis of a tube, and how thick it is there.
struct Bead {
  Vec3d at;       ///< mm
  double radius;  ///< mm
};
/// Round tube along a chain of beads, with round ends; its radius runs linearly between them. Exact for equal radii,
/// else short by less than the slope squared over two.
inline double tube(std::span<const Bead> beads, const Vec3d& p) {
  double nearest = 1e9;
  for (std::size_t i = 1; i < beads.size(); ++i) {
    const Vec3d a = beads[i - 1].at, d = beads[i].at - a;
    const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - a - t * d).norm() - mix(beads[i - 1].radius, beads[i].radius, t));
  }
  return nearest;
}

}  // namespace kerf::internal
