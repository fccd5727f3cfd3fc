#include "preprocess/close/hole.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>

#include "geometry/mesh/float32_cleanup.h"

namespace kerf::internal {
namespace {

using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
/// Edges of a loop; the exhaustive search behind the Delaunay one is cubic in their number.
constexpr std::size_t kCubicLimit = 300;

std::vector<Triangle> triangulate(const Chain& chain, const Loop& loop) {
  std::vector<Point> line;
  for (const std::uint32_t v : loop)
    line.push_back({chain.mesh.vertices[v].x(), chain.mesh.vertices[v].y(), chain.mesh.vertices[v].z()});
  struct Face {
    int a, b, c;
    Face(int a_, int b_, int c_) : a(a_), b(b_), c(c_) {}
  };
  std::vector<Face> faces;
  try {
    CGAL::Polygon_mesh_processing::triangulate_hole_polyline(
        line, std::back_inserter(faces),
        CGAL::parameters::use_delaunay_triangulation(true).do_not_use_cubic_algorithm(loop.size() > kCubicLimit));
  } catch (const std::exception&) {
    return {};
  }

  std::vector<Triangle> out;
  bool forward = false;
  const auto n = static_cast<int>(loop.size());
  for (const Face& f : faces) {
    if (f.a < 0 || f.b < 0 || f.c < 0 || f.a >= n || f.b >= n || f.c >= n) return {};
    out.push_back({loop[static_cast<std::size_t>(f.a)], loop[static_cast<std::size_t>(f.b)],
                   loop[static_cast<std::size_t>(f.c)]});
    const auto first = [](int p, int q) { return p == 0 && q == 1; };
    forward = forward || first(f.a, f.b) || first(f.b, f.c) || first(f.c, f.a);
  }
  if (!forward)
    for (Triangle& t : out) std::swap(t[1], t[2]);

  // Check the result: the boundary must be the loop.
  std::vector<Triangle> closed = out;
  for (std::size_t i = 1; i + 1 < loop.size(); ++i) closed.push_back({loop[0], loop[i + 1], loop[i]});
  for (const EdgeCount& e : countEdges(closed))
    if (e.forth != e.back) return {};
  return out;
}

}  // namespace

bool fillHole(Chain& chain, const Loop& loop) {
  if (loop.size() == 3) {
    chain.addTriangle(loop[0], loop[1], loop[2]);
    return true;
  }
  const std::vector<Triangle> triangles = triangulate(chain, loop);
  for (const Triangle& t : triangles) chain.addTriangle(t[0], t[1], t[2]);
  if (!triangles.empty()) return true;
  fanHole(chain, loop);
  return false;
}

void fanHole(Chain& chain, const Loop& loop) {
  Vec3d mean = Vec3d::Zero();
  for (const std::uint32_t v : loop) mean += chain.mesh.vertices[v] / static_cast<double>(loop.size());
  const std::uint32_t c = chain.addVertex(roundedToFloat(mean));
  for (std::size_t i = 0; i < loop.size(); ++i) chain.addTriangle(loop[i], loop[(i + 1) % loop.size()], c);
}

}  // namespace kerf::internal
