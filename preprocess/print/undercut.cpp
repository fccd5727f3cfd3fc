#include "preprocess/print/undercut.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "geometry/mesh/box_tree.h"
#include "preprocess/print/columns.h"
#include "preprocess/voxelize/voxelize.h"

namespace kerf {
namespace {

using internal::ColumnGrid;
using Vec2d = Eigen::Vector2d;

constexpr float kNothing = -std::numeric_limits<float>::infinity();
constexpr double kTouch = 1e-4;    // mm: material less far above a place is the place itself
constexpr double kOnEdge = 1e-10;  // mm^2: rounding leaves no gap along a common edge
constexpr double kExact = 0.001;   // mm: of depths

Expected<void> check(const Vec3d& axis, const UndercutOptions& options) {
  KERF_CHECK(internal::checkAxis(axis, "insertion axis"));
  KERF_CHECK(checkVoxelSize(options.voxel_mm));
  if (!(options.most_mm > 0))
    return fail({.place = "most undercut", .found = fmt::format("{:g} mm", options.most_mm), .expected = "above 0"});
  if (options.above && !(options.above->normal.dot(axis) > 0.3))
    return fail({.place = "plane above which undercuts count",
                 .found = "a plane steeper than 70 degrees along the insertion axis",
                 .expected = "a normal that points out of the model"});
  return {};
}

// The top of the material along each line, and over blocks of 2^n x 2^n lines the lowest top.
class LowestTops {
 public:
  LowestTops(const ColumnGrid& grid, std::vector<float> tops) : grid_(grid) {
    levels_.push_back({grid.nx(), grid.ny(), std::move(tops)});
    while (levels_.back().nx > 1 || levels_.back().ny > 1) {
      const Level& fine = levels_.back();
      Level coarse{(fine.nx + 1) / 2, (fine.ny + 1) / 2, {}};
      coarse.lowest.assign(static_cast<std::size_t>(coarse.nx) * static_cast<std::size_t>(coarse.ny), -kNothing);
      for (int j = 0; j < fine.ny; ++j)
        for (int i = 0; i < fine.nx; ++i) {
          float& low = coarse.lowest[coarse.at(i / 2, j / 2)];
          low = std::min(low, fine.lowest[fine.at(i, j)]);
        }
      levels_.push_back(std::move(coarse));
    }
  }

  // The nearest line without material above z, and nearer than `most`.
  std::optional<Vec2d> nearestFree(const Vec2d& p, double z, double most) const {
    Search search{p, z, most * most, {}};
    visit(static_cast<int>(levels_.size()) - 1, 0, 0, search);
    return search.found;
  }

 private:
  struct Level {
    int nx, ny;
    std::vector<float> lowest;
    std::size_t at(int i, int j) const {
      return static_cast<std::size_t>(j) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(i);
    }
  };
  struct Search {
    Vec2d p;
    double z, best;  // squared
    std::optional<Vec2d> found;
  };

  // Squared distance to the lines of a block.
  double distance(int level, int i, int j, const Vec2d& p) const {
    const int side = 1 << level;
    const auto gap = [](double low, double high, double x) { return std::max({low - x, x - high, 0.0}); };
    const double dx = gap(grid_.lineX(i * side), grid_.lineX((i + 1) * side - 1), p[0]);
    const double dy = gap(grid_.lineY(j * side), grid_.lineY((j + 1) * side - 1), p[1]);
    return dx * dx + dy * dy;
  }

  void visit(int level, int i, int j, Search& search) const {
    const Level& l = levels_[static_cast<std::size_t>(level)];
    if (l.lowest[l.at(i, j)] > search.z) return;
    if (level == 0) {
      const double d = distance(0, i, j, search.p);
      if (d < search.best) search.best = d, search.found = Vec2d(grid_.lineX(i), grid_.lineY(j));
      return;
    }
    const Level& fine = levels_[static_cast<std::size_t>(level) - 1];
    std::array<std::pair<double, int>, 4> order;
    std::size_t count = 0;
    for (int n = 0; n < 4; ++n) {
      const int a = 2 * i + (n & 1), b = 2 * j + n / 2;
      if (a >= fine.nx || b >= fine.ny) continue;
      const double d = distance(level - 1, a, b, search.p);
      std::size_t k = count++;
      for (; k > 0 && order[k - 1].first > d; --k) order[k] = order[k - 1];
      order[k] = {d, n};
    }
    for (std::size_t k = 0; k < count && order[k].first < search.best; ++k)
      visit(level - 1, 2 * i + (order[k].second & 1), 2 * j + order[k].second / 2, search);
  }

  const ColumnGrid& grid_;
  std::vector<Level> levels_;
};

// The triangles, in the frame of the grid, for lines at any place.
class Cover {
 public:
  Cover(const Mesh& mesh, const ColumnGrid& grid) : mesh_(mesh), tree_(boxes(mesh, grid, points_)) {}

