#include "preprocess/close/arrangement.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <boost/variant/get.hpp>
#include <boost/variant/variant.hpp>
#include <map>
#include <variant>

#include "preprocess/close/poll.h"

namespace kerf::internal {
namespace {

using PlaneKernel = CGAL::Exact_predicates_exact_constructions_kernel;
using PlanePoint = PlaneKernel::Point_3;
struct VertexId {
  std::uint32_t v = kAdded;
};
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<VertexId, PlaneKernel>;
using FaceBase = CGAL::Constrained_triangulation_face_base_2<PlaneKernel>;
using PlaneCdt =
    CGAL::Constrained_Delaunay_triangulation_2<PlaneKernel, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>,
                                               CGAL::Exact_intersections_tag>;
using Item = std::array<std::uint32_t, 2>;  ///< a segment between two points, or one point twice

/// Null if the intersection is not a Part. CGAL 5 has variants of Boost, CGAL 6 of the standard library.
template <class Part, class... Parts>
const Part* partOf(const boost::variant<Parts...>& intersection) {
  return boost::get<Part>(&intersection);
}
template <class Part, class... Parts>
const Part* partOf(const std::variant<Parts...>& intersection) {
  return std::get_if<Part>(&intersection);
}

class Arranger {
 public:
  Arranger(const Mesh& mesh, Poll& poll) : mesh_(mesh), poll_(poll) { out_.points = mesh.vertices; }

  /// Not to be used if the poll has stopped.
  Arrangement run(const std::vector<std::array<std::uint32_t, 2>>& pairs) {
    const std::size_t n = mesh_.triangles.size();
    items_.resize(n);

    // The intersections of all pairs.
    std::vector<char> touched(n, 0), flat(n, 0);
    for (const auto& [i, j] : pairs)
      if (i == j) flat[i] = 1;
    for (const auto& [i, j] : pairs)
      for (const std::uint32_t t : {i, j})
        for (const std::uint32_t v : mesh_.triangles[t]) known_.try_emplace(exact(v), v);
    for (const auto& [i, j] : pairs) {
      if (i == j || (flat[i] && flat[j])) continue;
      if (poll_.stop()) return {};
      if (flat[i]) {
        meetFlat(i, j);
      } else if (flat[j]) {
        meetFlat(j, i);
      } else {
        meet(i, j);
      }
      touched[i] = touched[j] = 1;
    }

    // The pieces of the cut triangles.
    std::vector<std::pair<Triangle, std::uint32_t>> pieces;
    for (std::uint32_t t = 0; t < n; ++t) {
      if (flat[t]) continue;
      if (touched[t]) {
        if (poll_.stop()) return {};
        subdivide(t, pieces);
      } else {
        pieces.push_back({mesh_.triangles[t], t});
      }
    }
    merge(pieces);
    return std::move(out_);
  }

 private:
  PlanePoint exact(std::uint32_t v) const {
    return {mesh_.vertices[v].x(), mesh_.vertices[v].y(), mesh_.vertices[v].z()};
  }
  PlaneKernel::Triangle_3 triangle(std::uint32_t t) const {
    const Triangle& f = mesh_.triangles[t];
    return {exact(f[0]), exact(f[1]), exact(f[2])};
  }
  std::uint32_t id(const PlanePoint& p) {
    const auto [it, fresh] = known_.try_emplace(p, static_cast<std::uint32_t>(out_.points.size()));
    if (fresh) {
      CGAL::exact(it->first);  // drops the construction history: shorter trees, faster comparisons
      out_.points.push_back({CGAL::to_double(p.x()), CGAL::to_double(p.y()), CGAL::to_double(p.z())});
      new_points_.push_back(p);
    }
    return it->second;
  }
  PlanePoint point(std::uint32_t v) const {
    return v < mesh_.vertices.size() ? exact(v) : new_points_[v - mesh_.vertices.size()];
  }

  void add(std::uint32_t i, std::uint32_t j, std::uint32_t a, std::uint32_t b) {
    for (const std::uint32_t t : {i, j}) items_[t].push_back({std::min(a, b), std::max(a, b)});
  }

