#include "geometry/boolean/boolean.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/Euler_operations.h>
#include <CGAL/boost/graph/generators.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <optional>

#include "geometry/boolean/near_patch.h"
#include "geometry/mesh/exact_weld.h"
#include "geometry/mesh/self_intersection.h"
#include "geometry/mesh/solids.h"

namespace kerf {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
namespace PMP = CGAL::Polygon_mesh_processing;

// New vertices are made exactly and rounded. As a rule CGAL rounds the middle of an interval that holds them, which
// differs in its last digit by the order in which it comes upon them; and where two boxes touch, that order is the one
// in which two lists lie in memory. While this lives, the exact numbers of this thread are rounded themselves.
class RoundsExactly {
 public:
  RoundsExactly() : before_(Number::get_relative_precision_of_to_double()) {
    Number::set_relative_precision_of_to_double(1e-30);
  }
  ~RoundsExactly() { Number::set_relative_precision_of_to_double(before_); }
  RoundsExactly(const RoundsExactly&) = delete;
  RoundsExactly& operator=(const RoundsExactly&) = delete;

 private:
  using Number = CGAL::Exact_predicates_exact_constructions_kernel::FT;
  double before_;
};

// Origins ride along as a plain array indexed by CGAL's face numbers.
struct Origins {
  std::vector<std::uint32_t> face;
  static std::uint32_t get(const std::vector<std::uint32_t>& of, std::size_t i) {
    return i < of.size() ? of[i] : kNoSource;
  }
  static void set(std::vector<std::uint32_t>& of, std::size_t i, std::uint32_t value) {
    if (of.size() <= i) of.resize(i + 1, kNoSource);
    of[i] = value;
  }
};

// CGAL copies visitors; the state they share lives outside.
struct OriginVisitor : PMP::Corefinement::Default_visitor<SurfaceMesh> {
  struct State {
    const SurfaceMesh* minuend = nullptr;
    Origins minuend_origin, result_origin;
    std::vector<char> other_is_cut;  // per triangle of the other mesh
    std::uint32_t split_face = kNoSource;
  };
  State* state;
  explicit OriginVisitor(State* s) : state(s) {}

  void before_subface_creations(face_descriptor f, SurfaceMesh& tm) {
    if (&tm == state->minuend)
      state->split_face = Origins::get(state->minuend_origin.face, f);
    else if (std::size_t{f} < state->other_is_cut.size())
      state->other_is_cut[f] = 1;
  }
  void after_subface_created(face_descriptor f, SurfaceMesh& tm) {
    if (&tm == state->minuend) Origins::set(state->minuend_origin.face, f, state->split_face);
  }
  void after_face_copy(face_descriptor from, const SurfaceMesh& source, face_descriptor to, SurfaceMesh&) {
    Origins::set(state->result_origin.face, to,
                 &source == state->minuend ? Origins::get(state->minuend_origin.face, from) : kNoSource);
  }
};

Expected<void> fill(const Mesh& mesh, const char* name, SurfaceMesh& out) {
  out.reserve(static_cast<SurfaceMesh::size_type>(mesh.vertices.size()),
              static_cast<SurfaceMesh::size_type>(mesh.triangles.size() * 3 / 2),
              static_cast<SurfaceMesh::size_type>(mesh.triangles.size()));
  for (const Vec3d& p : mesh.vertices) out.add_vertex({p[0], p[1], p[2]});
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& f = mesh.triangles[t];
    if (out.add_face(SurfaceMesh::Vertex_index(f[0]), SurfaceMesh::Vertex_index(f[1]),
                     SurfaceMesh::Vertex_index(f[2])) == SurfaceMesh::null_face())
      return fail({.code = Error::Code::kGeometry,
                   .place = name + std::string(" triangle ") + std::to_string(t),
                   .found = "an edge with more than two faces, or a flipped face",
                   .expected = "a 2-manifold mesh"});
  }
  return {};
}

enum class Operation { kDifference, kUnion, kIntersection };

// Which vertex of the result is which of the minuend.
struct VertexOrigins {
  std::vector<std::uint32_t> source;    // per vertex of the result, by CGAL's number: of the minuend, or kNoSource
  std::vector<std::uint32_t> survivor;  // per vertex of the minuend: CGAL's number in the result, or kNoSource
};

