// Cuts of an object by planes and a round hole: their numbers, and the sides that a piece is on.
//
// Frame: the object as loaded, mm. Above is the side that a normal points to. The hole is lost from both parts; without
// planes it is the whole cut, and everything outside it is above.
//
//        above          the part above all planes
//     ─────────── kerf  lost: half of it on either side of a plane
//        rest           below at least one
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "geometry/base/round_hole.h"
#include "geometry/base/types.h"

namespace kerf {

/// Planes and hole of one cut. A value of fixed size: crosses queues without allocation.
struct CutPlanes {
  static constexpr std::size_t kMost = 5;  ///< a die: four sides and a base
  static constexpr double kMostKerf = 10;  ///< mm

  double kerf_mm = 0;
  std::uint32_t count = 0;
  std::array<std::array<double, 6>, kMost> numbers{};  ///< each: normal (unit), point
  std::array<double, 8> hole_numbers{};                ///< diameter, depth, axis (unit), mouth; diameter 0: no hole
  bool operator==(const CutPlanes&) const = default;

  void add(const Plane& plane) noexcept {
    const Vec3d &n = plane.normal, &p = plane.point;
    if (count < kMost) numbers[count++] = {n[0], n[1], n[2], p[0], p[1], p[2]};
  }
  Plane plane(std::size_t n) const noexcept {
    const auto& v = numbers[n];
    return {{v[3], v[4], v[5]}, {v[0], v[1], v[2]}};
  }
  std::vector<Plane> planes() const {
    std::vector<Plane> out;
    for (std::size_t n = 0; n < count; ++n) out.push_back(plane(n));
    return out;
  }
  bool hasHole() const noexcept { return hole_numbers[0] > 0; }
  RoundHole hole() const noexcept {
    const auto& v = hole_numbers;
    return {{v[5], v[6], v[7]}, {v[2], v[3], v[4]}, v[0], v[1]};
  }
  void setHole(const RoundHole& hole) noexcept {
    const Vec3d &a = hole.axis, &p = hole.mouth;
    hole_numbers = {hole.diameter, hole.depth, a[0], a[1], a[2], p[0], p[1], p[2]};
  }
  /// A plane or a hole at least, finite numbers, unit normals, and a kerf in range. @rt
  bool isUsable() const noexcept {
    if (count > kMost || !(kerf_mm >= 0 && kerf_mm <= kMostKerf)) return false;
    if (hasHole() ? !hole().isUsable() : count == 0) return false;
    for (std::size_t n = 0; n < count; ++n) {
      const Plane p = plane(n);
      if (!p.point.allFinite() || !(p.point.norm() < 1e5) || !(std::abs(p.normal.norm() - 1) < 1e-6)) return false;
    }
    return true;
  }

  /// Height of a point in the part above (`is_above`) or in the rest, mm: negative outside, at least the distance from
  /// the other part and the hole within. @rt
  double height(const Vec3d& p, bool is_above) const noexcept {
    const double at_planes = heightAtPlanes(p, is_above);
    return hasHole() ? std::min(at_planes, hole().outside(p)) : at_planes;
  }
  /// Direction in which height() grows, unit. @rt
  Vec3d upwards(const Vec3d& p, bool is_above) const noexcept {
    if (hasHole() && hole().outside(p) < heightAtPlanes(p, is_above)) return hole().outwards(p);
    std::size_t nearest = 0;
    for (std::size_t n = 1; n < count; ++n)
      if (plane(n).height(p) < plane(nearest).height(p)) nearest = n;
    const Vec3d normal = plane(nearest).normal;
    return is_above ? normal : Vec3d(-normal);
  }
  /// height() without the hole. Without planes all is above. @rt
  double heightAtPlanes(const Vec3d& p, bool is_above) const noexcept {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t n = 0; n < count; ++n) least = std::min(least, plane(n).height(p));
    return (is_above ? least : -least) - 0.5 * kerf_mm;
  }
};

/// Parts that stay; the other one leaves the scene.
enum class PlaneKeep : std::uint8_t { kBoth = 0, kAbove = 1, kBelow = 2 };

/// One side of one cut.
struct PlaneSide {
  std::uint32_t cut = 0;  ///< number of the cut in its session or run: both of its parts have the same
  bool is_above = true;
  CutPlanes planes;
  bool operator==(const PlaneSide&) const = default;
};

/// Sides of a piece, in the order of the cuts. Null: no plane cut it. Shared by the pieces of a split.
using PlaneSides = std::shared_ptr<const std::vector<PlaneSide>>;

}  // namespace kerf
