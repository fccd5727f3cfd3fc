#include "geometry/mesh/solids.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace kerf {
namespace {

// Solid angle on the unit sphere, as seen from the origin.
double solidAngleOf(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2 * std::atan2(a.dot(b.cross(c)), below);
}

// Winding number of each shell or solid around a point: 1 inside, 0 outside, -1 inside a lone cavity.
std::vector<double> windings(const Mesh& mesh, const std::vector<std::uint32_t>& label, std::uint32_t count,
                             const Vec3d& point) {
  std::vector<double> out(count, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    out[label[t]] += solidAngleOf(mesh.corner(t, 0) - point, mesh.corner(t, 1) - point, mesh.corner(t, 2) - point);
  for (double& angle : out) angle /= 4 * std::numbers::pi;
  return out;
}

struct Shell {
  double volume = 0;  // mm^3; negative: a cavity
  Vec3d somewhere = Vec3d::Zero();
};

std::vector<Shell> shellsOf(const Mesh& mesh, const Pieces& pieces) {
  std::vector<Shell> out(pieces.count);
  const Vec3d middle = bounds(mesh).center();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3d a = mesh.corner(t, 0) - middle, b = mesh.corner(t, 1) - middle, c = mesh.corner(t, 2) - middle;
    Shell& shell = out[pieces.label[t]];
    shell.volume += a.dot(b.cross(c)) / 6;
    shell.somewhere = mesh.corner(t, 0);
  }
  return out;
}

}  // namespace

Solids solidsOf(const Mesh& mesh) {
  const Pieces pieces = edgeConnectedPieces(mesh);
  const std::vector<Shell> shells = shellsOf(mesh, pieces);

  // Owner of each shell: itself, or the shell around it.
  std::vector<std::uint32_t> owner(pieces.count);
  for (std::uint32_t n = 0; n < pieces.count; ++n) {
    owner[n] = n;
    if (shells[n].volume >= 0) continue;
    const std::vector<double> around = windings(mesh, pieces.label, pieces.count, shells[n].somewhere);
    double smallest = std::numeric_limits<double>::infinity();
    for (std::uint32_t m = 0; m < pieces.count; ++m) {
      if (m == n || shells[m].volume <= 0 || around[m] < 0.5 || shells[m].volume >= smallest) continue;
      smallest = shells[m].volume;
      owner[n] = m;
    }
  }

  Solids out;
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> number(pieces.count, kNone);
  out.label.reserve(mesh.triangles.size());
  for (const std::uint32_t piece : pieces.label) {
    std::uint32_t& solid = number[owner[piece]];
    if (solid == kNone) solid = out.count++;
    out.label.push_back(solid);
  }
  return out;
}

std::vector<Mesh> separated(const Mesh& mesh, const Solids& solids) {
  std::vector<std::vector<std::uint32_t>> triangles(solids.count);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) triangles[solids.label[t]].push_back(t);

  std::vector<Mesh> out(solids.count);
  std::vector<std::uint32_t> index(mesh.vertices.size()), used;
  for (std::uint32_t n = 0; n < solids.count; ++n) {
    Mesh& part = out[n];
    used.clear();
    for (const std::uint32_t t : triangles[n])
      used.insert(used.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (const std::uint32_t v : used) {
      index[v] = static_cast<std::uint32_t>(part.vertices.size());
      part.vertices.push_back(mesh.vertices[v]);
      if (mesh.hasVertexColors()) part.vertex_colors.push_back(mesh.vertex_colors[v]);
    }
    for (const std::uint32_t t : triangles[n]) {
      const Triangle& f = mesh.triangles[t];
      part.triangles.push_back({index[f[0]], index[f[1]], index[f[2]]});
      if (mesh.hasFaceColors()) part.face_colors.push_back(mesh.face_colors[t]);
    }
  }
  return out;
}

PieceCount countPieces(std::span<const double> volumes_mm3) {
  PieceCount out;
  const double largest = volumes_mm3.empty() ? 0 : *std::max_element(volumes_mm3.begin(), volumes_mm3.end());
  for (const double volume : volumes_mm3) {
    out.cavities += volume < 0;
    if (!(volume > 0)) continue;
    ++out.pieces;
    if (!(volume < kLargestSpeck && volume < kSpeckOfLargest * largest)) continue;
    ++out.specks;
    out.specks_mm3 += volume;
  }
  return out;
}

PieceCount countPieces(const Mesh& mesh) {
  std::vector<double> volumes;
  for (const Shell& shell : shellsOf(mesh, edgeConnectedPieces(mesh))) volumes.push_back(shell.volume);
  return countPieces(volumes);
}

std::string describe(const PieceCount& count) {
  std::string text = fmt::format("{} piece{}", count.pieces, count.pieces == 1 ? "" : "s");
  if (count.cavities) text += fmt::format(" with {} cavit{}", count.cavities, count.cavities == 1 ? "y" : "ies");
  if (count.specks)
    text += fmt::format(", {} of them {} (below {} mm3, {:.2g} mm3 together)", count.specks,
                        count.specks == 1 ? "a speck" : "specks", kLargestSpeck, count.specks_mm3);
  return text;
}

std::optional<std::uint32_t> solidAt(const Mesh& mesh, const Solids& solids, const Vec3d& point) {
  const std::vector<double> around = windings(mesh, solids.label, solids.count, point);
  for (std::uint32_t n = 0; n < solids.count; ++n)
    if (around[n] > 0.5) return n;
  return {};
}

bool isInside(const Mesh& mesh, const Vec3d& point) {
  const std::vector<std::uint32_t> as_one(mesh.triangles.size(), 0);
  const long turns = std::lround(windings(mesh, as_one, 1, point).front());
  return turns % 2 != 0;
}

}  // namespace kerf
