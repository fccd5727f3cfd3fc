#include "preprocess/close/orient.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>

#include "geometry/mesh/box_tree.h"
#include "preprocess/close/close.h"
#include "preprocess/close/winding.h"

namespace kerf::internal {
namespace {

constexpr std::uint32_t kNoTriangle = ~0u;

void flip(Triangle& f) { std::swap(f[1], f[2]); }

// Neighbours across two-sided edges.
struct Neighbours {
  std::vector<std::array<std::uint32_t, 3>> next;  // per triangle: up to three, then kNoTriangle
  std::vector<std::array<char, 3>> differs;        // whether that one faces the other way
};

bool joins(std::span<const EdgeUse> uses) { return uses.size() == 2 && uses[0].triangle != uses[1].triangle; }

Neighbours facesAcross(std::size_t triangles, const std::vector<EdgeUse>& all) {
  Neighbours out{std::vector<std::array<std::uint32_t, 3>>(triangles, {kNoTriangle, kNoTriangle, kNoTriangle}),
                 std::vector<std::array<char, 3>>(triangles, {0, 0, 0})};
  std::vector<int> filled(triangles, 0);
  forEachEdge(all, [&](std::span<const EdgeUse> uses) {
    if (!joins(uses)) return;
    const char wrong = uses[0].forth == uses[1].forth;
    for (std::size_t k = 0; k < 2; ++k) {
      const std::uint32_t t = uses[k].triangle;
      const auto slot = static_cast<std::size_t>(filled[t]++);
      out.next[t][slot] = uses[1 - k].triangle;
      out.differs[t][slot] = wrong;
    }
  });
  return out;
}

// The triangles connected with `seed`; turn[t] becomes 0 or 1, by whether t faces as the seed does.
void spread(std::uint32_t seed, const Neighbours& neighbours, std::vector<signed char>& turn,
            std::vector<std::uint32_t>& patch) {
  patch.assign(1, seed);
  turn[seed] = 0;
  for (std::size_t i = 0; i < patch.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t t = patch[i], u = neighbours.next[t][k];
      if (u == kNoTriangle || turn[u] >= 0) continue;
      turn[u] = static_cast<signed char>(turn[t] ^ neighbours.differs[t][k]);
      patch.push_back(u);
    }
}

// Signed volume, box and largest triangle of every piece.
struct PieceSizes {
  std::vector<double> volume;
  std::vector<std::uint32_t> biggest;
  std::vector<Box3> box;
};

PieceSizes sizesOf(const Mesh& mesh, const Pieces& pieces) {
  PieceSizes out{std::vector<double>(pieces.count, 0), std::vector<std::uint32_t>(pieces.count, kNoTriangle),
                 std::vector<Box3>(pieces.count)};
  std::vector<double> biggest_area(pieces.count, -1);
  const Vec3d center = bounds(mesh).center();
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t l = pieces.label[t];
    const Vec3d a = mesh.corner(t, 0) - center, b = mesh.corner(t, 1) - center, c = mesh.corner(t, 2) - center;
    out.volume[l] += a.dot(b.cross(c)) / 6;
    const double area = (b - a).cross(c - a).squaredNorm();
    if (area > biggest_area[l]) {
      biggest_area[l] = area;
      out.biggest[l] = t;
    }
    for (int k = 0; k < 3; ++k) out.box[l].add(mesh.corner(t, k));
  }
  return out;
}

// Whether the box of piece `l` lies in that of another.
bool isHeld(const BoxTree& pieces, std::uint32_t l) {
  const Box3& inner = pieces.boxes()[l];
  return !pieces.visit([&](const Box3& node) { return holds(node, inner); },
                       [&](std::uint32_t o) { return o == l || !holds(pieces.boxes()[o], inner); });
}

// Whether the place of piece `l` lies in what the other pieces enclose.
bool liesInOthers(const Mesh& mesh, const Pieces& pieces, std::uint32_t l, std::uint32_t triangle,
                  std::optional<RayWinding>& rays) {
  const Vec3d p = (mesh.corner(triangle, 0) + mesh.corner(triangle, 1) + mesh.corner(triangle, 2)) / 3;
  if (!rays) rays.emplace(mesh);
  if (const auto winding = rays->at(p, [&](std::uint32_t t) { return pieces.label[t] == l; })) return *winding != 0;
  std::vector<char> skip(mesh.triangles.size());
  for (std::size_t t = 0; t < skip.size(); ++t) skip[t] = pieces.label[t] == l;
  return std::abs(windingNumber(mesh, p, skip)) > 0.5;
}

}  // namespace

