#include "geometry/mesh/mesh_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <utility>

#include "geometry/mesh/box_tree.h"
#include "geometry/mesh/exact_weld.h"
#include "geometry/mesh/self_intersection.h"
#include "geometry/mesh/solids.h"

namespace kerf {
namespace {

class UnionFind {
 public:
  explicit UnionFind(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

// One use of an undirected edge (low, high) by a corner of a triangle.
struct EdgeUse {
  std::uint32_t high, triangle;
  std::uint8_t corner;  // the edge runs from this corner to the next
  bool ascending;       // from low to high
};

// Uses of all edges, grouped by their low vertex and sorted by the high one: a counting sort and many tiny ones.
struct EdgeTable {
  std::vector<std::uint32_t> begin;  // per vertex
  std::vector<EdgeUse> uses;

  EdgeTable(std::size_t vertices, const std::vector<Triangle>& triangles)
      : begin(vertices + 1), uses(3 * triangles.size()) {
    for (const Triangle& t : triangles)
      for (std::size_t k = 0; k < 3; ++k) ++begin[std::min(t[k], t[(k + 1) % 3]) + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());

    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for (std::uint32_t i = 0; i < triangles.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = triangles[i][k], b = triangles[i][(k + 1) % 3];
        uses[next[std::min(a, b)]++] = {std::max(a, b), i, static_cast<std::uint8_t>(k), a < b};
      }

    for (std::size_t v = 0; v < vertices; ++v)
      std::sort(uses.begin() + begin[v], uses.begin() + begin[v + 1], [](const EdgeUse& x, const EdgeUse& y) {
        return x.high != y.high ? x.high < y.high : x.triangle < y.triangle;
      });
  }

  // Calls f(low, first use, number of uses) for every edge.
  template <class F>
  void forEachEdge(const F& f) const {
    for (std::uint32_t v = 0; v + 1 < begin.size(); ++v)
      for (std::uint32_t i = begin[v]; i < begin[v + 1];) {
        std::uint32_t j = i + 1;
        while (j < begin[v + 1] && uses[j].high == uses[i].high) ++j;
        f(v, &uses[i], j - i);
        i = j;
      }
  }
};

// The mesh as printed: float32 positions, welded, without triangles that lost a corner.
struct Printed {
  Mesh mesh;
  std::size_t duplicate_vertices = 0, collapsed = 0;
};

Printed printed(const Mesh& mesh) {
  Printed out;
  constexpr std::uint32_t kUnused = ~0u;
  std::vector<std::uint32_t> index(mesh.vertices.size(), kUnused);
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) index[v] = 0;

  internal::ExactWelder welder(mesh.vertices.size());
  std::size_t used = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (index[v] != kUnused) {
      index[v] = welder.add(roundedToFloat(mesh.vertices[v]));
      ++used;
    }
  out.duplicate_vertices = used - welder.vertices.size();

  out.mesh.vertices = std::move(welder.vertices);
  out.mesh.triangles.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    const Triangle w{index[t[0]], index[t[1]], index[t[2]]};
    if (w[0] == w[1] || w[1] == w[2] || w[2] == w[0])
      ++out.collapsed;
    else
      out.mesh.triangles.push_back(w);
  }
  return out;
}

// Grouped by their lowest corner: a counting sort and many tiny ones.
std::size_t countDuplicates(std::size_t vertices, const std::vector<Triangle>& triangles) {
  std::vector<std::uint32_t> begin(vertices + 1);
  for (const Triangle& t : triangles) ++begin[*std::min_element(t.begin(), t.end()) + std::size_t{1}];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());

  std::vector<std::uint64_t> others(triangles.size());  // the two higher corners
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (Triangle t : triangles) {
    std::sort(t.begin(), t.end());
    others[next[t[0]]++] = std::uint64_t{t[1]} << 32 | t[2];
  }

