#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/tool/tool.h"

namespace kerf {
namespace {

constexpr Rgba8 kSteel{176, 182, 190, 255}, kCutting{224, 196, 108, 255};

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

// A convex polygon in the plane (x, z), counter-clockwise seen from +y towards -y with x to the left, drawn out from
// y0 to y1.
Mesh prism(std::vector<Eigen::Vector2d> xz, double y0, double y1, Rgba8 color) {
  double twice_area = 0;
  for (std::size_t n = 0; n < xz.size(); ++n) {
    const auto &a = xz[n], &b = xz[(n + 1) % xz.size()];
    twice_area += a[0] * b[1] - a[1] * b[0];
  }
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

Mesh straightBlade(const Tool& tool) {
  const double half = 0.5 * tool.thickness_mm, set = tool.set_per_side_mm;
  const double height = std::min(tool.edge_depth_mm, 0.6 * tool.tooth_pitch_mm);
  Mesh mesh = prism({{height, 0},
                     {tool.blade_width_mm, 0},
                     {tool.blade_width_mm, tool.blade_length_mm},
                     {height, tool.blade_length_mm}},
                    -half, half, kSteel);
  const int teeth = static_cast<int>(std::floor(tool.blade_length_mm / tool.tooth_pitch_mm + 1e-9));
  for (int n = 0; n < teeth; ++n) {
    const double z = n * tool.tooth_pitch_mm;
    const bool left = n % 2 == 0;  // teeth lean to either side in turn
    append(mesh, prism({{height, z}, {0, z + 0.3 * tool.tooth_pitch_mm}, {height, z + tool.tooth_pitch_mm}},
                       left ? -half - set : -half, left ? half : half + set, kCutting));
  }
  return mesh;
}

// At rest, in the middle of its swing; teeth end on the arc about the pivot.
Mesh sagittalBlade(const Tool& tool) {
  const double half = 0.5 * tool.thickness_mm, set = tool.set_per_side_mm, L = tool.blade_length_mm;
  const double side = 0.5 * tool.blade_width_mm;
  const auto arc = [&](double x) { return L - std::sqrt(L * L - x * x); };
  const double base = arc(side) + std::min(tool.edge_depth_mm, 0.6 * tool.tooth_pitch_mm);
  Mesh mesh = prism({{-side, base}, {side, base}, {side, L}, {-side, L}}, -half, half, kSteel);
  const int teeth = std::max(1, static_cast<int>(std::floor(tool.blade_width_mm / tool.tooth_pitch_mm + 1e-9)));
  for (int n = 0; n < teeth; ++n) {
    const double left = side * (2.0 * n / teeth - 1), right = side * (2.0 * (n + 1) / teeth - 1);
    const double tip = 0.5 * (left + right);
    const bool leans = n % 2 == 0;
    append(mesh, prism({{left, base}, {tip, arc(tip)}, {right, base}}, leans ? -half - set : -half,
                       leans ? half : half + set, kCutting));
  }
  return mesh;
}

}  // namespace

Mesh toolMesh(const Tool& tool, double tolerance_mm) {
  if (tool.mesh) {
    Mesh mesh = *tool.mesh;
    mesh.face_colors.clear();
    mesh.vertex_colors.clear();
    for (const Vec3d& p : mesh.vertices) mesh.vertex_colors.push_back(p[2] < tool.cut_below_mm ? kCutting : kSteel);
    return mesh;
  }
  if (tool.cutting) {  // it revolves
    Mesh mesh = revolve(*tool.cutting, tolerance_mm, kCutting);
    for (const RevolvedProfile& outline : tool.body_outlines) append(mesh, revolve(outline, tolerance_mm, kSteel));
    return mesh;
  }
  return tool.motion == BladeMotion::kSagittal ? sagittalBlade(tool) : straightBlade(tool);
}

}  // namespace kerf
