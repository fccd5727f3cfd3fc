#include "geometry/field/marching_cubes.h"

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

// The brick with an apron as its neighbours have it, and the nodes of its cells, corrected and snapped.
constexpr int kCellSpan = kBrickSide + 1, kRawSpan = kBrickSide + 3;
struct Patch {
  std::array<float, kRawSpan * kRawSpan * kRawSpan> raw;   // nodes -1 to 9
  std::array<float, kCellSpan * kCellSpan * kCellSpan> v;  // nodes 0 to 8

  static constexpr std::size_t rawIndex(int i, int j, int k) {
    return static_cast<std::size_t>(((i + 1) * kRawSpan + j + 1) * kRawSpan + k + 1);
  }
  static constexpr std::size_t index(int i, int j, int k) {
    return static_cast<std::size_t>((i * kCellSpan + j) * kCellSpan + k);
  }
  float at(int i, int j, int k) const { return v[index(i, j, k)]; }
  // Gradient of the raw field at a node by central differences, times twice the voxel.
  Vec3f gradient(int i, int j, int k) const {
    const std::size_t c = rawIndex(i, j, k);
    return {raw[c + kRawSpan * kRawSpan] - raw[c - kRawSpan * kRawSpan], raw[c + kRawSpan] - raw[c - kRawSpan],
            raw[c + 1] - raw[c - 1]};
  }
};

// False where the surface cannot pass through the brick's cells.
bool gather(const BrickNeighbours& field, const MarchingCubesOptions& options, Patch& patch) {
  std::size_t out = 0;
  for (int i = -1; i < kBrickSide + 2; ++i)
    for (int j = -1; j < kBrickSide + 2; ++j)
      for (int block = 0; block < 3; ++block) {
        const auto n = static_cast<std::size_t>((((i >> 3) + 1) * 3 + (j >> 3) + 1) * 3 + block);
        const int first = block == 0 ? kBrickSide - 1 : 0, count = block == 0 ? 1 : block == 1 ? kBrickSide : 2;
        float* const to = patch.raw.data() + out;
        if (field.values[n])
          std::copy_n(field.values[n]->data() + nodeOffset(i, j, first), count, to);
        else
          std::fill_n(to, count, field.constant[n]);
        out += static_cast<std::size_t>(count);
      }

  const auto snap = static_cast<float>(options.snap_voxels * field.voxel);
  const auto near = static_cast<float>(1.8 * field.voxel);  // no edge that crosses zero ends farther away

  // Values of one sign that are all too far from zero to be corrected: the usual case, found fast.
  float low = patch.raw[0], high = patch.raw[0];
  for (const float v : patch.raw) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
  if (low >= near || high <= -near) return false;

  out = 0;
  for (int i = 0; i < kCellSpan; ++i)
    for (int j = 0; j < kCellSpan; ++j)
      for (int k = 0; k < kCellSpan; ++k) {
        const std::size_t at = Patch::rawIndex(i, j, k);
        const auto& raw = patch.raw;
        float v = raw[at];
        if (std::abs(v) < near) {
          const float l = raw[at - 1], r = raw[at + 1], d = raw[at - kRawSpan], u = raw[at + kRawSpan],
                      b = raw[at - kRawSpan * kRawSpan], f = raw[at + kRawSpan * kRawSpan];
          if (std::max({std::abs(l), std::abs(r), std::abs(d), std::abs(u), std::abs(b), std::abs(f)}) < field.clamped)
            v -= options.chord_balance * (l + r + d + u + b + f - 6 * v);
          if (std::abs(v) < snap) v = v < 0 ? -snap : snap;
        }
        patch.v[out++] = v;
      }
  return true;
}

Vec3f unitOr(const Vec3f& v, const Vec3f& otherwise) {
  const float length = v.norm();
  return length > 1e-12f ? Vec3f(v / length) : otherwise;
}

}  // namespace