  const Vec3d& point(std::size_t v) const { return points_[v]; }

  // True if material lies above (p, z). Leaves out the triangles with a corner at `but`.
  bool isAbove(const Vec2d& p, double z, const Vec3d* but = nullptr) const {
    const auto may = [&](const Box3& b) {
      return b.max[2] > z && p[0] >= b.min[0] && p[0] <= b.max[0] && p[1] >= b.min[1] && p[1] <= b.max[1];
    };
    return !tree_.visit(may, [&](std::uint32_t t) {
      const Triangle& f = mesh_.triangles[t];
      const Vec3d &a = points_[f[0]], &b = points_[f[1]], &c = points_[f[2]];
      if (but && (a == *but || b == *but || c == *but)) return true;
      const auto side = [&p](const Vec3d& from, const Vec3d& to) {
        return (to[0] - from[0]) * (p[1] - from[1]) - (to[1] - from[1]) * (p[0] - from[0]);
      };
      const double u = side(b, c), v = side(c, a), w = side(a, b), area = u + v + w;
      if (area == 0 || (std::min({u, v, w}) < -kOnEdge && std::max({u, v, w}) > kOnEdge)) return true;
      const auto [low, high] = std::minmax({a[2], b[2], c[2]});
      return std::clamp((u * a[2] + v * b[2] + w * c[2]) / area, low, high) <= z + kTouch;
    });
  }

 private:
  static std::vector<Box3> boxes(const Mesh& mesh, const ColumnGrid& grid, std::vector<Vec3d>& points) {
    points.reserve(mesh.vertices.size());
    for (const Vec3d& p : mesh.vertices) points.push_back(grid.toFrame(p));
    std::vector<Box3> out(mesh.triangles.size());
    for (std::size_t t = 0; t < out.size(); ++t)
      for (const std::uint32_t v : mesh.triangles[t]) out[t].add(points[v]);
    return out;
  }

