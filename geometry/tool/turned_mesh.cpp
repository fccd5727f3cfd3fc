#include "geometry/tool/turned_mesh.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace kerf {
namespace {

using Point = RevolvedProfile::Point;

constexpr double kSpacing = 0.002;  // mm, of the levels
constexpr int kMostLevels = 16384, kLevelsPerBlock = 64;
constexpr double kTolerance = 0.001;  // mm, of the simplified outline
constexpr double kNearlyConvex = 0.003;
constexpr double kLeastHollow = 0.02;
constexpr double kLeastGap = 0.001;

struct Segment {
  Eigen::Vector2d from, to;
};

struct Level {
  double outer = 0, inner = 0, area = 0;
  bool has_second_ring = false;
};

// The section of one triangle; the lower side of the plane has z < height, so that sections close.
std::optional<Segment> sectionOf(const Mesh& mesh, std::size_t t, double height) {
  Segment out;
  int found = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3d a = mesh.corner(t, k), b = mesh.corner(t, (k + 1) % 3);
    if ((a[2] < height) == (b[2] < height)) continue;
    // From the lower end, so that the neighbour finds the same point.
    const Vec3d &low = a[2] < b[2] ? a : b, &high = a[2] < b[2] ? b : a;
    const Vec3d p = low + (height - low[2]) / (high[2] - low[2]) * (high - low);
    (a[2] < height ? out.from : out.to) = p.head<2>();
    ++found;
  }
  if (found != 2) return std::nullopt;
  return out;
}

double distanceFromAxis(const Segment& s) {
  const Eigen::Vector2d e = s.to - s.from;
  const double length = e.squaredNorm(), t = length > 0 ? std::clamp(-s.from.dot(e) / length, 0.0, 1.0) : 0.0;
  return (s.from + t * e).norm();
}

bool isInside(const std::vector<Segment>& section, double radius) {
  bool inside = false;
  for (const Segment& s : section) {
    if ((s.from[1] < 0) == (s.to[1] < 0)) continue;
    const double x = s.from[0] + s.from[1] / (s.from[1] - s.to[1]) * (s.to[0] - s.from[0]);
    inside ^= x > radius;
  }
  return inside;
}

Level levelOf(const std::vector<Segment>& section) {
  Level out;
  std::vector<std::pair<double, double>> radii;
  for (const Segment& s : section) {
    radii.emplace_back(distanceFromAxis(s), std::max(s.from.norm(), s.to.norm()));
    out.area += 0.5 * (s.from[0] * s.to[1] - s.from[1] * s.to[0]);
  }
  out.area = std::abs(out.area);
  if (radii.empty()) return out;
  std::sort(radii.begin(), radii.end());
  if (radii.front().first > kLeastHollow && !isInside(section, 0)) out.inner = radii.front().first;
  // Where no radius meets the surface, a whole circle is inside or outside.
  out.outer = radii.front().second;
  for (const auto& [least, most] : radii) {
    if (least > out.outer + kLeastGap && !isInside(section, 0.5 * (least + out.outer))) out.has_second_ring = true;
    out.outer = std::max(out.outer, most);
  }
  return out;
}

std::vector<Level> levelsOf(const Mesh& mesh, double low, double step, int count) {
  // Triangles of every block of levels.
  const int blocks = (count + kLevelsPerBlock - 1) / kLevelsPerBlock;
  const double block_height = kLevelsPerBlock * step;
  std::vector<std::vector<std::uint32_t>> of_block(static_cast<std::size_t>(blocks));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double a = mesh.corner(t, 0)[2], b = mesh.corner(t, 1)[2], c = mesh.corner(t, 2)[2];
    const double first = (std::min({a, b, c}) - low) / block_height, last = (std::max({a, b, c}) - low) / block_height;
    if (last < 0 || first > blocks) continue;
    for (int n = static_cast<int>(std::max(0.0, first)); n <= std::min(last, blocks - 1.0); ++n)
      of_block[static_cast<std::size_t>(n)].push_back(static_cast<std::uint32_t>(t));
  }

  std::vector<Level> levels(static_cast<std::size_t>(count));
  tbb::parallel_for(0, blocks, [&](int block) {
    std::vector<Segment> section;
    for (int k = block * kLevelsPerBlock; k < std::min(count, (block + 1) * kLevelsPerBlock); ++k) {
      section.clear();
      for (const std::uint32_t t : of_block[static_cast<std::size_t>(block)])
        if (const auto segment = sectionOf(mesh, t, low + (k + 0.5) * step)) section.push_back(*segment);
      levels[static_cast<std::size_t>(k)] = levelOf(section);
    }
  });

  // Corners between two levels: rims, level faces. Those at an end where the mesh goes on may belong to the other side.
  const double high = low + count * step;
  Box3 all;
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) all.add(mesh.vertices[v]);
  const double from = all.min[2] < low - kSpacing ? low + kSpacing : all.min[2];
  const double to = all.max[2] > high + kSpacing ? high - kSpacing : all.max[2];
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) {
      const Vec3d& p = mesh.vertices[v];
      if (p[2] < from || p[2] > to) continue;
      const double k = std::clamp(std::floor((p[2] - low) / step), 0.0, count - 1.0);
      Level& level = levels[static_cast<std::size_t>(k)];
      level.outer = std::max(level.outer, p.head<2>().norm());
    }
  return levels;
}