  std::size_t count = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    std::sort(others.begin() + begin[v], others.begin() + begin[v + 1]);
    for (std::size_t i = begin[v] + std::size_t{1}; i < begin[v + 1]; ++i) count += others[i] == others[i - 1];
  }
  return count;
}

// An edge of one triangle only.
struct RimEdge {
  std::uint32_t a, b, triangle;
};

// Results of one pass over the edge table.
struct EdgeWalk {
  UnionFind pieces;  // of triangles: joined across edges
  UnionFind fans;    // of the corners of triangles: joined around their vertex across edges
  UnionFind rims;    // of vertices: joined along the rim
  std::vector<RimEdge> rim;
  std::uint32_t most_at_an_edge = 0;  // triangles
};

EdgeWalk walkEdges(const Mesh& mesh, MeshReport& report) {
  const EdgeTable table(mesh.vertices.size(), mesh.triangles);
  EdgeWalk out{
      UnionFind(mesh.triangles.size()), UnionFind(3 * mesh.triangles.size()), UnionFind(mesh.vertices.size()), {}};
  const auto cornerOf = [&](const EdgeUse& use, bool at_low) {
    const std::size_t k = use.ascending == at_low ? use.corner : (use.corner + 1u) % 3;
    return 3 * use.triangle + static_cast<std::uint32_t>(k);
  };
  table.forEachEdge([&](std::uint32_t low, const EdgeUse* use, std::uint32_t n) {
    if (n == 1) {
      ++report.boundary_edges;
      out.rims.join(low, use->high);
      out.rim.push_back({low, use->high, use->triangle});
    }
    if (n == 2 && use[0].ascending == use[1].ascending) ++report.flipped_edges;
    if (n > 2) ++report.non_manifold_edges;
    out.most_at_an_edge = std::max(out.most_at_an_edge, n);
    for (std::uint32_t i = 1; i < n; ++i) {
      out.pieces.join(use[0].triangle, use[i].triangle);
      out.fans.join(cornerOf(use[0], true), cornerOf(use[i], true));
      out.fans.join(cornerOf(use[0], false), cornerOf(use[i], false));
    }
  });
  return out;
}

/// If more triangles share an edge, skips the search for crossings: it would compare all of them with each other, and
/// the mesh is not ready to print anyway.
constexpr std::uint32_t kMostAtAnEdge = 1000;

constexpr std::uint32_t kNone = ~0u;

// The loops of the rim, the longest first.
void countLoops(const Mesh& mesh, EdgeWalk& walk, MeshReport& report) {
  std::vector<std::uint32_t> loop_of(mesh.vertices.size(), kNone);
  for (const RimEdge& e : walk.rim) {
    std::uint32_t& loop = loop_of[walk.rims.find(e.a)];
    if (loop == kNone) {
      loop = static_cast<std::uint32_t>(report.boundary_loops.size());
      report.boundary_loops.emplace_back();
    }
    ++report.boundary_loops[loop].edges;
    report.boundary_loops[loop].length += (mesh.vertices[e.a] - mesh.vertices[e.b]).norm();
  }
  std::stable_sort(report.boundary_loops.begin(), report.boundary_loops.end(),
                   [](const BoundaryLoop& a, const BoundaryLoop& b) { return a.length > b.length; });
}

// Vertices of more than one fan.
std::size_t countBowTies(const Mesh& mesh, EdgeWalk& walk) {
  std::vector<std::uint32_t> fan_of(mesh.vertices.size(), kNone);
  std::vector<char> bow_tie(mesh.vertices.size());
  for (std::uint32_t c = 0; c < 3 * mesh.triangles.size(); ++c) {
    const std::uint32_t v = mesh.triangles[c / 3][c % 3], fan = walk.fans.find(c);
    if (fan_of[v] == kNone) fan_of[v] = fan;
    if (fan_of[v] != fan) bow_tie[v] = 1;
  }
  return static_cast<std::size_t>(std::count(bow_tie.begin(), bow_tie.end(), 1));
}

