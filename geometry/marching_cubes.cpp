#include "geometry/marching_cubes.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

// Corner c of a cell stands at (c & 1, c >> 1 & 1, c >> 2 & 1). Edges: 4 along each axis, named by axis and first
// corner.
struct Edge {
  int from, axis;  // from the corner with a 0 on `axis` to the one with a 1
};
constexpr std::array<Edge, 12> kEdges{
    {{0, 0}, {2, 0}, {4, 0}, {6, 0}, {0, 1}, {1, 1}, {4, 1}, {5, 1}, {0, 2}, {1, 2}, {2, 2}, {3, 2}}};
// Faces as corner cycles, counter-clockwise seen from outside the cell.
constexpr std::array<std::array<int, 4>, 6> kFaces{
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

constexpr int edgeBetween(int a, int b) {
  const int low = a < b ? a : b, diff = a ^ b, axis = diff == 1 ? 0 : diff == 2 ? 1 : 2;
  for (int e = 0; e < 12; ++e)
    if (kEdges[static_cast<std::size_t>(e)].from == low && kEdges[static_cast<std::size_t>(e)].axis == axis) return e;
  return -1;
}

struct Case {
  int loops = 0;
  std::array<int, 4> length{};
  std::array<int, 12> edges{};  // the loops one after the other
};

// On every face a run of negative corners (going round counter-clockwise) is cut off by one segment, directed from the
// edge where the run ends to the edge where it began. Each crossed edge ends a run on one of its two faces and begins
// one on the other, so the segments chain up to closed loops.
constexpr std::array<Case, 256> makeTable() {
  std::array<Case, 256> table{};
  for (int bits = 0; bits < 256; ++bits) {
    std::array<int, 12> next{};
    next.fill(-1);
    const auto negative = [bits](int corner) { return (bits >> corner & 1) != 0; };
    for (const auto& face : kFaces)
      for (std::size_t k = 0; k < 4; ++k)
        if (negative(face[k]) && !negative(face[(k + 1) % 4])) {  // a run ends after corner k: walk back to its begin
          std::size_t first = k;
          while (negative(face[(first + 3) % 4])) first = (first + 3) % 4;
          next[static_cast<std::size_t>(edgeBetween(face[k], face[(k + 1) % 4]))] =
              edgeBetween(face[(first + 3) % 4], face[first]);
        }
    Case& c = table[static_cast<std::size_t>(bits)];
    int filled = 0;
    for (int e = 0; e < 12; ++e) {
      if (next[static_cast<std::size_t>(e)] < 0) continue;
      const int start = filled;
      for (int at = e; next[static_cast<std::size_t>(at)] >= 0;) {
        c.edges[static_cast<std::size_t>(filled++)] = at;
        const int to = next[static_cast<std::size_t>(at)];
        next[static_cast<std::size_t>(at)] = -1;
        at = to;
      }
      c.length[static_cast<std::size_t>(c.loops++)] = filled - start;
    }
  }
  return table;
}
constexpr std::array<Case, 256> kTable = makeTable();

// A vertex is named by what it stands on: a grid edge (node, axis 0..2) or the centroid of a loop of a cell (node, 3 +
// loop).
struct Name {
  std::uint64_t node;
  std::uint32_t what;
  bool operator<(const Name& o) const { return node != o.node ? node < o.node : what < o.what; }
  bool operator==(const Name& o) const { return node == o.node && what == o.what; }
};

struct NamedVertex {
  Name name;
  Vec3d position;
};
struct NamedTriangle {
  std::array<Name, 3> corner;
};
struct BrickSurface {
  std::vector<NamedVertex> vertices;
  std::vector<NamedTriangle> triangles;
};

// The brick with the nodes its cells need beyond it, corrected and snapped; gathered from an apron one node wider
// still.
constexpr int kCellSpan = kBrickSide + 1, kRawSpan = kBrickSide + 3;
struct Patch {
  std::array<float, kCellSpan * kCellSpan * kCellSpan> v;
  float at(int i, int j, int k) const { return v[static_cast<std::size_t>((i * kCellSpan + j) * kCellSpan + k)]; }
};

void gather(const BrickField& field, const Vec3i& brick, const MarchingCubesOptions& options, Patch& patch) {
  int found[27];
  float constant[27];
  for (int n = 0; n < 27; ++n) {
    const Vec3i c = brick + Vec3i{n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1};
    found[n] = field.find(c);
    constant[n] = found[n] < 0 ? field.constantAt(c) : 0;
  }
  std::array<float, kRawSpan * kRawSpan * kRawSpan> raw;
  std::size_t out = 0;
  for (int i = -1; i < kBrickSide + 2; ++i)
    for (int j = -1; j < kBrickSide + 2; ++j)
      for (int k = -1; k < kBrickSide + 2; ++k) {
        const int n = (((i >> 3) + 1) * 3 + (j >> 3) + 1) * 3 + (k >> 3) + 1;
        raw[out++] =
            found[n] < 0
                ? constant[n]
                : field.brick(static_cast<std::size_t>(found[n]))[static_cast<std::size_t>(nodeOffset(i, j, k))];
      }
  const auto snap = static_cast<float>(options.snap_voxels * field.voxel());
  const auto near = static_cast<float>(1.8 * field.voxel());  // no edge that crosses zero ends farther away
  const float clamped = std::min(field.background(), -field.interior());
  out = 0;
  for (int i = 0; i < kCellSpan; ++i)
    for (int j = 0; j < kCellSpan; ++j)
      for (int k = 0; k < kCellSpan; ++k) {
        const std::size_t at = static_cast<std::size_t>(((i + 1) * kRawSpan + j + 1) * kRawSpan + k + 1);
        float v = raw[at];
        if (std::abs(v) < near) {
          const float l = raw[at - 1], r = raw[at + 1], d = raw[at - kRawSpan], u = raw[at + kRawSpan],
                      b = raw[at - kRawSpan * kRawSpan], f = raw[at + kRawSpan * kRawSpan];
          if (std::max({std::abs(l), std::abs(r), std::abs(d), std::abs(u), std::abs(b), std::abs(f)}) < clamped)
            v -= options.chord_balance * (l + r + d + u + b + f - 6 * v);
          if (std::abs(v) < snap) v = v < 0 ? -snap : snap;
        }
        patch.v[out++] = v;
      }
}

BrickSurface extract(const BrickField& field, const Vec3i& brick, const MarchingCubesOptions& options) {
  BrickSurface out;
  Patch patch;
  gather(field, brick, options, patch);
  const Vec3i base = brick * kBrickSide;
  const double h = field.voxel(), margin = std::min(0.49, options.snap_voxels);

  const auto edgePoint = [&](const Vec3i& n, int axis) {
    const Vec3i d = Vec3i::Unit(axis), m = n + d;
    const double a = patch.at(n[0], n[1], n[2]), b = patch.at(m[0], m[1], m[2]);
    // Stay off the nodes: a vertex on a node would be shared by up to six edges and collapse triangles.
    const double t = std::clamp(a / (a - b), margin, 1 - margin);
    return Vec3d(h * ((base + n).cast<double>() + t * d.cast<double>()));
  };

  for (int i = 0; i < kBrickSide; ++i)
    for (int j = 0; j < kBrickSide; ++j)
      for (int k = 0; k < kBrickSide; ++k) {
        int bits = 0;
        for (int c = 0; c < 8; ++c)
          bits |= (patch.at(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1)) < 0 ? 1 : 0) << c;
        if (bits == 0 || bits == 255) continue;
        const Case& which = kTable[static_cast<std::size_t>(bits)];
        std::size_t first = 0;
        for (int loop = 0; loop < which.loops; ++loop) {
          const auto length = static_cast<std::size_t>(which.length[static_cast<std::size_t>(loop)]);
          std::array<Name, 12> name;
          std::array<Vec3d, 12> point;
          for (std::size_t c = 0; c < length; ++c) {
            const Edge& edge = kEdges[static_cast<std::size_t>(which.edges[first + c])];
            const Vec3i n{i + (edge.from & 1), j + (edge.from >> 1 & 1), k + (edge.from >> 2 & 1)};
            name[c] = {coordKey(Vec3i(base + n)), static_cast<std::uint32_t>(edge.axis)};
            point[c] = edgePoint(n, edge.axis);
            // Every edge point is made by the one cell that starts at its node, or by the cell on the rim of the stored
            // bricks; equal names carry equal positions, so duplicates fall together when names are sorted.
            out.vertices.push_back({name[c], point[c]});
          }
          if (length < 6) {
            for (std::size_t c = 2; c < length; ++c) out.triangles.push_back({{name[0], name[c], name[c - 1]}});
          } else {
            Vec3d center = Vec3d::Zero();
            for (std::size_t c = 0; c < length; ++c) center += point[c];
            const Name middle{coordKey(Vec3i(base + Vec3i{i, j, k})), 3u + static_cast<std::uint32_t>(loop)};
            out.vertices.push_back({middle, center / static_cast<double>(length)});
            for (std::size_t c = 0; c < length; ++c)
              out.triangles.push_back({{middle, name[(c + 1) % length], name[c]}});
          }
          first += length;
        }
      }
  return out;
}

}  // namespace

