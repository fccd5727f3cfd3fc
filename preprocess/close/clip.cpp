#include "preprocess/close/clip.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/Euler_operations.h>
#include <CGAL/boost/graph/generators.h>

namespace kerf::internal {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
namespace PMP = CGAL::Polygon_mesh_processing;

tl::unexpected<Error> gaveUp(const std::string& found) {
  return fail({.code = Error::Code::kGeometry,
               .place = "fine region",
               .found = found,
               .expected = "a closed surface free of self-intersections",
               .hint = "kerf check on the mesh; or another radius"});
}

// Cuts a face of four corners in two, along the diagonal CGAL's triangulate_faces() takes: on it depend bits.
void splitQuad(SurfaceMesh& mesh, SurfaceMesh::Face_index face) {
  const auto h0 = mesh.halfedge(face), h1 = mesh.next(h0), h2 = mesh.next(h1), h3 = mesh.next(h2);
  const auto &p0 = mesh.point(mesh.target(h0)), &p1 = mesh.point(mesh.target(h1)), &p2 = mesh.point(mesh.target(h2)),
             &p3 = mesh.point(mesh.target(h3));
  const double p1p3 = CGAL::cross_product(p2 - p1, p3 - p2) * CGAL::cross_product(p0 - p3, p1 - p0);
  const double p0p2 = CGAL::cross_product(p1 - p0, p1 - p2) * CGAL::cross_product(p3 - p2, p3 - p0);
  if (p0p2 > p1p3)
    CGAL::Euler::split_face(h0, h2, mesh);
  else
    CGAL::Euler::split_face(h1, h3, mesh);
}

// The box as CGAL's clip() would make it of an Iso_cuboid_3.
SurfaceMesh meshOfBox(const Box3& box) {
  const Kernel::Iso_cuboid_3 cuboid({box.min[0], box.min[1], box.min[2]}, {box.max[0], box.max[1], box.max[2]});
  SurfaceMesh mesh;
  CGAL::make_hexahedron(cuboid[0], cuboid[1], cuboid[2], cuboid[3], cuboid[4], cuboid[5], cuboid[6], cuboid[7], mesh);
  const std::vector<SurfaceMesh::Face_index> quads(mesh.faces().begin(), mesh.faces().end());
  for (const auto face : quads) splitQuad(mesh, face);
  return mesh;
}

}  // namespace

// PMP::clip() itself is not called: it compiles three ways to clip, of which a closed mesh takes only the one below,
// and all that triangulate_faces() may need. This takes a fifth less time to compile and a third less memory.
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
    if (!CGAL::is_closed(surface)) return gaveUp("an open surface");

    SurfaceMesh clipper = meshOfBox(box);
    if (!PMP::corefine_and_compute_intersection(surface, clipper, surface,
                                                CGAL::parameters::throw_on_self_intersection(true)))
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