// Edges, loops, pieces and fans in one pass over the edge table. @return the piece of every triangle.
// @param most_at_an_edge  out: triangles at the edge that most share.
std::vector<std::uint32_t> countTopology(const Mesh& mesh, MeshReport& report, std::vector<char>& piece_is_open,
                                         std::uint32_t& most_at_an_edge) {
  EdgeWalk walk = walkEdges(mesh, report);
  most_at_an_edge = walk.most_at_an_edge;

  std::vector<std::uint32_t> label(mesh.triangles.size());
  for (std::uint32_t t = 0; t < label.size(); ++t) {
    const std::uint32_t root = walk.pieces.find(t);
    label[t] = root == t ? static_cast<std::uint32_t>(report.pieces++) : label[root];
  }
  piece_is_open.assign(report.pieces, 0);
  for (const RimEdge& e : walk.rim) piece_is_open[label[e.triangle]] = 1;

  countLoops(mesh, walk, report);
  report.non_manifold_vertices = countBowTies(mesh, walk);
  return label;
}

// Solid angle of a triangle seen from p, signed. After Van Oosterom & Strackee, 1983.
double solidAngle(Vec3d a, Vec3d b, Vec3d c, const Vec3d& p) {
  a -= p;
  b -= p;
  c -= p;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  return 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
}

// The triangles of every piece, one after the other.
struct TrianglesOfPieces {
  std::vector<std::uint32_t> triangle;
  std::vector<std::size_t> begin;  // of piece p: triangle[begin[p] .. begin[p + 1])

  TrianglesOfPieces(const std::vector<std::uint32_t>& label, std::size_t pieces)
      : triangle(label.size()), begin(pieces + 1, 0) {
    for (const std::uint32_t piece : label) ++begin[piece + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::size_t> at(begin.begin(), begin.end());
    for (std::uint32_t t = 0; t < label.size(); ++t) triangle[at[label[t]]++] = t;
  }
};

// Volume, box and a vertex of every piece.
struct PieceShapes {
  std::vector<double> volume;  // mm3, signed
  std::vector<Box3> box;
  std::vector<std::uint32_t> a_vertex;
};

PieceShapes shapesOf(const Mesh& mesh, const std::vector<std::uint32_t>& label, const MeshReport& report) {
  const Vec3d center = report.box.center();
  PieceShapes out{std::vector<double>(report.pieces), std::vector<Box3>(report.pieces),
                  std::vector<std::uint32_t>(report.pieces)};
  for (std::size_t t = 0; t < label.size(); ++t) {
    const Vec3d a = mesh.corner(t, 0) - center, b = mesh.corner(t, 1) - center, c = mesh.corner(t, 2) - center;
    out.volume[label[t]] += a.dot(b.cross(c)) / 6;
    for (int k = 0; k < 3; ++k) out.box[label[t]].add(mesh.corner(t, k));
    out.a_vertex[label[t]] = mesh.triangles[t][0];
  }
  return out;
}

// Which pieces are cavities: closed ones of negative volume inside another closed piece.
std::vector<char> findCavities(const Mesh& mesh, const std::vector<std::uint32_t>& label,
                               const std::vector<char>& is_open, const PieceShapes& shapes) {
  const std::vector<double>& volume = shapes.volume;
  std::vector<char> is_cavity(volume.size(), 0);
  if (std::none_of(volume.begin(), volume.end(), [](double v) { return v < 0; })) return is_cavity;

  const TrianglesOfPieces of(label, volume.size());
  const BoxTree boxes(shapes.box);
  for (std::uint32_t piece = 0; piece < volume.size(); ++piece) {
    if (is_open[piece] || !(volume[piece] < 0)) continue;
    const Vec3d& p = mesh.vertices[shapes.a_vertex[piece]];

    const auto surrounds = [&](std::uint32_t other) {
      if (other == piece || is_open[other] || !(volume[other] > 0) || !shapes.box[other].contains(p)) return false;
      double angle = 0;
      for (std::size_t i = of.begin[other]; i < of.begin[other + 1]; ++i) {
        const std::size_t t = of.triangle[i];
        angle += solidAngle(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), p);
      }
      return angle > 2 * std::numbers::pi;  // half of the full 4 pi
    };
    is_cavity[piece] = !boxes.visit([&](const Box3& node) { return node.contains(p); },
                                    [&](std::uint32_t other) { return !surrounds(other); });
  }
  return is_cavity;
}

