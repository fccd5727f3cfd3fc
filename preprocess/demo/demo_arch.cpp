#include "preprocess/demo/demo_arch.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "preprocess/demo/demo_jaw.h"
#include "preprocess/demo/demo_teeth.h"
#include "preprocess/volume/tetrahedral_mesher.h"

namespace kerf {
namespace {

using namespace internal;

Vec3d gradient(const Vec3d& p) {
  constexpr double kStep = 1e-4;
  Vec3d g;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3d d = kStep * Vec3d::Unit(axis);
    g[axis] = (archSurface(p + d) - archSurface(p - d)) / (2 * kStep);
  }
  return g;
}

/// True above the ragged edge of the scanned surface.
bool wasSeen(const Vec3d& p, std::uint32_t seed) {
  const double ragged = 1.6 * valueNoise(p / 6, seed) + 0.7 * valueNoise(p / 1.7, seed + 1);
  return p.z() > -17 + 0.05 * p.y() + ragged && p.y() < 47 + ragged;
}

Rgba8 archColorAt(const Vec3d& p, std::uint32_t seed) {
  const Vec3d q(std::abs(p.x()), p.y(), p.z()), ivory(238, 228, 205), neck(234, 218, 188), gum(214, 128, 128),
      red(196, 98, 104);
  const double tooth = rowValue(ToothTissue::kTooth, q, 3.0), gums = gingiva(p);
  const Vec3d crown = neck + (ivory - neck) * smoothStep(0.5, 3.0, heightOnNearestTooth(q));
  const Vec3d mucosa = gum + (red - gum) * smoothStep(-9, -14, p.z());
  const Vec3d c = mucosa + (crown - mucosa) * smoothStep(-0.12, 0.12, gums - tooth) +
                  Vec3d::Constant(5 * valueNoise(p / 0.8, seed + 2));
  const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0, 255.0))); };
  return {byte(c.x()), byte(c.y()), byte(c.z()), 255};
}

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// Triangle beside each directed edge; an edge of a boundary has none on its other side.
std::map<Edge, std::uint32_t> besideEdges(const Mesh& mesh) {
  std::map<Edge, std::uint32_t> beside;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) beside[{mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]}] = t;
  return beside;
}

std::vector<int> openEdgesAt(const Mesh& mesh) {
  std::vector<int> open(mesh.vertices.size(), 0);
  const auto beside = besideEdges(mesh);
  for (const auto& [edge, t] : beside)
    if (!beside.count({edge.second, edge.first})) {
      ++open[edge.first];
      ++open[edge.second];
    }
  return open;
}

/// The largest piece above the rim, without vertices in which the boundary meets itself.
Mesh trimmed(const Mesh& whole, std::uint32_t seed) {
  std::vector<char> seen(whole.vertices.size());
  for (std::size_t v = 0; v < seen.size(); ++v) seen[v] = wasSeen(whole.vertices[v], seed);
  std::vector<char> keep(whole.triangles.size());
  for (std::size_t t = 0; t < keep.size(); ++t)
    keep[t] = std::ranges::all_of(whole.triangles[t], [&](std::uint32_t v) { return seen[v]; });
  Mesh mesh = subset(whole, keep);

  for (;;) {
    const Pieces pieces = edgeConnectedPieces(mesh);
    std::vector<std::size_t> size(pieces.count, 0);
    for (const std::uint32_t label : pieces.label) ++size[label];
    const auto largest = static_cast<std::uint32_t>(std::ranges::max_element(size) - size.begin());
    const std::vector<int> open = openEdgesAt(mesh);
    keep.assign(mesh.triangles.size(), 1);

    bool changed = false;
    for (std::size_t t = 0; t < keep.size(); ++t) {
      const bool bow_tie = std::ranges::any_of(mesh.triangles[t], [&](std::uint32_t v) { return open[v] > 2; });
      if (pieces.label[t] == largest && !bow_tie) continue;
      keep[t] = 0;
      changed = true;
    }
    if (!changed) return mesh;
    mesh = subset(mesh, keep);
  }
}

