#include "preprocess/print/surface_map.h"

#include <algorithm>
#include <cassert>
#include <limits>

#include "geometry/mesh/map_colour.h"

namespace kerf {
namespace {

// Share of a triangle where a linear function with these corner values is positive.
double positiveShare(std::array<double, 3> at) {
  std::sort(at.begin(), at.end());
  if (at[0] >= 0) return at[2] > 0 ? 1 : 0;
  if (at[2] <= 0) return 0;
  if (at[1] <= 0) return at[2] / (at[2] - at[0]) * at[2] / (at[2] - at[1]);
  return 1 - at[0] / (at[0] - at[2]) * at[0] / (at[0] - at[1]);
}

}  // namespace

Rgba8 MapRange::colour(double mm) const { return mapColour((mm - light_mm) / (dark_mm - light_mm)); }

std::vector<LegendRow> legendTable(const MapRange& range, int rows) {
  assert(rows >= 2);
  std::vector<LegendRow> out;
  for (int n = 0; n < rows; ++n) {
    const double mm = range.light_mm + (range.dark_mm - range.light_mm) * n / (rows - 1);
    out.push_back({mm, range.colour(mm)});
  }
  return out;
}

std::vector<Rgba8> mapColours(std::span<const double> values_mm, const MapRange& range) {
  std::vector<Rgba8> out;
  out.reserve(values_mm.size());
  for (const double mm : values_mm) out.push_back(range.colour(mm));
  return out;
}

SurfaceNumbers surfaceNumbers(const Mesh& mesh, std::span<const double> values_mm, double limit_mm) {
  assert(values_mm.size() == mesh.vertices.size());
  if (mesh.triangles.empty()) return {};
  SurfaceNumbers out;
  out.least_mm = std::numeric_limits<double>::infinity();
  out.most_mm = -out.least_mm;
  std::uint32_t least = 0, most = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<double, 3> over;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh.triangles[t][k];
      const double mm = values_mm[v];
      over[k] = mm - limit_mm;
      if (mm < out.least_mm || (mm == out.least_mm && v < least)) out.least_mm = mm, least = v;
      if (mm > out.most_mm || (mm == out.most_mm && v < most)) out.most_mm = mm, most = v;
    }
    const double area = doubleAreaVector(mesh, t).norm() / 2;
    out.over_mm2 += area * positiveShare(over);
    for (double& x : over) x = -x;
    out.under_mm2 += area * positiveShare(over);
  }
  out.least_at = mesh.vertices[least];
  out.most_at = mesh.vertices[most];
  return out;
}

}  // namespace kerf