// Pieces, cavities, specks, and pieces turned inside out.
void judgePieces(const Mesh& mesh, const std::vector<std::uint32_t>& label, const std::vector<char>& is_open,
                 MeshReport& report) {
  const PieceShapes shapes = shapesOf(mesh, label, report);
  const std::vector<char> is_cavity = findCavities(mesh, label, is_open, shapes);
  std::vector<double> closed;  // volumes, mm3
  for (std::size_t piece = 0; piece < is_cavity.size(); ++piece) {
    report.cavities += is_cavity[piece] != 0;
    if (is_open[piece] || is_cavity[piece]) continue;
    report.inward_pieces += shapes.volume[piece] < 0;
    closed.push_back(std::abs(shapes.volume[piece]));
  }
  report.pieces -= report.cavities;
  const PieceCount count = countPieces(closed);
  report.specks = count.specks;
  report.specks_mm3 = count.specks_mm3;
}

std::string counted(std::size_t n, const char* one, const char* many) {
  return fmt::format("{} {}", n, n == 1 ? one : many);
}

void judge(MeshReport& r) {
  const auto because = [&](std::string reason) { r.reasons.push_back(std::move(reason)); };
  if (r.triangles == 0) return because("There are no triangles.");
  if (r.boundary_edges > 0)
    because(fmt::format("The surface is open: {} along {}, the longest {:.4g} mm around.",
                        counted(r.boundary_edges, "boundary edge", "boundary edges"),
                        counted(r.boundary_loops.size(), "loop", "loops"), r.boundary_loops.front().length));

  if (r.self_intersections > 0)
    because(fmt::format("The surface crosses itself: {} meet where they are not joined.",
                        counted(r.self_intersections, "pair of triangles", "pairs of triangles")));
  if (!r.self_intersections_checked) because("Self-intersections were not checked.");

  if (r.non_manifold_edges > 0)
    because(
        fmt::format("{} shared by three or more triangles.", counted(r.non_manifold_edges, "edge is", "edges are")));
  if (r.non_manifold_vertices > 0)
    because(fmt::format("{} the surface only in a point.",
                        counted(r.non_manifold_vertices, "vertex joins parts of", "vertices join parts of")));
  if (r.flipped_edges > 0)
    because(fmt::format("{} between triangles that face opposite ways.",
                        counted(r.flipped_edges, "edge lies", "edges lie")));

  if (r.degenerate_triangles > 0)
    because(fmt::format("{} no area once rounded to float32.",
                        counted(r.degenerate_triangles, "triangle has", "triangles have")));
  if (r.duplicate_triangles > 0)
    because(fmt::format("{} there twice.", counted(r.duplicate_triangles, "triangle is", "triangles are")));
  if (r.inward_pieces > 0)
    because(fmt::format("{} turned inside out.", counted(r.inward_pieces, "closed piece is", "closed pieces are")));

  const double size = r.box.isEmpty() ? 0 : r.box.size().maxCoeff();
  if (!(size <= kLargestPrint))
    because(fmt::format("It is {:.4g} mm long, more than any printer takes. Check the unit.", size));
  if (size < kSmallestPrint)
    because(fmt::format("It is {:.4g} mm long, less than any printer makes. Check the unit.", size));
  if (r.boundary_edges == 0 && r.inward_pieces == 0 && !(r.volume > 0)) because("The enclosed volume is not positive.");
}

}  // namespace

