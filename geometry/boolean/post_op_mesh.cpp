#include "geometry/boolean/post_op_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/boolean/boolean.h"
#include "geometry/boolean/removed_solid.h"
#include "geometry/mesh/float32_cleanup.h"
#include "geometry/mesh/mesh_check.h"

namespace kerf {
namespace {

Rgba8 blend(const Mesh& source, std::size_t t, const Vec3d& p) {
  const Vec3d a = source.corner(t, 0), b = source.corner(t, 1), c = source.corner(t, 2), n = (b - a).cross(c - a);
  const double area = n.squaredNorm();
  Vec3d w = Vec3d::Constant(1.0 / 3);
  if (area > 0) w = Vec3d((b - p).cross(c - p).dot(n), (c - p).cross(a - p).dot(n), (a - p).cross(b - p).dot(n)) / area;
  w = w.cwiseMax(0.0);
  w /= std::max(1e-30, w.sum());
  Rgba8 out{};
  for (std::size_t ch = 0; ch < 4; ++ch) {
    double v = 0;
    for (std::size_t k = 0; k < 3; ++k) v += w[static_cast<int>(k)] * source.vertex_colors[source.triangles[t][k]][ch];
    out[ch] = static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0, 255.0)));
  }
  return out;
}

// Source colours stay; cut walls get their own, per vertex when the source is coloured per vertex, per face otherwise.
void paint(const Mesh& source, const Difference& cut, const PostOpOptions& options, Mesh& mesh) {
  if (source.hasVertexColors()) {
    mesh.vertex_colors.assign(mesh.vertices.size(), options.cut_color);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      if (cut.from_triangle[t] != kNoSource)
        for (const std::uint32_t v : mesh.triangles[t])
          if (cut.from_vertex[v] == kNoSource)
            mesh.vertex_colors[v] = blend(source, cut.from_triangle[t], mesh.vertices[v]);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
      if (cut.from_vertex[v] != kNoSource) mesh.vertex_colors[v] = source.vertex_colors[cut.from_vertex[v]];
  }
  if (source.hasFaceColors() || !source.hasVertexColors()) {
    mesh.face_colors.assign(mesh.triangles.size(), options.cut_color);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      if (cut.from_triangle[t] != kNoSource)
        mesh.face_colors[t] = source.hasFaceColors() ? source.face_colors[cut.from_triangle[t]] : options.source_color;
  }
}

struct Crumbs {
  std::vector<char> keep_triangle;
  std::size_t count = 0, pieces = 0, cavities = 0;
  double volume = 0;
};

// Only pieces touched by the cut: a small untouched piece belongs to the source.
Crumbs findCrumbs(const Mesh& mesh, const std::vector<std::uint32_t>& from_triangle, double below_mm3) {
  Crumbs out;
  const Pieces pieces = edgeConnectedPieces(mesh);
  std::vector<double> volume(pieces.count, 0);
  std::vector<char> is_crumb(pieces.count, 0);
  const Vec3d c = bounds(mesh).center();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    volume[pieces.label[t]] += (mesh.corner(t, 0) - c).dot((mesh.corner(t, 1) - c).cross(mesh.corner(t, 2) - c)) / 6;

  std::uint32_t largest = 0;
  for (std::uint32_t p = 0; p < pieces.count; ++p)
    if (volume[p] > volume[largest]) largest = p;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t p = pieces.label[t];
    if (from_triangle[t] == kNoSource && p != largest && std::abs(volume[p]) < below_mm3) is_crumb[p] = 1;
  }

  out.keep_triangle.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) out.keep_triangle[t] = !is_crumb[pieces.label[t]];
  for (std::size_t p = 0; p < volume.size(); ++p) {
    if (is_crumb[p]) {
      ++out.count;
      out.volume += std::abs(volume[p]);
      continue;
    }
    out.pieces += volume[p] > 0;
    out.cavities += volume[p] < 0;
  }
  return out;
}

// The unchanged source, each vertex and triangle its own origin: for a cut without removed volume.
Difference uncut(const Mesh& source) {
  Difference cut;
  cut.mesh = {source.vertices, source.triangles, {}, {}};
  cut.from_vertex.resize(source.vertices.size());
  std::iota(cut.from_vertex.begin(), cut.from_vertex.end(), 0u);
  cut.from_triangle.resize(source.triangles.size());
  std::iota(cut.from_triangle.begin(), cut.from_triangle.end(), 0u);
  return cut;
}

