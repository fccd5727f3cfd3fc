#include "preprocess/internal/winding.h"

#include <cmath>
#include <numbers>

namespace kerf::internal {
namespace {

/// Half the solid angle of triangle abc seen from p, positive if p is behind it.
double halfSolidAngle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double numerator = a.dot(b.cross(c));
  const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return std::atan2(numerator, denominator);
}

double one(const Mesh& mesh, std::size_t t, const Vec3d& p) {
  return halfSolidAngle(mesh.corner(t, 0) - p, mesh.corner(t, 1) - p, mesh.corner(t, 2) - p);
}

}  // namespace

double windingNumber(const Mesh& mesh, const Vec3d& p, std::span<const char> skip) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (skip.empty() || !skip[t]) sum += one(mesh, t, p);
  return sum / (2 * std::numbers::pi);
}

double windingNumberExcept(const Mesh& mesh, const Vec3d& p, std::span<const std::uint32_t> except) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    bool listed = false;
    for (const std::uint32_t e : except) listed = listed || e == t;
    if (!listed) sum += one(mesh, t, p);
  }
  return sum / (2 * std::numbers::pi);
}

}  // namespace kerf::internal
