#include "geometry/tool/tool_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

std::uint32_t addVertex(Mesh& mesh, const Vec3d& p) {
  mesh.vertices.push_back(p);
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

Mesh revolve(const RevolvedProfile& profile, double tolerance, Rgba8 color) {
  const std::vector<RevolvedProfile::Point> outline = profile.polyline(tolerance);
  const double step = 2 * std::acos(1 - std::min(0.3, tolerance / profile.largestRadius()));
  const int sides = std::max(8, static_cast<int>(std::ceil(2 * std::numbers::pi / step)));

  Mesh mesh;
  std::vector<std::vector<std::uint32_t>> rings;
  for (const auto& p : outline) {
    std::vector<std::uint32_t> ring;
    if (p[0] < 1e-12) {
      ring.push_back(addVertex(mesh, {0, 0, p[1]}));
    } else {
      for (int n = 0; n < sides; ++n) {
        const double t = 2 * std::numbers::pi * n / sides;
        ring.push_back(addVertex(mesh, {p[0] * std::cos(t), p[0] * std::sin(t), p[1]}));
      }
    }
    rings.push_back(std::move(ring));
  }

  for (std::size_t r = 0; r + 1 < rings.size(); ++r) {
    const auto &low = rings[r], &high = rings[r + 1];
    if (low.size() == 1 && high.size() == 1) continue;
    for (std::size_t n = 0; n < static_cast<std::size_t>(sides); ++n) {
      const std::size_t m = (n + 1) % static_cast<std::size_t>(sides);
      if (low.size() == 1) {
        mesh.triangles.push_back({low[0], high[m], high[n]});
      } else if (high.size() == 1) {
        mesh.triangles.push_back({low[n], low[m], high[0]});
      } else {
        mesh.triangles.push_back({low[n], low[m], high[m]});
        mesh.triangles.push_back({low[n], high[m], high[n]});
      }
    }
  }
  mesh.vertex_colors.assign(mesh.vertices.size(), color);
  return mesh;
}

}  // namespace

namespace internal {

Mesh prism(std::vector<Eigen::Vector2d> xz, double y0, double y1, Rgba8 color) {
  double twice_area = 0;
  for (std::size_t n = 0; n < xz.size(); ++n) {
    const auto &a = xz[n], &b = xz[(n + 1) % xz.size()];
    twice_area += a[0] * b[1] - a[1] * b[0];
  }
  // Counter-clockwise seen from +y towards -y with x to the left.
  if (twice_area < 0) std::reverse(xz.begin(), xz.end());

  Mesh mesh;
  const auto sides = static_cast<std::uint32_t>(xz.size());
  for (const double y : {y0, y1})
    for (const auto& p : xz) addVertex(mesh, {p[0], y, p[1]});

  for (std::uint32_t n = 1; n + 1 < sides; ++n) {
    mesh.triangles.push_back({0, n, n + 1});                      // y0: x cross z is -y, outwards
    mesh.triangles.push_back({sides, sides + n + 1, sides + n});  // y1
  }
  for (std::uint32_t n = 0; n < sides; ++n) {
    const std::uint32_t m = (n + 1) % sides;
    mesh.triangles.push_back({n, sides + n, sides + m});
    mesh.triangles.push_back({n, sides + m, m});
  }
  mesh.vertex_colors.assign(mesh.vertices.size(), color);
  return mesh;
}

Mesh revolvedMesh(const Tool& tool, double tolerance_mm) {
  Mesh mesh = revolve(*tool.cutting, tolerance_mm, kCuttingColor);
  for (const RevolvedProfile& outline : tool.body_outlines) append(mesh, revolve(outline, tolerance_mm, kSteelColor));
  return mesh;
}

}  // namespace internal

namespace {

Mesh coloredMesh(const Tool& tool) {
  Mesh mesh = *tool.mesh;
  mesh.face_colors.clear();
  mesh.vertex_colors.clear();
  for (const Vec3d& p : mesh.vertices)
    mesh.vertex_colors.push_back(p[2] < tool.cut_below_mm ? internal::kCuttingColor : internal::kSteelColor);
  return mesh;
}

}  // namespace

Mesh toolMesh(const Tool& tool, double tolerance_mm) {
  switch (tool.kind) {
    case ToolKind::kBur:
      return internal::revolvedMesh(tool, tolerance_mm);
    case ToolKind::kBlade:
      return tool.motion->mesh(tool, tolerance_mm);
    case ToolKind::kMesh:
      return coloredMesh(tool);
  }
  return {};
}

}  // namespace kerf
