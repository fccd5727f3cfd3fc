#include "geometry/field/tissue_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace kerf {
namespace {

constexpr Rgba8 kUnknown{200, 200, 200, 255};

Rgba8 colorOf(Material material, const MaterialTable& table) {
  const MaterialProperties* row = table.find(material);
  return row ? row->color : kUnknown;
}

struct Corner {
  Vec3d position;
  double value;  // negative is kept
};

// The part of a convex polygon where the value, taken as linear along its edges, is negative.
std::vector<Vec3d> keptPart(std::span<const Corner> polygon) {
  std::vector<Vec3d> out;
  for (std::size_t n = 0; n < polygon.size(); ++n) {
    const Corner &a = polygon[n], &b = polygon[(n + 1) % polygon.size()];
    if (a.value < 0) out.push_back(a.position);
    if ((a.value < 0) != (b.value < 0))
      out.push_back(a.position + a.value / (a.value - b.value) * (b.position - a.position));
  }
  return out;
}

void addFan(Mesh& mesh, const std::vector<Vec3d>& polygon, Rgba8 color) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), polygon.begin(), polygon.end());
  for (std::uint32_t n = 2; n < polygon.size(); ++n) {
    mesh.triangles.push_back({first, first + n - 1, first + n});
    mesh.face_colors.push_back(color);
  }
}

}  // namespace

void colorByMaterial(Mesh& mesh, const MaterialField& materials, const MaterialTable& table) {
  mesh.vertex_colors.clear();
  mesh.face_colors.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    mesh.face_colors[t] =
        colorOf(materials.near((mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3), table);
}

Mesh section(const Mesh& surface, const std::function<double(const Vec3d&)>& distance, double voxel,
             const MaterialField& materials, const MaterialTable& table, const Plane& plane) {
  Mesh out;
  std::vector<std::uint32_t> place(surface.vertices.size(), ~0u);  // of a vertex in `out`
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    std::array<Corner, 3> corners;
    for (int k = 0; k < 3; ++k) {
      const Vec3d p = surface.corner(t, k);
      corners[static_cast<std::size_t>(k)] = {p, plane.height(p)};
    }
    const auto below = std::count_if(corners.begin(), corners.end(), [](const Corner& c) { return c.value < 0; });
    if (below == 3) {  // whole: keeps its shared vertices, and with them its smooth shading
      Triangle triangle{};
      for (std::size_t k = 0; k < 3; ++k) {
        std::uint32_t& v = place[surface.triangles[t][k]];
        if (v == ~0u) {
          v = static_cast<std::uint32_t>(out.vertices.size());
          out.vertices.push_back(corners[k].position);
        }
        triangle[k] = v;
      }
      out.triangles.push_back(triangle);
      out.face_colors.push_back(surface.face_colors[t]);
    } else if (below > 0) {
      addFan(out, keptPart(corners), surface.face_colors[t]);
    }
  }

  // The lid: squares of one voxel in the plane.
  const Vec3d u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
  Eigen::AlignedBox2d extent;
  for (const Vec3d& p : surface.vertices)
    extent.extend(Eigen::Vector2d(u.dot(p - plane.point), v.dot(p - plane.point)));
  if (extent.isEmpty()) return out;

  const double h = voxel;
  const Eigen::Vector2i low = (extent.min() / h).array().floor().cast<int>() - 1,
                        high = (extent.max() / h).array().ceil().cast<int>() + 1;
  const auto at = [&](int i, int j) {
    const Vec3d p = plane.point + h * (i * u + j * v);
    return Corner{p, distance(p)};
  };

  std::vector<Corner> row, next;
  const auto fill = [&](std::vector<Corner>& corners, int j) {
    corners.clear();
    for (int i = low[0]; i <= high[0]; ++i) corners.push_back(at(i, j));
  };

  fill(next, low[1]);
  for (int j = low[1]; j < high[1]; ++j) {
    row.swap(next);
    fill(next, j + 1);
    for (std::size_t i = 0; i + 1 < row.size(); ++i) {
      const std::array<Corner, 4> square{row[i], row[i + 1], next[i + 1], next[i]};
      if (std::none_of(square.begin(), square.end(), [](const Corner& c) { return c.value < 0; })) continue;
      const Vec3d middle = (row[i].position + next[i + 1].position) / 2;
      addFan(out, keptPart(square), colorOf(materials.near(middle), table));
    }
  }
  return out;
}

}  // namespace kerf
