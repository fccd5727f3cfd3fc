#include "geometry/mesh/ground_shadow.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kerf {
namespace {

constexpr int kN = GroundShadow::kCells;

/// Three box blurs in x and y: close to a Gaussian. Values beyond the map are lost, but the map is empty near its rim.
std::vector<float> blurred(std::vector<float> map, int radius) {
  std::vector<float> line(kN);
  for (int pass = 0; pass < 3; ++pass)
    for (const auto& [along, across] : {std::pair(1, kN), std::pair(kN, 1)})
      for (int row = 0; row < kN; ++row) {
        const auto cell = [&map, row, step = along, stride = across](int i) -> float& {
          return map[static_cast<std::size_t>(row * stride + i * step)];
        };
        for (int i = 0; i < kN; ++i) {
          float sum = 0;
          for (int j = std::max(0, i - radius); j <= std::min(kN - 1, i + radius); ++j) sum += cell(j);
          line[static_cast<std::size_t>(i)] = sum / static_cast<float>(2 * radius + 1);
        }
        for (int i = 0; i < kN; ++i) cell(i) = line[static_cast<std::size_t>(i)];
      }
  return map;
}

}  // namespace

GroundShadow groundShadow(const Mesh& mesh) {
  GroundShadow shadow;
  const Box3 box = bounds(mesh);
  const double extent = std::max(box.size().x(), box.size().y());
  if (mesh.triangles.empty() || !(extent > 0)) return shadow;

  shadow.center = {box.center().x(), box.center().y(), box.min.z()};
  shadow.side = 2 * extent;
  const double cell = shadow.side / kN, fade = 0.3 * std::max(box.size().z(), 0.05 * extent);

  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3d a = mesh.corner(t, 0), u = mesh.corner(t, 1) - a, v = mesh.corner(t, 2) - a;
    const double longest = std::max({u.norm(), v.norm(), (u - v).norm()});
    const int steps = std::clamp(static_cast<int>(std::ceil(2 * longest / cell)), 1, 2 * kN);
    // Points spread evenly over the parallelogram's lower half, each standing for its share of the projected area.
    const double share = 0.5 * std::abs(u.x() * v.y() - u.y() * v.x()) / (0.5 * steps * (steps + 1)) / (cell * cell);
    for (int i = 0; i < steps; ++i)
      for (int j = 0; i + j < steps; ++j) {
        const Vec3d p = a + u * ((i + 1 / 3.0) / steps) + v * ((j + 1 / 3.0) / steps);
        const int x = static_cast<int>((p.x() - shadow.center.x()) / cell + 0.5 * kN);
        const int y = static_cast<int>((p.y() - shadow.center.y()) / cell + 0.5 * kN);
        if (x >= 0 && y >= 0 && x < kN && y < kN)
          shadow.darkness[static_cast<std::size_t>(y * kN + x)] +=
              static_cast<float>(share * std::exp(-(p.z() - box.min.z()) / fade));
      }
  }

  for (float& d : shadow.darkness) d = std::min(d, 1.0f);
  const std::vector<float> near = blurred(shadow.darkness, 2), wide = blurred(shadow.darkness, 7);
  for (std::size_t i = 0; i < near.size(); ++i) shadow.darkness[i] = 0.45f * near[i] + 0.55f * wide[i];
  return shadow;
}

}  // namespace kerf