// Source minus removed, plus added; origins are those in the source.
Expected<Difference> cutAndAdd(const Mesh& source, const Mesh& removed, const Mesh& added, PostOpReport& report) {
  Difference cut;
  if (removed.triangles.empty()) {
    cut = uncut(source);
  } else {
    KERF_TRY(difference, subtract(source, removed));
    report.boolean_triangles = difference.triangles_taken;
    cut = std::move(difference);
  }
  if (added.triangles.empty()) return cut;

  report.removed_volume_mm3 = signedVolume(source) - signedVolume(cut.mesh);
  KERF_TRY(both, unite(cut.mesh, added));
  report.boolean_triangles = std::max(report.boolean_triangles, both.triangles_taken);
  // Maps origins in the cut mesh to origins in the source.
  for (std::uint32_t& v : both.from_vertex)
    if (v != kNoSource) v = cut.from_vertex[v];
  for (std::uint32_t& t : both.from_triangle)
    if (t != kNoSource) t = cut.from_triangle[t];
  return std::move(both);
}

// A mesh with tags of its vertices and triangles.
struct TaggedMesh {
  Mesh mesh;
  std::vector<std::uint32_t> tag;  // per triangle: of the source, or kNoSource
  std::vector<char> fixed;         // per vertex: of the source, must not move
};

// Leaves the crumbs out, and the vertices that only they used.
void dropCrumbs(const Crumbs& crumbs, TaggedMesh& out, PostOpReport& report) {
  std::vector<char> used(out.mesh.vertices.size(), 0);
  std::vector<std::uint32_t> kept_tag;
  for (std::size_t t = 0; t < out.mesh.triangles.size(); ++t)
    if (crumbs.keep_triangle[t]) {
      kept_tag.push_back(out.tag[t]);
      for (const std::uint32_t v : out.mesh.triangles[t]) used[v] = 1;
    }

  std::vector<char> kept_fixed;
  for (std::size_t v = 0; v < out.fixed.size(); ++v) {
    if (used[v])
      kept_fixed.push_back(out.fixed[v]);
    else
      report.source_vertices_in_crumbs += out.fixed[v];
  }
  out.mesh = subset(out.mesh, crumbs.keep_triangle);
  out.tag = std::move(kept_tag);
  out.fixed = std::move(kept_fixed);
}

// Counts and volumes of the report that follow from the result.
void summarise(const Mesh& source, double source_volume, bool has_added, const TaggedMesh& out, PostOpReport& report) {
  report.source_vertices_kept = static_cast<std::size_t>(std::count(out.fixed.begin(), out.fixed.end(), 1));
  report.source_vertices_removed =
      source.vertices.size() - report.source_vertices_kept - report.source_vertices_in_crumbs;
  report.source_volume_mm3 = source_volume;
  report.result_volume_mm3 = signedVolume(out.mesh);
  if (has_added)
    report.added_volume_mm3 = report.result_volume_mm3 - report.source_volume_mm3 + report.removed_volume_mm3;
  else
    report.removed_volume_mm3 = report.source_volume_mm3 - report.result_volume_mm3;
}

Expected<internal::FinishedCut> attempt(const Mesh& source, const Mesh& removed, const Mesh& added, double voxel,
                                        const PostOpOptions& options) {
  PostOpReport report;
  KERF_TRY(cut, cutAndAdd(source, removed, added, report));
  const double crumb_mm3 =
      std::min(options.crumb_voxels * std::pow(voxel, 3), options.crumb_fraction * signedVolume(source));
  return internal::finishCut(source, std::move(cut), 0.01 * voxel, crumb_mm3, options, report,
                             !added.triangles.empty());
}

}  // namespace