// Douglas & Peucker 1973.
std::vector<Point> simplified(const std::vector<Point>& points) {
  std::vector<char> is_kept(points.size(), 0);
  is_kept.front() = is_kept.back() = 1;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, points.size() - 1}};
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    const Point along = (points[last] - points[first]).normalized();
    double most = kTolerance;
    std::size_t at = first;
    for (std::size_t n = first + 1; n < last; ++n) {
      const Point d = points[n] - points[first];
      if (const double off = std::abs(along[0] * d[1] - along[1] * d[0]); off > most) {
        most = off;
        at = n;
      }
    }
    if (at == first) continue;
    is_kept[at] = 1;
    open.emplace_back(first, at);
    open.emplace_back(at, last);
  }
  std::vector<Point> out;
  for (std::size_t n = 0; n < points.size(); ++n)
    if (is_kept[n]) out.push_back(points[n]);
  return out;
}

// The corners that no chord passes outside of.
std::vector<Point> hullOf(const std::vector<Point>& points) {
  std::vector<Point> hull;
  for (const Point& p : points) {
    while (hull.size() >= 2) {
      const Point a = hull.back() - hull[hull.size() - 2], b = p - hull.back();
      if (a[0] * b[1] - a[1] * b[0] > 0) break;
      hull.pop_back();
    }
    hull.push_back(p);
  }
  return hull;
}

bool isNearlyConvex(const std::vector<Point>& points, const std::vector<Point>& hull) {
  std::size_t n = 0;
  for (const Point& p : points) {
    while (n + 2 < hull.size() && hull[n + 1][1] < p[1]) ++n;
    const Point along = (hull[n + 1] - hull[n]).normalized(), d = p - hull[n];
    if (along[0] * d[1] - along[1] * d[0] > kNearlyConvex) return false;
  }
  return true;
}

// @param radii  (radius, height), heights never decrease, at least two.
RevolvedProfile profileOf(const std::vector<Point>& radii) {
  const std::vector<Point> hull = hullOf(radii);
  RevolvedProfile out(radii.front()[1]);
  for (const Point& p : simplified(isNearlyConvex(radii, hull) ? hull : radii)) out.lineTo(p[0], p[1]);
  return out.close();
}

// Distance to an outline of lines in the half-plane. Tens of short lines: only those near the height are looked at.
class TurnedOutline {
 public:
  explicit TurnedOutline(const RevolvedProfile& profile) : low_(profile.lowest()), high_(profile.highest()) {
    for (const RevolvedProfile::Piece& piece : profile.pieces()) {
      const Point along = piece.to - piece.from;
      lines_.push_back({piece.from, along, 1 / along.squaredNorm()});
    }
    per_mm_ = kBins / (high_ - low_);
    std::size_t line = 0;
    for (int bin = 0; bin < kBins; ++bin) {
      while (line + 1 < lines_.size() && lines_[line].top() < low_ + bin / per_mm_) ++line;
      first_.push_back(static_cast<std::uint32_t>(line));
    }
  }

