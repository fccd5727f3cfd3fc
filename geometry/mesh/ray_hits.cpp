#include "geometry/mesh/ray_hits.h"

#include <algorithm>
#include <cmath>

namespace kerf {

std::vector<RayHit> rayHits(const Mesh& mesh, const Vec3d& origin, const Vec3d& direction) {
  const double length = direction.norm();
  const Vec3d d = direction / length;
  // Widens triangles at edges: otherwise rounding could leave a gap between two neighbours.
  constexpr double kEdge = 1e-9;

  std::vector<RayHit> all;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3d a = mesh.corner(t, 0) - origin, b = mesh.corner(t, 1) - origin, c = mesh.corner(t, 2) - origin;
    const Vec3d n = (b - a).cross(c - a);
    const double facing = d.dot(n);
    const double size = n.norm();
    if (!(std::abs(facing) > 1e-12 * size)) continue;

    // Shares of the corners: thrice the volumes between the ray and the edges.
    const double u = d.dot(b.cross(c)) / facing, v = d.dot(c.cross(a)) / facing, w = 1 - u - v;
    if (u < -kEdge || v < -kEdge || w < -kEdge) continue;
    const double way = a.dot(n) / facing;
    if (way >= 0) all.push_back({way / length, t, facing < 0});
  }
  std::sort(all.begin(), all.end(),
            [](const RayHit& x, const RayHit& y) { return x.way != y.way ? x.way < y.way : x.triangle < y.triangle; });

  std::vector<RayHit> out;
  const double together = 1e-9 / length;
  for (const RayHit& hit : all) {
    const auto same = std::find_if(out.rbegin(), out.rend(), [&](const RayHit& other) {
      return other.enters == hit.enters || other.way < hit.way - together;
    });
    const bool is_repeated = same != out.rend() && same->enters == hit.enters && same->way >= hit.way - together;
    if (!is_repeated) out.push_back(hit);
  }
  return out;
}

}  // namespace kerf