Expected<internal::FinishedCut> internal::finishCut(const Mesh& source, Difference cut, double length_mm,
                                                    double crumb_mm3, const PostOpOptions& options, PostOpReport known,
                                                    bool has_added) {
  FinishedCut out;
  PostOpReport& report = out.result.report;
  report = known;
  TaggedMesh now{std::move(cut.mesh), cut.from_triangle, {}};
  paint(source, cut, options, now.mesh);
  now.fixed.resize(now.mesh.vertices.size());
  for (std::size_t v = 0; v < now.fixed.size(); ++v) now.fixed[v] = cut.from_vertex[v] != kNoSource;

  const double source_volume = signedVolume(source);
  const Crumbs crumbs = findCrumbs(now.mesh, cut.from_triangle, crumb_mm3);
  report.crumbs_dropped = crumbs.count;
  report.crumbs_volume_mm3 = crumbs.volume;
  report.crumb_mm3 = crumb_mm3;
  report.pieces = crumbs.pieces;
  report.cavities = crumbs.cavities;
  if (crumbs.count) dropCrumbs(crumbs, now, report);

  KERF_TRY(cleaned, cleanUpForFloat32(now.mesh, now.fixed, &now.tag, length_mm));
  report.largest_move_mm = cleaned.largest_move_mm;
  if (cleaned.crossings_left > 0)
    out.why_not = fmt::format("{} pairs of triangles cross after rounding to float32", cleaned.crossings_left);
  if (cleaned.fixed_moved > 0)
    out.why_not = fmt::format("{} source vertices are not representable in float32", cleaned.fixed_moved);

  if (now.mesh.triangles.empty())
    return fail({.code = Error::Code::kEmpty,
                 .place = "post-operative mesh",
                 .found = "the cut leaves nothing of the object",
                 .expected = "something to print",
                 .hint = "a smaller cut"});
  if (out.why_not.empty()) {
    // The clean-up has already found this mesh free of crossings.
    if (const MeshReport verdict = checkMesh(now.mesh, {.known_free_of_crossings = true}); !verdict.print_ready)
      out.why_not = verdict.reasons.empty() ? "not ready to print" : verdict.reasons.front();
  }

  summarise(source, source_volume, has_added, now, report);
  out.result.is_cut.resize(now.mesh.triangles.size());
  for (std::size_t t = 0; t < now.tag.size(); ++t) out.result.is_cut[t] = now.tag[t] == kNoSource;
  report.cut_triangles = static_cast<std::size_t>(std::count(out.result.is_cut.begin(), out.result.is_cut.end(), 1));
  out.result.is_source = std::move(now.fixed);
  out.result.mesh = std::move(now.mesh);
  return out;
}

Expected<PostOpMesh> postOperativeMesh(const Mesh& source, const BrickField& rho, const PostOpOptions& options,
                                       const Progress& progress, const BrickField* added) {
  const double h = rho.voxel();

  // Rounding to float32 fails at random, but rarely: a retry shifts the cut by three thousandths of a voxel. That is
  // far below the cut's accuracy, and moves no source vertex.
  constexpr int kAttempts = 4;
  Error last;
  for (int n = 1; n <= kAttempts; ++n) {
    if (!report(progress, (n - 1) / double{kAttempts}, "meshing the removed solid")) return cancelled();
    const auto meshOf = [&](const BrickField& solid) {
      BrickField shifted = solid;
      if (n > 1) {
        const int round = n / 2;
        const auto by = static_cast<float>((n % 2 ? 0.003 : -0.003) * round * h);
        for (std::size_t b = 0; b < shifted.brickCount(); ++b)
          for (float& v : shifted.brick(b)) v += by;
      }
      return meshRemovedSolid(shifted).mesh;
    };

    const Mesh removed = meshOf(rho), put_on = added ? meshOf(*added) : Mesh{};
    if (!report(progress, (n - 0.7) / kAttempts, "exact difference")) return cancelled();

    auto prepared = attempt(source, removed, put_on, h, options);
    if (prepared && prepared->why_not.empty()) {
      prepared->result.report.attempts = n;
      return std::move(prepared->result);
    }
    last = prepared
               ? Error{Error::Code::kGeometry, "",
                       "post-operative mesh",  prepared->why_not,
                       "a printable mesh",     "bake with another --voxel and cut again, or kerf check on the source"}
               : prepared.error();
    if (last.code == Error::Code::kEmpty) break;  // shifting will not help
  }
  last.found += "; nothing was written";
  return fail(last);
}

}  // namespace kerf
