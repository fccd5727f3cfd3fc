#include "ui/app/saw/saw_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

namespace kerf {
namespace {

constexpr double kCell = SawnSection::kCell;
constexpr double kLooked = 70;         // mm: search range of a section around the point, wider than an arch
constexpr double kNear = 8;            // mm from the point to the bone, at most
constexpr double kBefore = 0.5;        // mm outside the bone: start of a rectangle
constexpr double kBehind = 1;          // mm behind the bone: its end
constexpr double kAboveSection = 0.3;  // mm above the bone a pass begins slowly
constexpr double kBeside = 12;         // mm: margin of a rectangle for unplanned sawing
constexpr double kTouches = 0.06;      // mm from the teeth: counts as sawn
constexpr int kDirections = 72;        // tried for an approach

struct Extent {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void add(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
  double size() const { return high - low; }
};

using Point2 = Eigen::Vector2d;

// The bone of a plane around its point, divided into connected sections.
class Sections {
 public:
  Sections(const SawPlane& plane, const BrickField& bone) {
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i)
        if (bone.sample(plane.fromPlane(placeOf(i), placeOf(j))) < 0) section_[cellOf(i, j)] = kUnknown;
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i)
        if (section_[cellOf(i, j)] == kUnknown) flood(i, j, count_++);
  }

  int count() const { return count_; }
  /// Of the nearest cell within a distance of a place. Negative: none.
  int nearest(const Point2& to, double within) const {
    int out = kNone;
    each([&](const Point2& p, int section) {
      const double away = (p - to).norm();
      if (away >= within) return;
      within = away;
      out = section;
    });
    return out;
  }
  template <class F>
  void each(const F& f) const {
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i)
        if (const int section = section_[cellOf(i, j)]; section >= 0) f({placeOf(i), placeOf(j)}, section);
  }
  /// The sections beside a given one that a blade on the line meets first in most of their columns, about as high: both
  /// sides of an arch, but neither a crown above the jaw nor anything behind it.
  std::vector<int> besideEachOther(double low, double high, int given) const {
    constexpr double kAsHigh = 15, kMostShared = 0.2;  // mm; of the columns
    std::vector<int> columns(static_cast<std::size_t>(count_), 0), first = columns, shared = columns;
    std::vector<double> start(static_cast<std::size_t>(count_), kLooked);
    for (int i = 0; i < kSide; ++i) {
      if (placeOf(i) < low || placeOf(i) > high) continue;
      std::vector<char> is_seen(static_cast<std::size_t>(count_), 0);
      bool is_first = true;
      for (int j = 0; j < kSide; ++j) {
        const int section = section_[cellOf(i, j)];
        if (section < 0) continue;
        const auto n = static_cast<std::size_t>(section);
        if (std::exchange(is_seen[n], 1)) continue;
        ++columns[n];
        first[n] += std::exchange(is_first, false);
        start[n] = std::min(start[n], placeOf(j));
      }
      for (std::size_t n = 0; n < is_seen.size(); ++n)
        shared[n] += is_seen[n] && is_seen[static_cast<std::size_t>(given)];
    }
    std::vector<int> out;
    for (int n = 0; n < count_; ++n) {
      const auto at = static_cast<std::size_t>(n);
      const double apart = std::abs(start[at] - start[static_cast<std::size_t>(given)]);
      const bool is_beside = kMostShared * columns[at] >= shared[at];
      if (is_beside && 2 * first[at] > columns[at] && apart < kAsHigh) out.push_back(n);
    }
    return out;
  }
  /// Cells of the sections for which is_wanted[section].
  std::vector<Point2> cells(const std::vector<char>& is_wanted) const {
    std::vector<Point2> out;
    each([&](const Point2& p, int section) {
      if (is_wanted[static_cast<std::size_t>(section)]) out.push_back(p);
    });
    return out;
  }