void orientTriangles(Chain& chain, CloseReport& report) {
  const std::size_t n = chain.mesh.triangles.size();
  const std::vector<EdgeUse> all = edgeUses(chain.mesh.triangles);
  bool any = false;
  forEachEdge(all,
              [&](std::span<const EdgeUse> uses) { any = any || (joins(uses) && uses[0].forth == uses[1].forth); });
  if (!any) return;

  const Neighbours neighbours = facesAcross(n, all);
  std::vector<signed char> turn(n, -1);
  std::vector<std::uint32_t> patch;
  for (std::uint32_t seed = 0; seed < n; ++seed) {
    if (turn[seed] >= 0) continue;
    spread(seed, neighbours, turn, patch);
    std::size_t turned = 0;
    for (const std::uint32_t t : patch) turned += static_cast<std::size_t>(turn[t]);
    const signed char minority = 2 * turned <= patch.size() ? 1 : 0;
    for (const std::uint32_t t : patch)
      if (turn[t] == minority) {
        flip(chain.mesh.triangles[t]);
        ++report.triangles_flipped;
      }
  }

  if (report.triangles_flipped)
    report.changes.push_back(counted(report.triangles_flipped, "triangle was", "triangles were") +
                             " turned to agree with the neighbours");
}

Pieces piecesOf(std::size_t triangles, const std::vector<EdgeUse>& uses) {
  std::vector<std::uint32_t> parent(triangles);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto find = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  forEachEdge(uses, [&](std::span<const EdgeUse> edge) {
    for (std::size_t i = 1; i < edge.size(); ++i) {
      const std::uint32_t a = find(edge[0].triangle), b = find(edge[i].triangle);
      if (a != b) parent[std::max(a, b)] = std::min(a, b);
    }
  });
  Pieces pieces;
  pieces.label.resize(triangles);
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const std::uint32_t root = find(t);
    pieces.label[t] = root == t ? pieces.count++ : pieces.label[root];
  }
  return pieces;
}

bool turnPieces(Chain& chain, CloseReport& report) {
  Mesh& mesh = chain.mesh;
  const Pieces pieces = piecesOf(mesh.triangles.size(), edgeUses(mesh.triangles));
  const PieceSizes sizes = sizesOf(mesh, pieces);
  const BoxTree boxes(sizes.box);

  bool nested = false;
  std::vector<char> turn(pieces.count, 0);
  std::size_t turned = 0;
  std::optional<RayWinding> rays;
  for (std::uint32_t l = 0; l < pieces.count; ++l) {
    const bool inside_another = isHeld(boxes, l);
    nested = nested || inside_another;
    if (!(sizes.volume[l] < 0)) continue;
    if (inside_another && liesInOthers(mesh, pieces, l, sizes.biggest[l], rays)) continue;  // the wall of a cavity
    turn[l] = 1;
    ++turned;
  }

  for (std::uint32_t t = 0; turned && t < mesh.triangles.size(); ++t)
    if (turn[pieces.label[t]]) {
      flip(mesh.triangles[t]);
      ++report.triangles_flipped;
    }
  if (turned)
    report.changes.push_back(counted(turned, "closed piece was", "closed pieces were") + " inside out and turned");
  return nested;
}

}  // namespace kerf::internal
