#include "preprocess/close/guard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "preprocess/close/openness.h"

namespace kerf::internal {
namespace {

// Corners at the same place are one: STL has no others.
std::vector<Triangle> weldedTriangles(const Mesh& mesh, std::size_t& used) {
  std::vector<std::uint32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto place = [&](std::uint32_t v) {
    const Vec3d& p = mesh.vertices[v];
    return std::array{p.x(), p.y(), p.z()};
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
  std::vector<std::uint32_t> first(mesh.vertices.size());
  for (std::size_t n = 0; n < order.size(); ++n)
    first[order[n]] = n > 0 && place(order[n]) == place(order[n - 1]) ? first[order[n - 1]] : order[n];

  std::vector<char> is_used(mesh.vertices.size(), 0);
  std::vector<Triangle> out;
  out.reserve(mesh.triangles.size());
  for (const Triangle& f : mesh.triangles) {
    const Triangle welded{first[f[0]], first[f[1]], first[f[2]]};
    for (const std::uint32_t v : welded) is_used[v] = 1;
    if (welded[0] != welded[1] && welded[1] != welded[2] && welded[2] != welded[0]) out.push_back(welded);
  }
  used = static_cast<std::size_t>(std::count(is_used.begin(), is_used.end(), 1));
  return out;
}

}  // namespace

std::vector<std::string> guardWarnings(const Mesh& imported_mm, const Mesh& solid, const CloseReport& report) {
  std::vector<std::string> out;
  std::size_t used = 0;
  const std::vector<Triangle> triangles = weldedTriangles(imported_mm, used);
  Box3 box;
  for (const Triangle& f : triangles)
    for (const std::uint32_t v : f) box.add(imported_mm.vertices[v]);

  const double before = std::abs(signedVolume(imported_mm)), after = std::abs(signedVolume(solid));
  const bool is_hardly_open =
      !triangles.empty() && openLength(imported_mm, triangles) <= kHardlyOpen * box.size().norm();
  const double ratio = before > 0 ? after / before : 1;
  if (is_hardly_open && (ratio > kMostGrowth || ratio < kLeastShrink))
    out.push_back(fmt::format(
        "THE SOLID IS NOT WHAT WAS SCANNED: it has {:.4g} mm3, {:.3g} times the {:.4g} mm3 that the mesh encloses. "
        "Look at it before anything is cut; try --close holes, a smaller --wrap-alpha, or mend the mesh in "
        "another program",
        after, ratio, before));

  const double lost = used > 0 ? static_cast<double>(report.vertices_lost) / static_cast<double>(used) : 0;
  if (report.exact && lost > kMostLost)
    out.push_back(fmt::format(
        "MUCH OF THE SCAN IS LOST: {} of its {} vertices ({:.0f} %) are not in the solid. Look at it before "
        "anything is cut; try --close holes, --close wrap, or mend the mesh in another program",
        report.vertices_lost, used, 100 * lost));
  return out;
}

}  // namespace kerf::internal