void marchingCubesOfBrick(const BrickNeighbours& field, const MarchingCubesOptions& options, bool with_normals,
                          BrickSurface& out) {
  out.names.clear();
  out.positions.clear();
  out.normals.clear();
  out.triangles.clear();
  Patch patch;
  if (!gather(field, options, patch)) return;

  const Vec3i base = field.brick * kBrickSide;
  const double h = field.voxel, margin = std::min(0.49, options.snap_voxels);

  // Vertices made so far, by lower node and axis of their edge.
  constexpr std::uint16_t kNone = 0xffff;
  std::array<std::uint16_t, 3 * kCellSpan * kCellSpan * kCellSpan> made;
  made.fill(kNone);
  const auto edgeVertex = [&](const Vec3i& n, int axis) -> std::uint32_t {
    std::uint16_t& slot = made[3 * Patch::index(n[0], n[1], n[2]) + static_cast<std::size_t>(axis)];
    if (slot != kNone) return slot;
    const Vec3i d = Vec3i::Unit(axis), m = n + d;
    const double a = patch.at(n[0], n[1], n[2]), b = patch.at(m[0], m[1], m[2]);

    // Stay off the nodes: a vertex on a node would be shared by up to six edges and collapse triangles.
    const double t = std::clamp(a / (a - b), margin, 1 - margin);

    slot = static_cast<std::uint16_t>(out.positions.size());
    out.names.push_back({coordKey(Vec3i(base + n)), static_cast<std::uint32_t>(axis)});
    out.positions.push_back(h * ((base + n).cast<double>() + t * d.cast<double>()));
    if (with_normals) {
      const auto s = static_cast<float>(t);
      // A plate thinner than two voxels may have no gradient: then the edge gives the outward direction.
      out.normals.push_back(unitOr((1 - s) * patch.gradient(n[0], n[1], n[2]) + s * patch.gradient(m[0], m[1], m[2]),
                                   (a < 0 ? 1.0f : -1.0f) * d.cast<float>()));
    }
    return slot;
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
          std::array<std::uint32_t, 12> corner;
          for (std::size_t c = 0; c < length; ++c) {
            const Edge& edge = kEdges[static_cast<std::size_t>(which.edges[first + c])];
            corner[c] =
                edgeVertex({i + (edge.from & 1), j + (edge.from >> 1 & 1), k + (edge.from >> 2 & 1)}, edge.axis);
          }

          if (length < 6) {
            for (std::size_t c = 2; c < length; ++c) out.triangles.push_back({corner[0], corner[c], corner[c - 1]});
          } else {
            Vec3d center = Vec3d::Zero();
            for (std::size_t c = 0; c < length; ++c) center += out.positions[corner[c]];
            const auto middle = static_cast<std::uint32_t>(out.positions.size());
            out.names.push_back({coordKey(Vec3i(base + Vec3i{i, j, k})), 3u + static_cast<std::uint32_t>(loop)});
            out.positions.push_back(center / static_cast<double>(length));
            if (with_normals) {
              Vec3f sum = Vec3f::Zero();
              for (std::size_t c = 0; c < length; ++c) sum += out.normals[corner[c]];
              out.normals.push_back(unitOr(sum, out.normals[corner[0]]));
            }
            for (std::size_t c = 0; c < length; ++c)
              out.triangles.push_back({middle, corner[(c + 1) % length], corner[c]});
          }
          first += length;
        }
      }
}

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
    marchingCubesOfBrick(neighboursOf(field, {c[0], c[1], c[2]}), options, false, surfaces[b]);
  });

  // Vertices on the rim of a brick are made by each brick that shares them: equal names carry equal positions, so they
  // fall together when sorted.
  struct Named {
    BrickSurface::Name name;
    Vec3d position;
  };
  std::size_t vertices = 0, triangles = 0;
  for (const BrickSurface& s : surfaces) {
    vertices += s.names.size();
    triangles += s.triangles.size();
  }

  std::vector<Named> named;
  named.reserve(vertices);
  for (const BrickSurface& s : surfaces)
    for (std::size_t v = 0; v < s.names.size(); ++v) named.push_back({s.names[v], s.positions[v]});

  tbb::parallel_sort(named.begin(), named.end(), [](const Named& a, const Named& b) { return a.name < b.name; });
  named.erase(std::unique(named.begin(), named.end(), [](const Named& a, const Named& b) { return a.name == b.name; }),
              named.end());

  Mesh mesh;
  mesh.vertices.reserve(named.size());
  for (const Named& v : named) mesh.vertices.push_back(v.position);
  mesh.triangles.resize(triangles);

  std::vector<std::size_t> start(surfaces.size() + 1, 0);
  for (std::size_t b = 0; b < surfaces.size(); ++b) start[b + 1] = start[b] + surfaces[b].triangles.size();
  tbb::parallel_for(std::size_t{0}, surfaces.size(), [&](std::size_t b) {
    const BrickSurface& s = surfaces[b];
    std::vector<std::uint32_t> in_mesh(s.names.size());
    for (std::size_t v = 0; v < s.names.size(); ++v)
      in_mesh[v] = static_cast<std::uint32_t>(
          std::lower_bound(named.begin(), named.end(), s.names[v],
                           [](const Named& a, const BrickSurface::Name& n) { return a.name < n; }) -
          named.begin());
    for (std::size_t t = 0; t < s.triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) mesh.triangles[start[b] + t][k] = in_mesh[s.triangles[t][k]];
  });
  return mesh;
}

}  // namespace kerf
