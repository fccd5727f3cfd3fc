#include "preprocess/close/chain.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <span>

#include "geometry/mesh/exact_weld.h"
#include "preprocess/close/close.h"
#include "preprocess/close/duplicates.h"
#include "preprocess/close/openness.h"
#include "preprocess/close/orient.h"
#include "preprocess/close/stitch.h"

namespace kerf::internal {
namespace {

void roundVertices(Mesh& mesh, CloseReport& report) {
  double largest = 0;
  for (Vec3d& p : mesh.vertices) {
    const Vec3d r = roundedToFloat(p);
    if (r != p) {
      ++report.vertices_rounded;
      largest = std::max(largest, (r - p).norm());
    }
    p = r;
  }
  if (report.vertices_rounded)
    report.changes.push_back(fmt::format("{} rounded to single precision (by {:.2g} mm at most)",
                                         counted(report.vertices_rounded, "vertex was", "vertices were"), largest));
  report.largest_move_mm = std::max(report.largest_move_mm, largest);
}

/// Joins vertices at the same place; the first of them stays, bit for bit.
void weldVertices(Chain& chain, CloseReport& report) {
  Mesh& mesh = chain.mesh;
  ExactWelder welder(mesh.vertices.size());
  std::vector<std::uint32_t> index;
  index.reserve(mesh.vertices.size());
  std::uint32_t count = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    index.push_back(welder.add(weldPlace(mesh.vertices[v])));
    if (index.back() != count) continue;
    mesh.vertices[count] = mesh.vertices[v];
    if (mesh.hasVertexColors()) mesh.vertex_colors[count] = mesh.vertex_colors[v];
    ++count;
  }

  report.vertices_welded = mesh.vertices.size() - count;
  if (report.vertices_welded)
    report.changes.push_back(counted(report.vertices_welded, "vertex was", "vertices were") +
                             " welded to another at the same place");
  mesh.vertices.resize(count);
  if (mesh.hasVertexColors()) mesh.vertex_colors.resize(count);
  if (report.vertices_welded)
    for (Triangle& f : mesh.triangles)
      for (std::uint32_t& v : f) v = index[v];
  chain.source_vertices = count;
}

void dropRepeated(Chain& chain, CloseReport& report) {
  std::vector<char> keep;
  std::size_t dropped = 0;
  for (const Triangle& f : chain.mesh.triangles) {
    keep.push_back(f[0] != f[1] && f[1] != f[2] && f[2] != f[0]);
    dropped += !keep.back();
  }
  if (!dropped) return;
  report.changes.push_back(counted(dropped, "triangle without area was", "triangles without area were") + " dropped");
  keepOnly(chain, keep);
}

/// Rejects an edge shared by very many triangles: no surface has one, and the later steps would take the square of
/// their number in time. Copies of one triangle count once, as a later step drops them.
Expected<void> refuseHeaps(const Mesh& mesh) {
  constexpr std::size_t kMostAround = 40;  // scans have 5 at most, labels cut to blocks 4
  std::size_t most = 0;
  Vec3d where = Vec3d::Zero();
  std::vector<std::uint32_t> apexes;
  forEachEdge(edgeUses(mesh.triangles), [&](std::span<const EdgeUse> uses) {
    if (uses.size() <= std::max(most, kMostAround)) return;
    apexes.clear();
    for (const EdgeUse& use : uses) {
      const Triangle& f = mesh.triangles[use.triangle];
      apexes.push_back(f[0] ^ f[1] ^ f[2] ^ use.a ^ use.b);
    }
    std::sort(apexes.begin(), apexes.end());
    const auto count = static_cast<std::size_t>(std::unique(apexes.begin(), apexes.end()) - apexes.begin());
    if (count <= most) return;
    most = count;
    where = 0.5 * (mesh.vertices[uses[0].a] + mesh.vertices[uses[0].b]);
  });
  if (most <= kMostAround) return {};

  Error e;
  e.code = Error::Code::kGeometry;
  e.place = fmt::format("near ({:.3f}, {:.3f}, {:.3f}) mm", where.x(), where.y(), where.z());
  e.found = fmt::format("an edge that {} triangles share", most);
  e.expected = fmt::format("a surface: two at an edge, {} at the very most", kMostAround);
  e.hint = "repair the mesh in another program, for example make it manifold, and export it again";
  return fail(std::move(e));
}

struct PieceInfo {
  Pieces pieces;
  std::vector<std::size_t> size;
  std::vector<double> area;  // mm^2
  std::vector<char> open;
};

PieceInfo measurePieces(const Mesh& mesh) {
  const std::vector<EdgeUse> all = edgeUses(mesh.triangles);
  PieceInfo info{piecesOf(mesh.triangles.size(), all), {}, {}, {}};
  info.size.assign(info.pieces.count, 0);
  info.area.assign(info.pieces.count, 0);
  info.open.assign(info.pieces.count, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    ++info.size[info.pieces.label[t]];
    info.area[info.pieces.label[t]] += 0.5 * doubleAreaVector(mesh, t).norm();
  }
  forEachEdge(all, [&](std::span<const EdgeUse> uses) {
    int net = 0;
    for (const EdgeUse& u : uses) net += u.forth ? 1 : -1;
    if (net != 0) info.open[info.pieces.label[uses[0].triangle]] = 1;
  });
  return info;
}

void dropCrumbs(Chain& chain, const CloseOptions& options, CloseReport& report) {
  if (!hasBoundary(chain)) return;
  const PieceInfo info = measurePieces(chain.mesh);
  const auto limit = options.crumb_fraction * static_cast<double>(chain.mesh.triangles.size());
  const double area_limit = 0.1 * options.crumb_fraction * std::accumulate(info.area.begin(), info.area.end(), 0.0);
  const std::size_t largest = info.pieces.count ? *std::max_element(info.size.begin(), info.size.end()) : 0;
  const auto isCrumb = [&](std::uint32_t l) {
    return info.open[l] && static_cast<double>(info.size[l]) < limit && info.area[l] < area_limit &&
           info.size[l] < largest;
  };

  std::vector<char> keep(chain.mesh.triangles.size(), 1);
  std::size_t triangles = 0;
  for (std::uint32_t t = 0; t < keep.size(); ++t)
    if (isCrumb(info.pieces.label[t])) {
      keep[t] = 0;
      ++triangles;
    }
  for (std::uint32_t l = 0; l < info.pieces.count; ++l) report.crumbs_dropped += isCrumb(l);
  if (!triangles) return;

  report.changes.push_back(fmt::format("{} dropped ({})",
                                       counted(report.crumbs_dropped, "open crumb was", "open crumbs were"),
                                       counted(triangles, "triangle", "triangles")));
  keepOnly(chain, keep);
}

}  // namespace

