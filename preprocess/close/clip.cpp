#include "preprocess/close/clip.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/clip.h>
#include <CGAL/Surface_mesh.h>

namespace kerf::internal {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
namespace PMP = CGAL::Polygon_mesh_processing;

tl::unexpected<Error> gaveUp(const std::string& found) {
  return fail({Error::Code::kGeometry, "", "fine region", found, "a closed surface free of self-intersections",
               "kerf check on the mesh; or another radius"});
}

}  // namespace

Expected<Mesh> clipToBox(const Mesh& mesh, const Box3& box) {
  const Box3 all = bounds(mesh);
  if (mesh.triangles.empty() || (all.min.array() > box.max.array()).any() || (all.max.array() < box.min.array()).any())
    return Mesh{};
  if (box.contains(all.min) && box.contains(all.max)) return Mesh{mesh.vertices, mesh.triangles, {}, {}};
  try {
    SurfaceMesh surface;
    for (const Vec3d& p : mesh.vertices) surface.add_vertex({p[0], p[1], p[2]});
    for (const Triangle& t : mesh.triangles)
      if (surface.add_face(SurfaceMesh::Vertex_index(t[0]), SurfaceMesh::Vertex_index(t[1]),
                           SurfaceMesh::Vertex_index(t[2])) == SurfaceMesh::null_face())
        return gaveUp("an edge with more than two faces");
    const Kernel::Iso_cuboid_3 cuboid({box.min[0], box.min[1], box.min[2]}, {box.max[0], box.max[1], box.max[2]});
    if (!PMP::clip(surface, cuboid, CGAL::parameters::clip_volume(true).throw_on_self_intersection(true)))
      return gaveUp("no 2-manifold result of clipping");
    surface.collect_garbage();
    Mesh out;
    for (const auto v : surface.vertices()) {
      const auto& p = surface.point(v);
      out.vertices.emplace_back(p.x(), p.y(), p.z());
    }
    for (const auto f : surface.faces()) {
      Triangle t{};
      std::size_t k = 0;
      for (const auto v : surface.vertices_around_face(surface.halfedge(f))) t[k++] = v.idx();
      out.triangles.push_back(t);
    }
    return out;
  } catch (const std::exception& e) {
    return gaveUp(e.what());
  }
}

}  // namespace kerf::internal