 private:
  static constexpr int kSide = static_cast<int>(2 * kLooked / kCell) + 1, kNone = -1, kUnknown = -2;
  static double placeOf(int n) { return n * kCell - kLooked; }
  static std::size_t cellOf(int i, int j) { return static_cast<std::size_t>(j) * kSide + static_cast<std::size_t>(i); }
  void flood(int from_i, int from_j, int section) {
    std::vector<std::array<int, 2>> open{{from_i, from_j}};
    while (!open.empty()) {
      const auto [i, j] = open.back();
      open.pop_back();
      if (i < 0 || j < 0 || i >= kSide || j >= kSide || section_[cellOf(i, j)] != kUnknown) continue;
      section_[cellOf(i, j)] = section;
      for (const auto& [di, dj] : {std::array{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) open.push_back({i + di, j + dj});
    }
  }

  std::vector<int> section_ = std::vector<int>(cellOf(0, kSide), kNone);
  int count_ = 0;
};

struct Extents {
  Extent across, along;
};
// Extents of cells for an approach turned by an angle about the normal.
Extents extentsOf(const std::vector<Point2>& cells, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  Extents out;
  for (const Point2& p : cells) {
    out.across.add(c * p[0] - s * p[1]);
    out.along.add(s * p[0] + c * p[1]);
  }
  return out;
}

// Shortfall of a blade for a section, mm.
double shortBy(const Extents& e, const SawBlade& blade) {
  return std::max(0.0, e.across.size() + 2 * kBefore - blade.most_width) +
         std::max(0.0, e.along.size() + kBefore + kBehind - blade.most_depth);
}

// The turn of the approach, rad, with the greatest reach of the blade; of equal ones along the sides of the section.
double bestTurn(const std::vector<Point2>& cells, const SawBlade& blade) {
  double best = 0, least = std::numeric_limits<double>::infinity();
  for (int n = 0; n < kDirections; ++n) {
    const double angle = 2 * std::numbers::pi * n / kDirections;
    const Extents e = extentsOf(cells, angle);
    const double turned = std::min(angle, 2 * std::numbers::pi - angle);
    const double cost = 1000 * shortBy(e, blade) + e.along.size() + e.across.size() + turned;
    if (cost >= least) continue;
    least = cost;
    best = angle;
  }
  return best;
}

}  // namespace

bool isTurned(const SawPlane& plane, const SawBlade& blade, const Box3& bone) {
  if (!blade.is_held_at_end || bone.isEmpty()) return false;
  return plane.across().dot(plane.point - bone.center()) < 0;
}

Expected<SawPlane> fitToBone(SawPlane plane, const BrickField& bone, const SawBlade& blade, FitOptions options) {
  const Sections sections(plane, bone);
  const int nearest = sections.nearest(Point2::Zero(), kNear);
  if (nearest < 0)
    return fail({.code = Error::Code::kEmpty,
                 .found = fmt::format("no bone in that plane within {:g} mm of ({:.1f}, {:.1f}, {:.1f})", kNear,
                                      plane.point[0], plane.point[1], plane.point[2]),
                 .expected = "a plane that passes through the object",
                 .hint = "draw a line right across the bone, or pick points on it"});
  std::vector<char> is_wanted(static_cast<std::size_t>(sections.count()), 0);
  is_wanted[static_cast<std::size_t>(nearest)] = 1;
  std::vector<Point2> cells = sections.cells(is_wanted);
  if (options.across) {
    const auto [low, high] = *options.across;
    for (const int n : sections.besideEachOther(low, high, nearest)) is_wanted[static_cast<std::size_t>(n)] = 1;
    std::vector<Point2> all = sections.cells(is_wanted);
    Extent wide;
    for (const Point2& p : all)
      if (!options.limits || (p[0] >= low && p[0] <= high)) wide.add(p[0]);
    if (wide.size() + 2 * kBefore <= blade.most_width) cells = std::move(all);
  }

  double turn = 0;
  if (!options.keeps_approach && shortBy(extentsOf(cells, 0), blade) > 0) turn = bestTurn(cells, blade);
  Extents e = extentsOf(cells, turn);
  SawPlane out = plane;
  out.approach = Eigen::AngleAxisd(turn, plane.normal) * plane.approach;

  // Limits across: the bone, a drawn line, the blade.
  Extent across{e.across.low - kBefore, e.across.high + kBefore};
  if (options.across && options.limits) {
    across.low = std::max(across.low, options.across->front());
    across.high = std::min(across.high, options.across->back());
  }
  out.point = plane.point + 0.5 * (across.low + across.high) * out.across();
  if (const double much = across.size() - blade.most_width; much > 0) {
    const bool is_turned = isTurned(out, blade, bone.bounds());
    if (!blade.is_held_at_end) {
      across.low += 0.5 * much;
      across.high -= 0.5 * much;
    } else if (is_turned) {
      across.high -= much;
    } else {
      across.low += much;
    }
  }
  out.width = std::clamp(across.size(), SawPlan::kLeastSide, SawPlan::kMostSide);

  const double begins = e.along.low - kBefore;
  out.depth = std::min(e.along.size() + kBefore + kBehind, blade.most_depth);
  out.point = plane.point + 0.5 * (across.low + across.high) * out.across() + begins * out.approach;
  return out;
}

SawCoverage coverageOf(const SawPlane& plane, const BrickField& bone, const SawBlade& blade) {
  SawPlane middle = plane;
  middle.point = plane.fromPlane(0, 0.5 * plane.depth);
  const Sections sections(middle, bone);
  const double depth = std::min(plane.depth, blade.most_depth);
  std::vector<std::size_t> within(static_cast<std::size_t>(sections.count()), 0), all = within;
  sections.each([&](const Point2& p, int section) {
    const double v = p[1] + 0.5 * plane.depth;
    ++all[static_cast<std::size_t>(section)];
    within[static_cast<std::size_t>(section)] += std::abs(p[0]) <= 0.5 * plane.width && v >= 0 && v <= depth;
  });
  SawCoverage out;
  out.sections = sections.count();
  std::size_t met = 0, passed = 0;
  for (std::size_t n = 0; n < all.size(); ++n) {
    if (within[n] == 0) continue;
    ++out.sections_met;
    met += all[n];
    passed += within[n];
  }
  if (met > 0) out.share = static_cast<double>(passed) / static_cast<double>(met);
  return out;
}

std::vector<SawPass> passesOf(const SawPlane& plane, const BrickField& bone, const SawBlade& blade, bool is_turned) {
  std::vector<double> places;
  if (blade.is_held_at_end) {
    // The tip ends with the rectangle; a longer blade stands out on the handpiece's side.
    const double aside = 0.5 * (blade.span - plane.width);
    places.push_back(is_turned ? -aside : aside);
  } else if (plane.width <= blade.flat) {
    places.push_back(0);
  } else {
    const double way = plane.width - blade.flat;
    const int steps = static_cast<int>(std::ceil(way / blade.step - 1e-9));
    for (int n = 0; n <= steps; ++n) places.push_back(-0.5 * way + n * way / steps);
  }

  std::vector<SawPass> out;
  for (const double u : places) {
    Extent along;
    for (double beside = -0.5 * blade.span; beside <= 0.5 * blade.span; beside += kCell) {
      // Tissue beside the rectangle is in the teeth's way, too.
      for (double v = -kBefore - kBehind; v <= plane.depth; v += kCell)
        if (bone.sample(plane.fromPlane(u + beside, v)) < 0) along.add(v);
    }
    if (!(along.size() >= 0)) continue;
    const double end = std::min(plane.depth, along.high + kBehind + blade.sag);
    out.push_back({u, along.low - kAboveSection, std::max(end, along.low)});
  }
  return out;
}

SawnSection::SawnSection(const SawPlane& plane, const BrickField& bone, const Tool& tool, const SawBlade& blade)
    : plane_(plane), blade_(blade), teeth_(tool.cut) {
  const Vec3d half = 0.5 * tool.cut->bounds().size();
  height_ = 2 * std::abs(half.dot(blade.plunge));
  const double wide = 0.5 * plane.width + kBeside;
  for (double u = -wide; u <= wide; u += kCell)
    for (double v = -kBeside; v <= plane.depth + kBeside; v += kCell) {
      const Vec3d at = plane.fromPlane(u, v);
      const auto distance = static_cast<double>(bone.sample(at));
      const bool is_planned = std::abs(u) <= 0.5 * plane.width && v >= 0 && v <= plane.depth;
      const auto part = [](double inside) { return std::clamp(0.5 + inside / kCell, 0.0, 1.0); };  // mm from an edge
      area_ += part(0.5 * plane.width - std::abs(u)) * part(std::min(v, plane.depth - v)) * part(-distance);
      if (distance >= 0) continue;
      cells_.push_back({at, u, v, is_planned, false});
      planned_ += is_planned;
    }
}

void SawnSection::mark(const Rigid3& T_world_tool) {
  const Rigid3 T_tool_world = T_world_tool.inverse();
  const Vec3d front = plane_.toPlane(T_world_tool * blade_.front);
  for (Cell& cell : cells_) {
    if (cell.is_sawn || std::abs(cell.u - front[0]) > 0.5 * blade_.span + kCell) continue;
    if (cell.v > front[1] + kCell || cell.v < front[1] - height_ - kCell) continue;
    if (teeth_->distance(T_tool_world * cell.at) > kTouches) continue;
    cell.is_sawn = true;
    ++(cell.is_planned ? sawn_ : beyond_);
  }
}

double SawnSection::share() const {
  return planned_ > 0 ? static_cast<double>(sawn_) / static_cast<double>(planned_) : 1;
}

}  // namespace kerf