Vec3d weldPlace(const Vec3d& p) {
  constexpr double kNothing = 1e-9;  // mm
  return (p.array().abs() < kNothing).select(0, p);
}

std::string counted(std::size_t n, const char* singular, const char* plural) {
  return fmt::format("{} {}", n, n == 1 ? singular : plural);
}

Error missingStep(std::string found, CloseStep step, const CloseOptions& options) {
  Error e;
  e.code = Error::Code::kGeometry;
  e.found = std::move(found);
  e.expected = options.only.empty() ? "a mesh that needs no such step"
                                    : fmt::format("none, as only \"{}\" is to be done", namesOf(options.only));
  std::set<CloseStep> more = options.only;
  more.insert(step);
  e.hint = "--close " + namesOf(more);
  return e;
}

std::uint32_t Chain::addVertex(const Vec3d& p) {
  mesh.vertices.push_back(p);
  if (mesh.hasVertexColors()) mesh.vertex_colors.push_back(kNeutral);
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

void Chain::addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  if (a == b || b == c || c == a) return;
  mesh.triangles.push_back({a, b, c});
  source.push_back(kAdded);
  if (mesh.hasFaceColors()) mesh.face_colors.push_back(kNeutral);
}

void keepOnly(Chain& chain, const std::vector<char>& keep) {
  std::size_t count = 0;
  for (std::size_t t = 0; t < keep.size(); ++t) {
    if (!keep[t]) continue;
    chain.mesh.triangles[count] = chain.mesh.triangles[t];
    chain.source[count] = chain.source[t];
    if (chain.mesh.hasFaceColors()) chain.mesh.face_colors[count] = chain.mesh.face_colors[t];
    ++count;
  }
  chain.mesh.triangles.resize(count);
  chain.source.resize(count);
  if (chain.mesh.hasFaceColors()) chain.mesh.face_colors.resize(count);
}

bool hasBoundary(const Chain& chain) {
  const std::vector<EdgeCount> edges = countEdges(chain.mesh.triangles);
  return std::any_of(edges.begin(), edges.end(), [](const EdgeCount& e) { return e.forth != e.back; });
}

Expected<Chain> buildChain(const Mesh& imported, const CloseOptions& options, CloseReport& report) {
  // If the mesh needs an excluded step, the error names the work of that step.
  const auto wanted = [&](CloseStep step) { return options.only.empty() || options.only.count(step) > 0; };
  const auto needed = [&](std::string found, CloseStep step) {
    return fail(missingStep(std::move(found), step, options));
  };
  Chain chain;
  chain.mesh = imported;
  chain.source.resize(imported.triangles.size());
  std::iota(chain.source.begin(), chain.source.end(), 0u);

  roundVertices(chain.mesh, report);
  weldVertices(chain, report);
  if (report.vertices_welded && !wanted(CloseStep::kWeld))
    return needed(counted(report.vertices_welded, "vertex at the place of another", "vertices at the place of another"),
                  CloseStep::kWeld);

  const std::size_t before = chain.mesh.triangles.size();
  dropRepeated(chain, report);
  if (const std::size_t n = before - chain.mesh.triangles.size(); n && !wanted(CloseStep::kDrop))
    return needed(counted(n, "triangle without area", "triangles without area"), CloseStep::kDrop);

  if (wanted(CloseStep::kDrop)) dropRepeatedSurfaces(chain, report);
  KERF_CHECK(refuseHeaps(chain.mesh));
  if (wanted(CloseStep::kStitch)) KERF_CHECK(stitchSeams(chain, options.stitch_mm, report));
  chain.open_mm = openLength(chain.mesh, chain.mesh.triangles);
  orientTriangles(chain, report);
  if (report.triangles_flipped && !wanted(CloseStep::kOrient))
    return needed(counted(report.triangles_flipped, "triangle that disagrees with its neighbours",
                          "triangles that disagree with their neighbours"),
                  CloseStep::kOrient);

  if (wanted(CloseStep::kDrop)) {
    dropDuplicates(chain, report);
    if (report.triangles_flipped && !wanted(CloseStep::kOrient))
      return needed("a piece that is inside out", CloseStep::kOrient);
    dropCrumbs(chain, options, report);
  }
  return chain;
}

}  // namespace kerf::internal