// Surviving minuend vertices are known by their coordinates: corefinement never moves one, and never makes a new
// point where the minuend, free of duplicates, already has one.
VertexOrigins originsOfVertices(const Mesh& minuend, const SurfaceMesh& out) {
  internal::ExactWelder positions(minuend.vertices.size());
  std::vector<std::uint32_t> first;  // per position: the first vertex there
  for (std::uint32_t v = 0; v < minuend.vertices.size(); ++v)
    if (positions.add(minuend.vertices[v]) == first.size()) first.push_back(v);

  VertexOrigins origins;
  origins.source.assign(out.number_of_vertices() + out.number_of_removed_vertices(), kNoSource);
  origins.survivor.assign(minuend.vertices.size(), kNoSource);
  for (const auto v : out.vertices()) {
    const auto& p = out.point(v);
    const std::uint32_t position = positions.find({p.x(), p.y(), p.z()});
    if (position == internal::ExactWelder::kNotThere || origins.survivor[first[position]] != kNoSource) continue;
    origins.source[v] = first[position];
    origins.survivor[first[position]] = v;
  }
  return origins;
}

// Puts the vertices into the result: the survivors in the minuend's order, then the new ones by their coordinates.
// @return per vertex by CGAL's number: its index in the result.
std::vector<std::uint32_t> copyVertices(const SurfaceMesh& out, const VertexOrigins& origins, Difference& result) {
  std::vector<std::uint32_t> index(origins.source.size(), kNoSource);
  const auto take = [&](SurfaceMesh::Vertex_index v) {
    const auto& p = out.point(v);
    index[v] = static_cast<std::uint32_t>(result.mesh.vertices.size());
    result.mesh.vertices.emplace_back(p.x(), p.y(), p.z());
    result.from_vertex.push_back(origins.source[v]);
  };
  for (const std::uint32_t v : origins.survivor)
    if (v != kNoSource) take(SurfaceMesh::Vertex_index(v));

  // CGAL numbers new vertices in the order of its search, and for touching boxes that depends on memory addresses. So
  // this sorts them by coordinates.
  std::vector<SurfaceMesh::Vertex_index> made;
  for (const auto v : out.vertices())
    if (origins.source[v] == kNoSource) made.push_back(v);
  std::stable_sort(made.begin(), made.end(), [&](const auto x, const auto y) { return out.point(x) < out.point(y); });
  for (const auto v : made) take(v);
  return index;
}

// Puts the faces into the result: the untouched ones in the minuend's order, then the rest by their corners.
void copyFaces(const SurfaceMesh& out, const Origins& origins, const std::vector<std::uint32_t>& index,
               const Mesh& minuend, Difference& result) {
  struct Face {
    std::uint32_t source;
    Triangle corners;
  };
  // Number of triangles of each source, then the place of the first of each; the last source is none.
  const std::size_t none = minuend.triangles.size();
  const auto placeOf = [none](std::uint32_t source) { return source == kNoSource ? none : std::size_t{source}; };
  std::vector<std::uint32_t> begin(none + 2);
  for (const auto f : out.faces()) ++begin[placeOf(Origins::get(origins.face, f)) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());

  std::vector<Face> faces(out.number_of_faces());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (const auto f : out.faces()) {
    Face face{Origins::get(origins.face, f), {}};
    std::size_t k = 0;
    for (const auto v : CGAL::vertices_around_face(out.halfedge(f), out)) face.corners[k++] = index[v];
    // Begin with the corner of the lowest index: CGAL's choice of first corner depends on its history.
    std::rotate(face.corners.begin(), std::min_element(face.corners.begin(), face.corners.end()), face.corners.end());
    faces[next[placeOf(face.source)]++] = face;
  }
  for (std::size_t source = 0; source + 1 < begin.size(); ++source)
    if (begin[source + 1] - begin[source] > 1)
      std::sort(faces.begin() + begin[source], faces.begin() + begin[source + 1],
                [](const Face& x, const Face& y) { return x.corners < y.corners; });

  for (Face& face : faces) {
    if (face.source != kNoSource) {  // an uncut triangle keeps the source's first corner
      const Triangle& source = minuend.triangles[face.source];
      for (int turn = 0; turn < 3 && result.from_vertex[face.corners[0]] != source[0]; ++turn)
        std::rotate(face.corners.begin(), face.corners.begin() + 1, face.corners.end());
    }
    result.mesh.triangles.push_back(face.corners);
    result.from_triangle.push_back(face.source);
  }
}

template <class Parameters>
bool compute(Operation operation, SurfaceMesh& a, SurfaceMesh& b, SurfaceMesh& out, const Parameters& visited) {
  const auto plain = CGAL::parameters::all_default();
  switch (operation) {
    case Operation::kUnion:
      return PMP::corefine_and_compute_union(a, b, out, visited, plain);
    case Operation::kIntersection:
      return PMP::corefine_and_compute_intersection(a, b, out, visited, plain);
    case Operation::kDifference:
      break;
  }
  return PMP::corefine_and_compute_difference(a, b, out, visited, plain);
}

