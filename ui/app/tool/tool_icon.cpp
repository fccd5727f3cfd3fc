#include "ui/app/tool/tool_icon.h"

#include <algorithm>

#include "geometry/tool/tool.h"

namespace kerf {
namespace {

constexpr double kMargin = 0.18;      // of the picture, around the cutting part
constexpr double kTolerance = 0.008;  // of the cutting part
constexpr double kOutside = 0.2;      // of the picture: drops parts farther outside
constexpr double kIconNear = 0.02;    // of the picture: distance that takes the colour of the cutting part

struct Sorted {
  double depth = 0;
  IconTriangle triangle;
};

}  // namespace

std::vector<IconTriangle> toolIcon(const Tool& tool) {
  const Box3 cut = tool.cut->bounds();
  const Vec3d center = cut.center(), size = cut.size();
  int thin = 0;  // the viewing axis: the wide side faces the viewer
  for (int axis = 1; axis < 3; ++axis)
    if (size[axis] < size[thin]) thin = axis;
  const int up = thin == 2 ? 1 : 2, across = 3 - thin - up;
  const double side = std::max({size[across], size[up], 1e-3}) * (1 + 2 * kMargin);
  const Vec3d away = Vec3d::Unit(thin), light = (away + 0.5 * Vec3d::Unit(up)).normalized();

  const Mesh mesh = toolMesh(tool, kTolerance * side);
  const auto isInside = [](double x) { return x > -kOutside && x < 1 + kOutside; };
  std::vector<Sorted> sorted;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3d normal = doubleAreaVector(mesh, t);
    if (normal.dot(away) <= 0) continue;

    Sorted s;
    bool is_seen = false;
    for (int k = 0; k < 3; ++k) {
      const Vec3d p = mesh.corner(t, k);
      const double x = 0.5 + (p[across] - center[across]) / side, y = 0.5 - (p[up] - center[up]) / side;
      s.triangle.corners[static_cast<std::size_t>(k)] = {static_cast<float>(x), static_cast<float>(y)};
      s.depth += p.dot(away) / 3;
      is_seen |= isInside(x) && isInside(y);
    }
    if (!is_seen) continue;

    const Vec3d middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
    s.triangle.is_cutting = tool.cut->distance(middle) < kIconNear * side;
    s.triangle.shade = static_cast<float>(0.35 + 0.65 * normal.normalized().dot(light));
    sorted.push_back(s);
  }
  std::sort(sorted.begin(), sorted.end(), [](const Sorted& a, const Sorted& b) { return a.depth < b.depth; });

  std::vector<IconTriangle> out;
  for (const Sorted& s : sorted) out.push_back(s.triangle);
  return out;
}

}  // namespace kerf