  void meet(std::uint32_t i, std::uint32_t j) {
    const auto result = CGAL::intersection(triangle(i), triangle(j));
    if (!result) return;
    if (const auto* p = partOf<PlanePoint>(*result)) {
      const std::uint32_t a = id(*p);
      add(i, j, a, a);
    } else if (const auto* s = partOf<PlaneKernel::Segment_3>(*result)) {
      const std::uint32_t a = id(s->source()), b = id(s->target());
      add(i, j, a, b);
    } else {
      std::vector<PlanePoint> polygon;
      if (const auto* f = partOf<PlaneKernel::Triangle_3>(*result))
        polygon = {f->vertex(0), f->vertex(1), f->vertex(2)};
      else
        polygon = *partOf<std::vector<PlanePoint>>(*result);
      std::vector<std::uint32_t> ids;
      for (const PlanePoint& q : polygon) ids.push_back(id(q));
      for (std::size_t k = 0; k < ids.size(); ++k) add(i, j, ids[k], ids[(k + 1) % ids.size()]);
    }
  }

  void meetFlat(std::uint32_t flat, std::uint32_t proper) {
    const PlaneKernel::Triangle_3 face = triangle(proper);
    const Triangle& f = mesh_.triangles[flat];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = f[k], b = f[(k + 1) % 3];
      if (a == b) continue;
      const auto result = CGAL::intersection(PlaneKernel::Segment_3(exact(a), exact(b)), face);
      if (!result) continue;
      if (const auto* p = partOf<PlanePoint>(*result)) {
        const std::uint32_t v = id(*p);
        items_[proper].push_back({v, v});
      } else if (const auto* s = partOf<PlaneKernel::Segment_3>(*result)) {
        const std::uint32_t p1 = id(s->source()), p2 = id(s->target());
        items_[proper].push_back({std::min(p1, p2), std::max(p1, p2)});
      }
    }
  }

  void subdivide(std::uint32_t t, std::vector<std::pair<Triangle, std::uint32_t>>& pieces) {
    auto& items = items_[t];
    std::sort(items.begin(), items.end());
    items.erase(std::unique(items.begin(), items.end()), items.end());

    // The plane to triangulate in: the coordinates other than `axis`.
    const Triangle& f = mesh_.triangles[t];
    const Vec3d n = doubleAreaVector(mesh_, t);
    int axis = 0;
    n.cwiseAbs().maxCoeff(&axis);
    const PlaneKernel::Plane_3 plane(exact(f[0]), exact(f[1]), exact(f[2]));
    const std::array<PlaneKernel::FT, 3> normal{plane.a(), plane.b(), plane.c()};
    // The largest component of the double normal may, for a needle, be zero in truth.
    for (int k = 0; k < 3 && normal[static_cast<std::size_t>(axis)] == 0; ++k) axis = k;
    const bool up = normal[static_cast<std::size_t>(axis)] > 0;
    const int u = up ? (axis + 1) % 3 : (axis + 2) % 3, v = up ? (axis + 2) % 3 : (axis + 1) % 3;

    PlaneCdt cdt;
    std::map<std::uint32_t, PlaneCdt::Vertex_handle> handles;
    const auto insert = [&](std::uint32_t vertex) {
      const auto found = handles.find(vertex);
      if (found != handles.end()) return found->second;
      const PlanePoint p = point(vertex);
      const PlaneCdt::Vertex_handle h = cdt.insert(PlaneKernel::Point_2(p[u], p[v]));
      h->info().v = vertex;
      return handles[vertex] = h;
    };

    for (const std::uint32_t corner : f) insert(corner);
    for (const Item& item : items)
      for (const std::uint32_t end : item)
        if (!poll_.stop()) insert(end);
    if (poll_.stopped()) return;
    for (std::size_t k = 0; k < 3; ++k) cdt.insert_constraint(handles[f[k]], handles[f[(k + 1) % 3]]);
    for (const Item& item : items)
      if (item[0] != item[1] && !poll_.stop()) cdt.insert_constraint(handles[item[0]], handles[item[1]]);

    for (auto h = cdt.finite_vertices_begin(); h != cdt.finite_vertices_end(); ++h) {
      if (h->info().v != kAdded) continue;
      // Two constraints crossed: lift their crossing back into the plane of the triangle.
      std::array<PlaneKernel::FT, 3> x;
      const auto su = static_cast<std::size_t>(u), sv = static_cast<std::size_t>(v),
                 sa = static_cast<std::size_t>(axis);
      x[su] = h->point().x();
      x[sv] = h->point().y();
      x[sa] = -(normal[su] * x[su] + normal[sv] * x[sv] + plane.d()) / normal[sa];
      h->info().v = id(PlanePoint(x[0], x[1], x[2]));
    }

    for (auto face = cdt.finite_faces_begin(); face != cdt.finite_faces_end(); ++face)
      pieces.push_back({{face->vertex(0)->info().v, face->vertex(1)->info().v, face->vertex(2)->info().v}, t});
  }