struct Combined {
  Difference result;
  std::vector<char> other_is_cut;  // per triangle of the other mesh: the minuend's surface passes through it
};

// @param refuses_crossings  of one of the surfaces with itself, where the other one passes.
Expected<Combined> combineWhole(const Mesh& minuend, const Mesh& other, Operation operation, bool refuses_crossings) {
  const bool is_union = operation == Operation::kUnion;
  const char* const name = is_union                                ? "exact union"
                           : operation == Operation::kIntersection ? "exact intersection"
                                                                   : "exact difference";
  const auto refuse = [name](std::string found, std::string expected, std::string hint) {
    return fail({.code = Error::Code::kGeometry,
                 .place = name,
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .hint = std::move(hint)});
  };

  try {
    const RoundsExactly rounds_exactly;
    auto a = std::make_unique<SurfaceMesh>(), b = std::make_unique<SurfaceMesh>(),
         out = std::make_unique<SurfaceMesh>();
    KERF_CHECK(fill(minuend, "source", *a));
    KERF_CHECK(fill(other, is_union ? "added solid" : "removed solid", *b));

    OriginVisitor::State state;
    state.minuend = a.get();
    state.minuend_origin.face.resize(minuend.triangles.size());
    std::iota(state.minuend_origin.face.begin(), state.minuend_origin.face.end(), 0u);
    state.other_is_cut.resize(other.triangles.size());
    const auto visited = CGAL::parameters::visitor(OriginVisitor(&state)).throw_on_self_intersection(refuses_crossings);
    const bool ok = compute(operation, *a, *b, *out, visited);
    if (!ok)
      return refuse("a result that is not 2-manifold", "surfaces that cross each other transversally",
                    "bake with another --voxel and cut again");

    Combined combined;
    Difference& result = combined.result;
    const VertexOrigins origins = originsOfVertices(minuend, *out);
    const std::vector<std::uint32_t> index = copyVertices(*out, origins, result);
    copyFaces(*out, state.result_origin, index, minuend, result);
    result.triangles_taken = minuend.triangles.size();
    combined.other_is_cut = std::move(state.other_is_cut);
    return combined;
  } catch (const PMP::Corefinement::Self_intersection_exception&) {
    return refuse(is_union ? "a surface that crosses itself where material was added"
                           : "a surface that crosses itself where the cut passes",
                  "a source free of self-intersections",
                  is_union ? "bake with another --voxel, or cut and add in runs of their own"
                           : "kerf check on the source; bake with --close wrap");
  } catch (const std::exception& e) {
    return refuse(std::string("the boolean gave up: ") + e.what(), "", "bake with another --voxel and cut again");
  }
}

// ---- Near the other mesh alone

struct Shell {
  std::vector<std::uint32_t> vertices;
  bool is_cut = false;  // the minuend's surface passes through it, or touches it
};

std::vector<Shell> shellsOf(const Mesh& other, const std::vector<char>& is_cut) {
  const Pieces pieces = edgeConnectedPieces(other);
  std::vector<Shell> out(pieces.count);
  std::vector<char> is_seen(other.vertices.size(), 0);
  for (std::size_t t = 0; t < is_cut.size(); ++t) {
    Shell& shell = out[pieces.label[t]];
    shell.is_cut |= is_cut[t] != 0;
    for (const std::uint32_t v : other.triangles[t]) {
      if (!is_seen[v]) shell.vertices.push_back(v);
      is_seen[v] = 1;
    }
  }
  return out;
}

// Checks uncut shells, and shells that only touch. Whether such a shell belongs to the result depends on its place
// inside or outside the minuend. The patch alone does not show this, because its caps are no part of the minuend.
bool isRightAboutShells(const Mesh& minuend, const Mesh& other, Operation operation, const Combined& near) {
  constexpr std::size_t kMostShells = 16;
  internal::ExactWelder made(near.result.mesh.vertices.size());
  for (std::size_t v = 0; v < near.result.from_vertex.size(); ++v)
    if (near.result.from_vertex[v] == kNoSource) made.add(near.result.mesh.vertices[v]);

  const bool inside_counts = operation == Operation::kDifference;
  std::size_t looked_at = 0;
  for (const Shell& shell : shellsOf(other, near.other_is_cut)) {
    const auto is_there = [&](std::uint32_t v) {
      return made.find(other.vertices[v]) != internal::ExactWelder::kNotThere;
    };
    const auto& all = shell.vertices;
    const auto count = static_cast<std::size_t>(std::count_if(all.begin(), all.end(), is_there));
    if (count != 0 && count != all.size()) {
      if (!shell.is_cut) return false;
      continue;  // the crossing decides for cut shells
    }
    if (++looked_at > kMostShells) return false;
    for (const std::uint32_t v : {all.front(), all[all.size() / 2], all.back()})
      if ((isInside(minuend, other.vertices[v]) == inside_counts) != (count > 0)) return false;
  }
  return true;
}