  double distance(double radius, double height) const noexcept {
    const int bin = static_cast<int>(std::clamp((height - low_) * per_mm_, 0.0, kBins - 1.0));
    std::size_t here = first_[static_cast<std::size_t>(bin)];
    while (here + 1 < lines_.size() && (lines_[here].top() < height || lines_[here].along[1] == 0)) ++here;

    const Point p(radius, height);
    double nearest = lines_[here].squaredDistance(p);
    for (std::size_t n = here + 1; n < lines_.size(); ++n) {
      const double rise = lines_[n].from[1] - height;
      if (rise > 0 && rise * rise >= nearest) break;
      nearest = std::min(nearest, lines_[n].squaredDistance(p));
    }
    for (std::size_t n = here; n-- > 0;) {
      const double rise = height - lines_[n].top();
      if (rise > 0 && rise * rise >= nearest) break;
      nearest = std::min(nearest, lines_[n].squaredDistance(p));
    }

    const Line& line = lines_[here];
    const bool is_inside = height > low_ && height < high_ && line.along[1] > 0 &&
                           radius < line.from[0] + (height - line.from[1]) / line.along[1] * line.along[0];
    return is_inside ? -std::sqrt(nearest) : std::sqrt(nearest);
  }

 private:
  struct Line {
    Point from, along;
    double inverse;
    double top() const noexcept { return from[1] + along[1]; }
    double squaredDistance(const Point& p) const noexcept {
      if (from[0] == 0 && along[0] == 0) return std::numeric_limits<double>::infinity();  // the axis: no surface
      const Point d = p - from;
      return (d - std::clamp(d.dot(along) * inverse, 0.0, 1.0) * along).squaredNorm();
    }
  };
  static constexpr int kBins = 256;
  double low_, high_, per_mm_ = 0;
  std::vector<Line> lines_;  // heights never decrease
  std::vector<std::uint32_t> first_;
};

class TurnedShape final : public ToolShape {
 public:
  explicit TurnedShape(const TurnedMesh& turned)
      : outside_(turned.outline), is_convex_(turned.hollows.empty() && turned.outline.isConvex()) {
    for (const RevolvedProfile& hollow : turned.hollows) hollows_.emplace_back(hollow);
    const double radius = turned.outline.largestRadius();
    box_.add(Vec3d(-radius, -radius, turned.outline.lowest()));
    box_.add(Vec3d(radius, radius, turned.outline.highest()));
  }
  double distance(const Vec3d& p) const noexcept override {
    const double radius = p.head<2>().norm();
    double out = outside_.distance(radius, p[2]);
    for (const TurnedOutline& hollow : hollows_) out = std::max(out, -hollow.distance(radius, p[2]));
    return out;
  }
  Box3 bounds() const override { return box_; }
  bool isConvex() const override { return is_convex_; }
  Symmetry symmetry() const override { return Symmetry::kRevolved; }

 private:
  TurnedOutline outside_;
  std::vector<TurnedOutline> hollows_;
  bool is_convex_;
  Box3 box_;
};

}  // namespace

TurnedMesh turnedMesh(const Mesh& mesh, double low, double high) {
  assert(low < high);
  const int count = std::clamp(static_cast<int>(std::ceil((high - low) / kSpacing)), 16, kMostLevels);
  const double step = (high - low) / count;
  const std::vector<Level> levels = levelsOf(mesh, low, step, count);

  TurnedMesh out;
  std::vector<Point> outer{{levels.front().outer, low}};
  for (int k = 0; k < count; ++k) {
    const Level& level = levels[static_cast<std::size_t>(k)];
    const double height = low + (k + 0.5) * step;
    if (level.has_second_ring && !out.second_ring_at) out.second_ring_at = height;
    outer.emplace_back(level.outer, height);
    out.mesh_volume_mm3 += step * level.area;
    out.volume_mm3 += step * std::numbers::pi * (level.outer * level.outer - level.inner * level.inner);
  }
  outer.emplace_back(levels.back().outer, high);
  out.outline = profileOf(outer);

  // A hollow that is open at an end goes on beyond it: no wall is there.
  const double beyond = 2 * out.outline.largestRadius();
  for (int k = 0; k < count;) {
    if (levels[static_cast<std::size_t>(k)].inner == 0) {
      ++k;
      continue;
    }
    const double begins = k == 0 ? low - beyond : low + k * step;
    std::vector<Point> radii{{levels[static_cast<std::size_t>(k)].inner, begins}};
    for (; k < count && levels[static_cast<std::size_t>(k)].inner > 0; ++k)
      radii.emplace_back(levels[static_cast<std::size_t>(k)].inner, low + (k + 0.5) * step);
    radii.emplace_back(radii.back()[0], k == count ? high + beyond : low + k * step);
    out.hollows.push_back(profileOf(radii));
  }
  return out;
}

std::shared_ptr<const ToolShape> shapeOf(const TurnedMesh& turned) {
  return std::make_shared<const TurnedShape>(turned);
}

}  // namespace kerf