MeshReport checkMesh(const Mesh& mesh, const MeshCheckOptions& options) {
  MeshReport report;
  report.triangles = mesh.triangles.size();
  report.vertices = mesh.vertices.size();

  const Printed print = printed(mesh);
  const Mesh& m = print.mesh;
  report.duplicate_vertices = print.duplicate_vertices;
  report.degenerate_triangles = print.collapsed + degenerateTriangles(m.vertices, m.triangles).size();
  report.duplicate_triangles = countDuplicates(m.vertices.size(), m.triangles);

  report.box = bounds(m);
  report.area = surfaceArea(m);
  report.volume = signedVolume(m);

  std::vector<char> is_open;
  std::uint32_t most_at_an_edge = 0;
  const std::vector<std::uint32_t> label = countTopology(m, report, is_open, most_at_an_edge);
  judgePieces(m, label, is_open, report);

  if (options.known_free_of_crossings) {
    report.self_intersections_checked = true;
  } else if (options.self_intersections && most_at_an_edge <= kMostAtAnEdge) {
    report.self_intersections_checked = true;
    const std::size_t at_most = std::max<std::size_t>(1, options.max_self_intersections);
    report.self_intersections = selfIntersections(m.vertices, m.triangles, at_most).size();
  }

  judge(report);
  report.print_ready = report.reasons.empty();
  return report;
}

std::string toJson(const MeshReport& r) {
  using Json = nlohmann::ordered_json;
  const auto vector = [](const Vec3d& p) { return Json::array({p.x(), p.y(), p.z()}); };
  Json loops = Json::array();
  for (const BoundaryLoop& loop : r.boundary_loops)
    loops.push_back({{"edges", loop.edges}, {"length_mm", loop.length}});

  Json json = {{"print_ready", r.print_ready},
               {"reasons", r.reasons},
               {"triangles", r.triangles},
               {"vertices", r.vertices},
               {"closed", r.isClosed()},
               {"boundary_edges", r.boundary_edges},
               {"boundary_loops", std::move(loops)},
               {"non_manifold_edges", r.non_manifold_edges},
               {"non_manifold_vertices", r.non_manifold_vertices},
               {"flipped_edges", r.flipped_edges},
               {"degenerate_triangles", r.degenerate_triangles},
               {"duplicate_triangles", r.duplicate_triangles},
               {"duplicate_vertices", r.duplicate_vertices},
               {"pieces", r.pieces},
               {"cavities", r.cavities},
               {"specks", r.specks},
               {"specks_mm3", r.specks_mm3},
               {"inward_pieces", r.inward_pieces},
               {"self_intersections", r.self_intersections_checked ? Json(r.self_intersections) : Json(nullptr)},
               {"area_mm2", r.area},
               {"volume_mm3", r.isClosed() ? Json(r.volume) : Json(nullptr)}};

  json["box_mm"] = r.box.isEmpty() ? Json(nullptr) : Json{{"min", vector(r.box.min)}, {"max", vector(r.box.max)}};
  return json.dump(2);
}

std::string describe(const MeshReport& r) {
  std::string text = r.print_ready ? "Ready to print.\n" : "Not ready to print:\n";
  for (const std::string& reason : r.reasons) text += "  - " + reason + "\n";
  const Vec3d size = r.box.size();
  text += fmt::format("{} triangles, {} vertices, {}; {:.4g} x {:.4g} x {:.4g} mm, area {:.6g} mm2", r.triangles,
                      r.vertices, describe(PieceCount{r.pieces, r.cavities, r.specks, r.specks_mm3}), size.x(),
                      size.y(), size.z(), r.area);
  if (r.isClosed()) text += fmt::format(", volume {:.6g} mm3", r.volume);
  text += "\n";
  if (r.cavities > 0) text += "Closed cavities: a resin or powder printer leaves material in them.\n";
  return text;
}

}  // namespace kerf