bool crossesItself(const Mesh& mesh, std::size_t triangles) {
  return !selfIntersections(mesh.vertices, {mesh.triangles.data(), triangles}, 1).empty();
}

// Empty if the whole minuend is needed; the whole boolean also reports errors.
std::optional<Difference> combineNear(const Mesh& minuend, const Mesh& other, Operation operation) {
  const std::optional<internal::NearPatch> patch = internal::nearPatch(minuend, other);
  if (!patch) return {};
  // Caps may cross anything except the other mesh. Neither the minuend nor the other mesh may cross itself.
  if (crossesItself(patch->mesh, patch->source_triangles) || crossesItself(other, other.triangles.size())) return {};
  const auto near = combineWhole(patch->mesh, other, operation, false);
  if (!near || !isRightAboutShells(minuend, other, operation, *near)) return {};
  std::optional<Difference> out = internal::sewnToRest(minuend, *patch, near->result);
  if (out) out->triangles_taken = patch->source_triangles;
  return out;
}

Expected<Difference> combine(const Mesh& minuend, const Mesh& other, Operation operation, Reach reach) {
  if (reach == Reach::kNear)
    if (auto near = combineNear(minuend, other, operation)) return *std::move(near);
  KERF_TRY(whole, combineWhole(minuend, other, operation, true));
  return std::move(whole.result);
}

tl::unexpected<Error> clippingGaveUp(const std::string& found) {
  return fail({.code = Error::Code::kGeometry,
               .place = "clipping to a box",
               .found = found,
               .expected = "a closed surface free of self-intersections",
               .hint = "kerf check on the mesh; or another box"});
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

// The box, as CGAL's clip() builds it from an Iso_cuboid_3.
SurfaceMesh meshOfBox(const Box3& box) {
  const Kernel::Iso_cuboid_3 cuboid({box.min[0], box.min[1], box.min[2]}, {box.max[0], box.max[1], box.max[2]});
  SurfaceMesh mesh;
  CGAL::make_hexahedron(cuboid[0], cuboid[1], cuboid[2], cuboid[3], cuboid[4], cuboid[5], cuboid[6], cuboid[7], mesh);
  const std::vector<SurfaceMesh::Face_index> quads(mesh.faces().begin(), mesh.faces().end());
  for (const auto face : quads) splitQuad(mesh, face);
  return mesh;
}

}  // namespace

Expected<Difference> subtract(const Mesh& minuend, const Mesh& subtrahend, Reach reach) {
  return combine(minuend, subtrahend, Operation::kDifference, reach);
}

Expected<Difference> unite(const Mesh& minuend, const Mesh& added, Reach reach) {
  return combine(minuend, added, Operation::kUnion, reach);
}

Expected<Difference> intersect(const Mesh& minuend, const Mesh& other) {
  return combine(minuend, other, Operation::kIntersection, Reach::kWhole);
}

// PMP::clip() itself is not called: it compiles three ways to clip, of which a closed mesh takes only the one below.
// With the visitor of combine() that one is compiled already: each other one takes a minute.
Expected<Mesh> clipToBox(const Mesh& mesh, const Box3& box) {
  const Box3 all = bounds(mesh);
  if (mesh.triangles.empty() || (all.min.array() > box.max.array()).any() || (all.max.array() < box.min.array()).any())
    return Mesh{};
  if (box.contains(all.min) && box.contains(all.max)) return Mesh{mesh.vertices, mesh.triangles, {}, {}};
  try {
    const RoundsExactly rounds_exactly;
    SurfaceMesh surface;
    KERF_CHECK(fill(mesh, "mesh", surface));
    if (!CGAL::is_closed(surface)) return clippingGaveUp("an open surface");

    SurfaceMesh clipper = meshOfBox(box);
    OriginVisitor::State unused;
    const auto visited = CGAL::parameters::visitor(OriginVisitor(&unused)).throw_on_self_intersection(true);
    if (!PMP::corefine_and_compute_intersection(surface, clipper, surface, visited, CGAL::parameters::all_default()))
      return clippingGaveUp("no 2-manifold result of clipping");
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
    return clippingGaveUp(e.what());
  }
}

}  // namespace kerf