  const Mesh& mesh_;
  std::vector<Vec3d> points_;
  BoxTree tree_;
};

double depthAt(std::size_t v, const Cover& cover, const LowestTops& tops, double voxel, double most) {
  const Vec3d& at = cover.point(v);
  const Vec2d p = at.head<2>();
  if (!cover.isAbove(p, at[2], &at)) return 0;
  const auto free = tops.nearestFree(p, at[2], most);
  if (!free) return most;
  // The end of the shadow in a direction that is free at a distance.
  const auto outline = [&](const Vec2d& way, double open) {
    for (double covered = 0; open - covered > kExact / 2;) {
      const double middle = (covered + open) / 2;
      (cover.isAbove(p + middle * way, at[2]) ? covered : open) = middle;
    }
    return open;
  };
  const double far = (*free - p).norm();
  double angle = std::atan2((*free - p)[1], (*free - p)[0]);
  double depth = outline((*free - p) / far, far);
  // The nearest line lies in about the nearest direction: its distance is at most 1.5 voxels too large.
  for (double turn = std::min(0.8, std::sqrt(3 * voxel / std::max(depth, kExact))); depth * turn * turn > kExact;) {
    bool is_nearer = false;
    for (const double other : {angle - turn, angle + turn}) {
      const Vec2d way(std::cos(other), std::sin(other));
      if (depth <= kExact || cover.isAbove(p + (depth - kExact) * way, at[2])) continue;
      depth = outline(way, depth - kExact);
      angle = other;
      is_nearer = true;
      break;
    }
    if (!is_nearer) turn /= 2;
  }
  return depth;
}

// Directions about an axis: n of them at an angle.
Vec3d leaning(const Vec3d& axis, double angle, double round) {
  int least = 0;
  axis.cwiseAbs().minCoeff(&least);
  const Vec3d x = (Vec3d::Unit(least) - axis * axis[least]).normalized(), y = axis.cross(x);
  return (std::cos(angle) * axis + std::sin(angle) * (std::cos(round) * x + std::sin(round) * y)).normalized();
}

}  // namespace

Expected<std::vector<double>> undercutDepths(const Mesh& mesh, const Vec3d& axis, const UndercutOptions& options,
                                             const Progress& progress) {
  KERF_CHECK(check(axis, options));
  KERF_TRY(grid, ColumnGrid::around(mesh, axis, options.voxel_mm));
  std::vector<float> highest(grid.count(), kNothing);
  if (!grid.eachCrossing(mesh, partOf(progress, 0, 0.4), [&](std::size_t line, double z, bool) {
        highest[line] = std::max(highest[line], static_cast<float>(z));
      }))
    return cancelled();
  const LowestTops tops(grid, std::move(highest));
  if (!report(progress, 0.5, "undercuts")) return cancelled();
  const Cover cover(mesh, grid);
  std::vector<double> out(mesh.vertices.size());
  constexpr std::size_t kBlock = 4096;
  for (std::size_t begin = 0; begin < out.size(); begin += 16 * kBlock) {
    if (!report(progress, 0.5 + 0.5 * static_cast<double>(begin) / static_cast<double>(out.size()), "undercuts"))
      return cancelled();
    tbb::parallel_for(begin, std::min(out.size(), begin + 16 * kBlock), [&](std::size_t v) {
      if (!options.above || options.above->height(mesh.vertices[v]) > 0)
        out[v] = depthAt(v, cover, tops, options.voxel_mm, options.most_mm);
    });
  }
  return out;
}

Expected<double> undercutVolume(const Mesh& solid, const Vec3d& axis, const UndercutOptions& options,
                                const Progress& progress) {
  KERF_CHECK(check(axis, options));
  KERF_TRY(grid, ColumnGrid::around(solid, axis, options.voxel_mm));
  Plane ground{grid.fromFrame(Vec3d(0, 0, grid.box().min[2])), axis};
  if (options.above) ground = *options.above;
  // Height of the ground along line c: where height(place(c, z)) is 0.
  const double steep = ground.normal.dot(axis);
  struct Line {
    double top = -std::numeric_limits<double>::infinity(), filled = 0;
    int depth = 0;
  };
  std::vector<Line> lines(grid.count());
  const auto groundOf = [&](std::size_t c) { return -ground.height(grid.place(c, 0)) / steep; };
  if (!grid.eachCrossing(solid, progress, [&](std::size_t c, double z, bool enters) {
        Line& line = lines[c];
        line.top = std::max(line.top, z);
        line.filled += (enters ? -1 : 1) * std::max(z, groundOf(c));
        line.depth += enters ? 1 : -1;
      }))
    return cancelled();
  double sum = 0;
  for (std::size_t c = 0; c < lines.size(); ++c) {
    if (lines[c].depth != 0) return internal::openAt(grid, c, lines[c].top);
    if (const double low = groundOf(c); lines[c].top > low) sum += std::max(0.0, lines[c].top - low - lines[c].filled);
  }
  return sum * grid.voxel() * grid.voxel();
}

Expected<InsertionAxis> findInsertionAxis(const Mesh& solid, const Vec3d& start, const AxisOptions& options,
                                          const Progress& progress) {
  if (!(options.cone_deg > 0 && options.cone_deg <= 45))
    return fail({.place = "cone", .found = fmt::format("{:g} degrees", options.cone_deg), .expected = "0 to 45"});
  constexpr double kDegree = M_PI / 180;
  InsertionAxis out{.axis = start};
  KERF_TRY(at_start, undercutVolume(solid, start, options.undercut, partOf(progress, 0, 0.02)));
  out.undercut_mm3 = out.start_mm3 = at_start;
  out.tried = 1;
  const double slack = 1e-3 * at_start;

  // Takes the best of the directions within the cone; false: none is better. The error of one is that of all.
  const auto improve = [&](const std::vector<Vec3d>& from, double fraction) -> Expected<bool> {
    if (!report(progress, fraction, "insertion axis")) return cancelled();
    std::vector<Vec3d> ways;
    for (const Vec3d& way : from)
      if (way.dot(start) >= std::cos(options.cone_deg * kDegree) - 1e-9) ways.push_back(way);
    std::vector<Expected<double>> volumes(ways.size(), 0.0);
    tbb::parallel_for(std::size_t{0}, ways.size(),
                      [&](std::size_t n) { volumes[n] = undercutVolume(solid, ways[n], options.undercut); });
    out.tried += ways.size();
    bool is_better = false;
    for (std::size_t n = 0; n < ways.size(); ++n) {
      KERF_TRY(volume, volumes[n]);
      if (volume < out.undercut_mm3 - slack) out.undercut_mm3 = volume, out.axis = ways[n], is_better = true;
    }
    return is_better;
  };

  double step = std::min(5.0, options.cone_deg) * kDegree;
  const int rings = static_cast<int>(options.cone_deg * kDegree / step + 1e-9);
  for (int ring = 1; ring <= rings; ++ring) {
    std::vector<Vec3d> ways;
    for (int n = 0; n < 6 * ring; ++n) ways.push_back(leaning(start, ring * step, 2 * M_PI * n / (6 * ring)));
    KERF_CHECK(improve(ways, 0.02 + 0.6 * ring / (rings + 1)));
  }
  for (step /= 2; step > 0.5 * kDegree; step /= 2)
    for (int round = 0; round < 8; ++round) {
      std::vector<Vec3d> ways;
      for (int n = 0; n < 6; ++n) ways.push_back(leaning(out.axis, step, 2 * M_PI * n / 6));
      KERF_TRY(is_better, improve(ways, 0.7));
      if (!is_better) break;
    }
  return out;
}

}  // namespace kerf