/// Places the faults, far from each other and from the rim, where the surface is smooth and free in front.
class Faults {
 public:
  Faults(Mesh& mesh, const DemoArchOptions& options) : mesh_(mesh), options_(options), random_(options.seed) {
    around_.resize(mesh.vertices.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      for (const std::uint32_t v : mesh.triangles[t]) around_[v].push_back(t);
    const std::vector<int> open = openEdgesAt(mesh);
    for (std::uint32_t v = 0; v < open.size(); ++v)
      if (open[v]) taken_.push_back(mesh.vertices[v]);
  }

  DemoArchDefects make() {
    DemoArchDefects made;
    std::vector<char> keep(mesh_.triangles.size(), 1);
    for (int hole = 0; hole < 3; ++hole) {  // a triangle, then whole fans
      const std::uint32_t v = place();
      for (const std::uint32_t t : around_[v]) {
        keep[t] = 0;
        if (hole == 0) break;
      }
      ++made.pin_holes;
    }

    const std::uint32_t spike = place();
    mesh_.vertices[spike] += 1.5 * normal(spike);
    made.spikes = 1;

    const std::vector<std::uint32_t> patch = patchAround(place(), 2);
    std::vector<char> flipped(mesh_.triangles.size(), 0);
    for (const std::uint32_t t : patch) flipped[t] = 1;
    const auto beside = besideEdges(mesh_);
    for (const std::uint32_t t : patch)
      for (std::size_t k = 0; k < 3; ++k)
        made.flipped_edges += !flipped[beside.at({mesh_.triangles[t][(k + 1) % 3], mesh_.triangles[t][k]})];
    for (const std::uint32_t t : patch) std::swap(mesh_.triangles[t][1], mesh_.triangles[t][2]);
    made.flipped_triangles = patch.size();

    for (int island = 0; island < 2; ++island) {
      const std::uint32_t v = place();
      const Vec3d off = 1.4 * normal(v);
      std::map<std::uint32_t, std::uint32_t> copy;
      for (const std::uint32_t t : patchAround(v, island + 1)) {
        Triangle moved = mesh_.triangles[t];
        for (std::uint32_t& corner : moved) {
          const auto [at, is_new] = copy.try_emplace(corner, static_cast<std::uint32_t>(mesh_.vertices.size()));
          if (is_new) {
            mesh_.vertices.push_back(mesh_.vertices[corner] + off);
            mesh_.vertex_colors.push_back(mesh_.vertex_colors[corner]);
          }
          corner = at->second;
        }
        mesh_.triangles.push_back(moved);
        keep.push_back(1);
        ++made.island_triangles;
      }
      ++made.islands;
    }

    mesh_ = subset(mesh_, keep);
    return made;
  }

 private:
  Vec3d normal(std::uint32_t v) const {
    Vec3d sum = Vec3d::Zero();
    for (const std::uint32_t t : around_[v]) sum += doubleAreaVector(mesh_, t);
    return sum.normalized();
  }

  std::uint32_t place() {
    for (int tries = 0;; ++tries) {
      // Coarse meshes bend everywhere: ask for less and less, but always for a distance.
      const double ask = std::max(0.0, 1 - tries / 5000.0), apart = std::max(3.0, (5 + 7 * ask) * options_.edge_mm);
      const auto v = static_cast<std::uint32_t>(random_() % around_.size());
      const Vec3d p = mesh_.vertices[v], n = normal(v);
      const auto close = [&](const Vec3d& q) { return (q - p).norm() < apart; };
      if (std::ranges::any_of(taken_, close)) continue;
      const auto patch = patchAround(v, 3);
      const auto bends = [&](std::uint32_t t) {
        return doubleAreaVector(mesh_, t).normalized().dot(n) < 1.8 * ask - 1;
      };
      if (std::ranges::any_of(patch, bends)) continue;
      if (archSurface(p + 1.2 * n) < 0.8 * ask || archSurface(p + 2.4 * n) < 1.2 * ask) continue;
      taken_.push_back(p);
      return v;
    }
  }

  /// Triangles within `rings` rings around a vertex, ascending.
  std::vector<std::uint32_t> patchAround(std::uint32_t v, int rings) const {
    std::vector<std::uint32_t> patch = around_[v];
    for (int ring = 1; ring < rings; ++ring) {
      std::vector<std::uint32_t> more;
      for (const std::uint32_t t : patch)
        for (const std::uint32_t w : mesh_.triangles[t]) more.insert(more.end(), around_[w].begin(), around_[w].end());
      std::ranges::sort(more);
      more.erase(std::unique(more.begin(), more.end()), more.end());
      patch = std::move(more);
    }
    return patch;
  }

  Mesh& mesh_;
  const DemoArchOptions& options_;
  std::mt19937 random_;
  std::vector<std::vector<std::uint32_t>> around_;  ///< triangles around each vertex
  std::vector<Vec3d> taken_;                        ///< the rim, and where faults are
};

}  // namespace

Expected<DemoArch> demoArch(const DemoArchOptions& options, const Progress& progress) {
  if (!(options.edge_mm >= 0.15 && options.edge_mm <= 1))
    return fail({.code = Error::Code::kBadValue,
                 .place = "edge length",
                 .found = std::to_string(options.edge_mm) + " mm",
                 .expected = "0.15 to 1 mm"});
  if (!(options.noise_mm >= 0 && options.noise_mm <= 0.05))
    return fail({.code = Error::Code::kBadValue,
                 .place = "noise",
                 .found = std::to_string(options.noise_mm) + " mm",
                 .expected = "0 to 0.05 mm"});

  if (!report(progress, 0, "modelling the arch")) return cancelled();
  const Box3 box{Vec3d(-50, -14, -21), Vec3d(50, 53, 4)};
  Mesh whole = meshImplicit(archSurface, box, options.edge_mm / kEdgeToSpacing, 2, 3);
  if (!report(progress, 0.3, "trimming the arch")) return cancelled();
  DemoArch arch;
  arch.mesh = trimmed(whole, options.seed);
  if (!report(progress, 0.4, "evening out the arch")) return cancelled();
  evenOut(arch.mesh, archSurface, 1);

  if (!report(progress, 0.8, "adding noise and faults")) return cancelled();
  const std::vector<Vec3d> smooth = arch.mesh.vertices;
  arch.mesh.vertex_colors.resize(arch.mesh.vertices.size());
  tbb::parallel_for(std::size_t{0}, arch.mesh.vertices.size(), [&](std::size_t v) {
    Vec3d& p = arch.mesh.vertices[v];
    arch.mesh.vertex_colors[v] = archColorAt(p, options.seed);
    // Uniform noise has 1 / sqrt(3) of its range as root mean square; blending corners of cubes leaves 0.36 of it.
    const double white = std::sqrt(3.0) * latticeNoise(static_cast<int>(v), 0, 0, options.seed + 3);
    const double bumps = valueNoise(p / 1.5, options.seed + 4) / 0.36;
    p += options.noise_mm * std::sqrt(0.5) * (white + bumps) * gradient(p).normalized();
  });
  undoCrossings(arch.mesh, smooth);  // in the narrow gaps between teeth
  arch.defects = Faults(arch.mesh, options).make();
  return arch;
}

}  // namespace kerf