  void merge(const std::vector<std::pair<Triangle, std::uint32_t>>& pieces) {
    struct Entry {
      Triangle sorted;
      std::uint32_t piece;
      bool even;
    };
    std::vector<Entry> entries;
    entries.reserve(pieces.size());
    for (std::uint32_t i = 0; i < pieces.size(); ++i) {
      Triangle f = pieces[i].first;
      const bool even = sortCorners(f);
      entries.push_back({f, i, even});
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& x, const Entry& y) {
      return x.sorted != y.sorted ? x.sorted < y.sorted : x.piece < y.piece;
    });

    struct Merged {
      std::uint32_t piece;
      int multiplicity;
      std::vector<std::uint32_t> twins;
    };
    std::vector<Merged> merged;
    for (std::size_t i = 0, j = 0; i < entries.size(); i = j) {
      int net = 0;
      while (j < entries.size() && entries[j].sorted == entries[i].sorted) net += entries[j++].even ? 1 : -1;
      if (net == 0) continue;
      // The piece that carries the surface on is the first with the right orientation.
      Merged m{kAdded, std::abs(net), {}};
      for (std::size_t k = i; k < j; ++k) {
        if (entries[k].even == (net > 0) && m.piece == kAdded) m.piece = entries[k].piece;
        if (j - i > 1) m.twins.push_back(pieces[entries[k].piece].second);
      }
      merged.push_back(std::move(m));
    }

    std::sort(merged.begin(), merged.end(), [](const Merged& x, const Merged& y) { return x.piece < y.piece; });

    for (Merged& m : merged) {
      out_.triangles.push_back(pieces[m.piece].first);
      out_.parent.push_back(pieces[m.piece].second);
      out_.multiplicity.push_back(m.multiplicity);
      out_.twin_of.push_back(m.twins.empty() ? kAdded : static_cast<std::uint32_t>(out_.twins.size()));
      if (!m.twins.empty()) out_.twins.push_back(std::move(m.twins));
    }
  }

  struct Less {
    bool operator()(const PlanePoint& p, const PlanePoint& q) const { return CGAL::compare_xyz(p, q) == CGAL::SMALLER; }
  };
  const Mesh& mesh_;
  Poll& poll_;
  Arrangement out_;
  std::vector<std::vector<Item>> items_;
  std::map<PlanePoint, std::uint32_t, Less> known_;
  std::vector<PlanePoint> new_points_;
};

}  // namespace

Expected<Arrangement> arrangeChain(const Mesh& mesh, const std::vector<std::array<std::uint32_t, 2>>& pairs,
                                   const Progress& progress) {
  Poll poll(progress, 0.5, "resolving crossings");
  try {
    Arrangement arrangement = Arranger(mesh, poll).run(pairs);
    if (poll.stopped()) return cancelled();
    return arrangement;
  } catch (const std::exception& e) {
    return fail({.code = Error::Code::kGeometry,
                 .found = std::string("crossings that could not be resolved exactly (") + e.what() + ")",
                 .hint = "--close wrap"});
  }
}

}  // namespace kerf::internal