Mesh marchingCubes(const BrickField& field, const MarchingCubesOptions& options) {
  // A cell belongs to the brick of its lowest corner, which may be a missing brick below a stored one.
  std::vector<std::uint64_t> keys;
  keys.reserve(8 * field.brickCount());
  for (std::size_t b = 0; b < field.brickCount(); ++b)
    for (int n = 0; n < 8; ++n) keys.push_back(coordKey(Vec3i(field.brickCoord(b) - Vec3i{n >> 2, n >> 1 & 1, n & 1})));
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());

  std::vector<BrickSurface> surfaces(keys.size());
  tbb::parallel_for(std::size_t{0}, keys.size(), [&](std::size_t b) {
    const auto c = coordOfKey(keys[b]);
    surfaces[b] = extract(field, {c[0], c[1], c[2]}, options);
  });

  std::size_t vertex_uses = 0, triangles = 0;
  for (const BrickSurface& s : surfaces) vertex_uses += s.vertices.size(), triangles += s.triangles.size();
  std::vector<NamedVertex> named;
  named.reserve(vertex_uses);
  for (const BrickSurface& s : surfaces) named.insert(named.end(), s.vertices.begin(), s.vertices.end());
  tbb::parallel_sort(named.begin(), named.end(),
                     [](const NamedVertex& a, const NamedVertex& b) { return a.name < b.name; });
  named.erase(std::unique(named.begin(), named.end(),
                          [](const NamedVertex& a, const NamedVertex& b) { return a.name == b.name; }),
              named.end());

  Mesh mesh;
  mesh.vertices.reserve(named.size());
  for (const NamedVertex& v : named) mesh.vertices.push_back(v.position);
  mesh.triangles.resize(triangles);
  std::vector<std::size_t> start(surfaces.size() + 1, 0);
  for (std::size_t b = 0; b < surfaces.size(); ++b) start[b + 1] = start[b] + surfaces[b].triangles.size();
  tbb::parallel_for(std::size_t{0}, surfaces.size(), [&](std::size_t b) {
    for (std::size_t t = 0; t < surfaces[b].triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const Name& wanted = surfaces[b].triangles[t].corner[k];
        const auto it = std::lower_bound(named.begin(), named.end(), wanted,
                                         [](const NamedVertex& v, const Name& n) { return v.name < n; });
        mesh.triangles[start[b] + t][k] = static_cast<std::uint32_t>(it - named.begin());
      }
  });
  return mesh;
}

}  // namespace kerf
