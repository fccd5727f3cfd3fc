#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "preprocess/print/flat_shape.h"
#include "preprocess/print/label.h"
#include "preprocess/print/label_face.h"

namespace kerf {
namespace {

using internal::FaceHeights, internal::LabelFrame, internal::Point2d;

constexpr double kFaceMargin = 1;        // mm of face around a text
constexpr double kLeastHeight = 1.5;     // mm
constexpr double kShrink = 0.9;          // from one height tried to the next
constexpr double kUndersideFlat = 0.02;  // mm: the underside's vertices lie so near to its end

Error noPlace(std::string found, std::string expected, std::string hint) {
  return {.code = Error::Code::kGeometry,
          .place = "place of a label",
          .found = std::move(found),
          .expected = std::move(expected),
          .hint = std::move(hint)};
}

// Width and height of a text, in its cap heights.
struct Extent {
  double width, height;
};

// ---- The underside

// Squares of a plane, those wholly in a face known; counts of them below and left of each, for rectangles.
class FaceSquares {
 public:
  // @param triangles  three corners each.   @param border  two ends each.
  FaceSquares(const std::vector<Point2d>& triangles, const std::vector<Point2d>& border) {
    low_ = triangles[0];
    Point2d high = low_;
    for (const Point2d& p : triangles) {
      low_ = low_.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    constexpr double kFinest = 0.25, kMostSquares = 500;  // mm; a side
    square_ = std::max(kFinest, (high - low_).maxCoeff() / kMostSquares);
    columns_ = static_cast<int>((high.x() - low_.x()) / square_) + 1;
    rows_ = static_cast<int>((high.y() - low_.y()) / square_) + 1;
    inside_.assign(static_cast<std::size_t>(columns_ * rows_), 0);
    for (std::size_t n = 0; n + 2 < triangles.size(); n += 3) fill(triangles[n], triangles[n + 1], triangles[n + 2]);
    for (std::size_t n = 0; n + 1 < border.size(); n += 2) clear(border[n], border[n + 1]);

    count_.assign(static_cast<std::size_t>((columns_ + 1) * (rows_ + 1)), 0);
    for (int r = 0; r < rows_; ++r)
      for (int c = 0; c < columns_; ++c)
        count_[corner(c + 1, r + 1)] = count_[corner(c, r + 1)] + count_[corner(c + 1, r)] - count_[corner(c, r)] +
                                       inside_[static_cast<std::size_t>(r * columns_ + c)];
  }

  // The middle of the first rectangle of that size in the face.
  std::optional<Point2d> fit(double width, double height) const {
    const int across = static_cast<int>(std::ceil(width / square_)) + 1;
    const int up = static_cast<int>(std::ceil(height / square_)) + 1;
    for (int r = 0; r + up <= rows_; ++r)
      for (int c = 0; c + across <= columns_; ++c)
        if (count_[corner(c + across, r + up)] - count_[corner(c, r + up)] - count_[corner(c + across, r)] +
                count_[corner(c, r)] ==
            across * up)
          return low_ + square_ * Point2d(c + 0.5 * across, r + 0.5 * up);
    return std::nullopt;
  }

 private:
  std::size_t corner(int c, int r) const { return static_cast<std::size_t>(r * (columns_ + 1) + c); }
  Point2d inSquares(const Point2d& p) const { return (p - low_) / square_; }

  // Squares with their middle in the triangle.
  void fill(const Point2d& p, const Point2d& q, const Point2d& r) {
    const std::array<Point2d, 3> at{inSquares(p), inSquares(q), inSquares(r)};
    const double least = std::min({at[0].y(), at[1].y(), at[2].y()}),
                 most = std::max({at[0].y(), at[1].y(), at[2].y()});
    for (int row = std::max(0, static_cast<int>(least - 0.5)); row < rows_ && row + 0.5 <= most; ++row) {
      const double y = row + 0.5;
      double from = columns_, to = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const Point2d &a = at[k], &b = at[(k + 1) % 3];
        if ((a.y() < y) == (b.y() < y)) continue;
        const double x = a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
        from = std::min(from, x);
        to = std::max(to, x);
      }
      for (int c = std::max(0, static_cast<int>(std::ceil(from - 0.5))); c < columns_ && c + 0.5 <= to; ++c)
        inside_[static_cast<std::size_t>(row * columns_ + c)] = 1;
    }
  }
  void clear(const Point2d& from, const Point2d& to) {
    const Point2d a = inSquares(from), b = inSquares(to);
    const int steps = static_cast<int>((b - a).norm() * 2) + 1;
    for (int n = 0; n <= steps; ++n) {
      const Point2d p = a + n / double(steps) * (b - a);
      const int c = std::clamp(static_cast<int>(p.x()), 0, columns_ - 1);
      const int r = std::clamp(static_cast<int>(p.y()), 0, rows_ - 1);
      inside_[static_cast<std::size_t>(r * columns_ + c)] = 0;
    }
  }

  Point2d low_;
  double square_ = 1;
  int columns_ = 0, rows_ = 0;
  std::vector<char> inside_;
  std::vector<int> count_;
};

// The flat face at the end along `down`: corners of its triangles, and ends of its border's edges.
struct EndFace {
  std::vector<Vec3d> triangles, border;
  double area = 0;
};

EndFace endFace(const Mesh& solid, const Vec3d& down) {
  constexpr double kFacing = 0.99;  // cosine
  double end = -std::numeric_limits<double>::infinity();
  std::vector<double> height;
  for (const Vec3d& p : solid.vertices) height.push_back(p.dot(down));
  for (const Triangle& t : solid.triangles)
    for (const std::uint32_t v : t) end = std::max(end, height[v]);

  EndFace out;
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    const Triangle& corners = solid.triangles[t];
    if (!std::all_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return height[v] > end - kUndersideFlat; }))
      continue;
    const Vec3d twice = doubleAreaVector(solid, t);
    if (!(twice.dot(down) > kFacing * twice.norm())) continue;
    out.area += twice.norm() / 2;
    for (int k = 0; k < 3; ++k) {
      out.triangles.push_back(solid.corner(t, k));
      edges.push_back({corners[static_cast<std::size_t>(k)], corners[static_cast<std::size_t>((k + 1) % 3)]});
    }
  }
  std::sort(edges.begin(), edges.end());
  for (const auto& [from, to] : edges)
    if (!std::binary_search(edges.begin(), edges.end(), std::array{to, from})) {
      out.border.push_back(solid.vertices[from]);
      out.border.push_back(solid.vertices[to]);
    }
  return out;
}

struct Fit {
  double height = 0;
  double turn = 0;  // from label.up
  Point2d middle = Point2d::Zero();
};

std::vector<Point2d> flat(const std::vector<Vec3d>& points, const Vec3d& right, const Vec3d& up) {
  std::vector<Point2d> out;
  for (const Vec3d& p : points) out.push_back({p.dot(right), p.dot(up)});
  return out;
}

// The largest text up to `most`, then in the middle of the widest place for it.
Fit largestIn(const FaceSquares& squares, const Extent& text, double most) {
  Fit out;
  const auto tried = [&](double height, double margin) {
    const auto middle = squares.fit(text.width * height + 2 * margin, text.height * height + 2 * margin);
    if (middle) {
      out.height = height;
      out.middle = *middle;
    }
    return middle.has_value();
  };
  if (!tried(most, kFaceMargin)) {
    double low = 0, high = most;
    while (high - low > 0.02) {
      const double half = (low + high) / 2;
      (tried(half, kFaceMargin) ? low : high) = half;
    }
  }
  if (out.height == 0) return out;
  double low = kFaceMargin, high = 20;
  while (high - low > 0.2) {
    const double half = (low + high) / 2;
    (tried(out.height, half) ? low : high) = half;
  }
  return out;
}

Expected<LabelPlace> onUnderside(const Mesh& solid, const Vec3d& down, const LabelOptions& wanted, const Extent& text,
                                 const Progress& progress) {
  const EndFace face = endFace(solid, down);
  if (face.triangles.empty())
    return fail(noPlace(fmt::format("no face across the direction within {} mm of the solid's end", kUndersideFlat),
                        "a flat base", "a base (kerf bake), a plane cut, or another direction"));
  Vec3d up = wanted.up - wanted.up.dot(down) * down;
  if (up.norm() < 0.1 * wanted.up.norm()) {
    const Vec3d other = std::abs(down.z()) < 0.9 ? Vec3d(Vec3d::UnitZ()) : Vec3d(Vec3d::UnitY());
    up = other - other.dot(down) * down;
  }
  up.normalize();
  const auto turned = [&](double angle) { return Vec3d(std::cos(angle) * up + std::sin(angle) * up.cross(down)); };

  constexpr int kTurns = 24;
  Fit best;
  for (int n = 0; n < kTurns && best.height < wanted.height_mm; ++n) {
    if (!report(progress, n / double{kTurns}, "placing the label")) return cancelled();
    const double turn = (n % 2 ? 1 : -1) * ((n + 1) / 2) * std::numbers::pi / kTurns;
    const Vec3d y = turned(turn), x = y.cross(down);
    const FaceSquares squares(flat(face.triangles, x, y), flat(face.border, x, y));
    Fit fit = largestIn(squares, text, wanted.height_mm);
    fit.turn = turn;
    if (fit.height > best.height + 0.03) best = fit;
  }
  if (best.height < std::min(kLeastHeight, wanted.height_mm))
    return fail(noPlace(
        fmt::format("a flat underside of {:.0f} mm2 with room for letters {:.1f} mm high", face.area, best.height),
        fmt::format("at least {} mm", kLeastHeight), "a shorter text, or more lines"));

  LabelPlace out{.label = wanted, .wanted_height_mm = wanted.height_mm};
  const Vec3d y = turned(best.turn), x = y.cross(down);
  out.label.point = best.middle.x() * x + best.middle.y() * y + face.triangles[0].dot(down) * down;
  out.label.normal = down;
  out.label.up = y;
  out.label.bend_radius_mm = 0;
  out.label.height_mm = best.height;
  return out;
}

// ---- The side

// Closed lines where the solid meets a plane across `up`, at `height` along it; to the right, seen from outside.
std::vector<std::vector<Vec3d>> sectionOf(const Mesh& solid, const Vec3d& up, double height) {
  using Edge = std::array<std::uint32_t, 2>;
  struct Step {
    Vec3d at;
    Edge next;
    bool is_used = false;
  };
  std::map<Edge, Step> steps;
  for (const Triangle& t : solid.triangles) {
    std::array<double, 3> above{};
    for (std::size_t k = 0; k < 3; ++k) above[k] = solid.vertices[t[k]].dot(up) - height;
    std::optional<Edge> goes_up, goes_down;
    Vec3d rises = Vec3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      const double from = above[k], to = above[(k + 1) % 3];
      if ((from > 0) == (to > 0)) continue;
      const Edge edge{std::min(a, b), std::max(a, b)};
      if (to > 0) {
        goes_up = edge;
        rises = solid.vertices[a] + from / (from - to) * (solid.vertices[b] - solid.vertices[a]);
      } else {
        goes_down = edge;
      }
    }
    // Seen from outside, a triangle's border rises on its right.
    if (goes_up && goes_down) steps[*goes_up] = {rises, *goes_down, false};
  }
  std::vector<std::vector<Vec3d>> out;
  for (auto& [edge, first] : steps) {
    if (first.is_used) continue;
    out.emplace_back();
    for (auto it = steps.find(edge); it != steps.end() && !it->second.is_used; it = steps.find(it->second.next)) {
      it->second.is_used = true;
      out.back().push_back(it->second.at);
    }
    std::reverse(out.back().begin(), out.back().end());  // the steps go left
  }
  return out;
}

struct Wall {
  LabelFrame frame;
  double residual = 0;  // mm, of the section from the parabola
  double rank = 0;
};

// Walls along a closed line, each over `width`, from a parabola z(x) fitted to the line.
void addWalls(const std::vector<Vec3d>& line, const Vec3d& up, double width, double depth, std::vector<Wall>& out) {
  constexpr double kStep = 1, kSample = 0.5;  // mm
  std::vector<double> way{0};
  for (std::size_t n = 0; n < line.size(); ++n)
    way.push_back(way.back() + (line[(n + 1) % line.size()] - line[n]).norm());
  const double length = way.back();
  if (!(length > 1.5 * width)) return;
  const auto at = [&](double s) {
    s -= length * std::floor(s / length);
    const auto n = static_cast<std::size_t>(std::upper_bound(way.begin(), way.end(), s) - way.begin()) - 1;
    const std::size_t from = std::min(n, line.size() - 1);
    const double part = way[from + 1] - way[from];
    return Vec3d(line[from] + (part > 0 ? (s - way[from]) / part : 0) * (line[(from + 1) % line.size()] - line[from]));
  };

  const int samples = std::max(4, static_cast<int>(width / kSample));
  for (double s = 0; s < length; s += kStep) {
    const Vec3d a = at(s - width / 2), b = at(s + width / 2), middle = at(s);
    if (!((b - a).norm() > 0.5 * width)) continue;
    LabelFrame frame;
    frame.up = up;
    frame.right = (b - a).normalized();
    frame.normal = frame.right.cross(up).normalized();

    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    Vec3d sums = Vec3d::Zero();
    std::vector<Point2d> points;
    for (int n = 0; n <= samples; ++n) {
      const Vec3d p = at(s + (n / double(samples) - 0.5) * width) - middle;
      points.push_back({p.dot(frame.right), p.dot(frame.normal)});
      const Vec3d powers(1, points.back().x(), points.back().x() * points.back().x());
      squares += powers * powers.transpose();
      sums += points.back().y() * powers;
    }
    const Vec3d fit = squares.ldlt().solve(sums);
    if (!fit.allFinite()) continue;
    double low = 0, high = 0;
    for (const Point2d& p : points) {
      const double off = p.y() - (fit[0] + fit[1] * p.x() + fit[2] * p.x() * p.x());
      low = std::min(low, off);
      high = std::max(high, off);
    }

    Wall wall;
    const double tilt = std::sqrt(1 + fit[1] * fit[1]);
    wall.frame = frame;
    wall.frame.point = middle + fit[0] * frame.normal;
    wall.frame.right = (frame.right + fit[1] * frame.normal) / tilt;
    wall.frame.normal = (frame.normal - fit[1] * frame.right) / tilt;
    const double sagitta = fit[2] * width * width / 4;
    constexpr double kSoGoodAsFlat = 0.1;  // of the depth
    if (std::abs(sagitta) > kSoGoodAsFlat * depth) wall.frame.radius_mm = -tilt * tilt * tilt / (2 * fit[2]);
    wall.residual = high - low;
    constexpr double kHollow = 0.03, kBend = 0.1;  // mm: a hollow wall, and one bent by a radian, count as so uneven
    wall.rank = wall.residual + kBend * std::abs(2 * fit[2]) * width + (fit[2] > 0 ? kHollow : 0);
    out.push_back(wall);
  }
}

Expected<LabelPlace> onSide(const Mesh& solid, const Vec3d& down, const LabelOptions& wanted, const Extent& text,
                            const Progress& progress) {
  const Vec3d up = -down;
  double base = std::numeric_limits<double>::infinity();
  for (const Triangle& t : solid.triangles)
    for (const std::uint32_t v : t) base = std::min(base, solid.vertices[v].dot(up));

  // Only the triangles beside the text count.
  const double top = base + 2 * kFaceMargin + text.height * wanted.height_mm;
  std::vector<char> is_beside(solid.triangles.size(), 0);
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    double low = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) low = std::min(low, solid.corner(t, k).dot(up));
    is_beside[t] = low < top;
  }
  const Mesh beside = subset(solid, is_beside);

  constexpr std::size_t kTried = 16;
  Error last = noPlace("no wall", "a wall along the direction", "a base (kerf bake), or the underside");
  std::string best_known;
  const double least = std::min(kLeastHeight, wanted.height_mm);
  for (double height = wanted.height_mm; height >= least; height *= kShrink) {
    if (!report(progress, (wanted.height_mm - height) / wanted.height_mm, "placing the label")) return cancelled();
    const double width = text.width * height, tall = text.height * height;
    const double level = base + kFaceMargin + tall / 2;
    std::vector<Wall> walls;
    for (const std::vector<Vec3d>& line : sectionOf(beside, up, level))
      addWalls(line, up, width + 2 * kFaceMargin, wanted.depth_mm, walls);
    std::stable_sort(walls.begin(), walls.end(), [](const Wall& a, const Wall& b) { return a.rank < b.rank; });
    for (std::size_t n = 0; n < std::min(walls.size(), kTried); ++n) {
      const LabelFrame& frame = walls[n].frame;
      if (frame.radius_mm != 0 && std::abs(frame.radius_mm) < std::max(3.0 + wanted.depth_mm, width / 2)) continue;
      const double margin = kFaceMargin / 2;
      const FaceHeights heights = internal::faceHeights(beside, frame, {-width / 2 - margin, -tall / 2 - margin},
                                                        {width / 2 + margin, tall / 2 + margin}, internal::kLabelDeep);
      LabelReport numbers{.width_mm = width, .height_mm = tall};
      if (const auto span = internal::spanOn(heights, wanted, numbers); !span) {
        if (best_known.empty()) best_known = last.found = span.error().found;
        continue;
      }
      LabelPlace out{.label = wanted, .wanted_height_mm = wanted.height_mm};
      out.label.point = frame.point;
      out.label.normal = frame.normal;
      out.label.up = up;
      out.label.bend_radius_mm = frame.radius_mm;
      out.label.height_mm = height;
      out.unevenness_mm = numbers.unevenness_mm;
      return out;
    }
  }
  last.found = fmt::format("no wall for letters {} to {} mm high; best: {}", least, wanted.height_mm, last.found);
  last.hint = "a shorter text, more lines, or the underside";
  return fail(last);
}

}  // namespace

Expected<LabelPlace> placeLabel(const Mesh& solid, const Vec3d& down, LabelFace face, const LabelOptions& wanted,
                                const Progress& progress) {
  if (!down.allFinite() || !(down.norm() > 0) || !wanted.up.allFinite() || !(wanted.up.norm() > 0) ||
      !(wanted.height_mm >= 0.5 && wanted.height_mm <= 100) || solid.triangles.empty())
    return fail({.code = Error::Code::kBadValue,
                 .place = "place of a label",
                 .found = "a direction of length 0, a height out of range, or an empty solid",
                 .expected = "a direction, and a height of 0.5 to 100 mm"});
  KERF_TRY(outlines, internal::glyphOutlines(wanted.text, wanted.height_mm, wanted.align, wanted.font));
  Point2d low = outlines[0][0], high = low;
  for (const internal::Contour& contour : outlines)
    for (const Point2d& p : contour) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  const Extent text{(high.x() - low.x()) / wanted.height_mm, (high.y() - low.y()) / wanted.height_mm};
  const Vec3d out_of_base = down.normalized();
  KERF_TRY(place, face == LabelFace::kUnderside ? onUnderside(solid, out_of_base, wanted, text, progress)
                                                : onSide(solid, out_of_base, wanted, text, progress));
  if (place.label.height_mm < wanted.height_mm)
    place.note =
        fmt::format("The letters are {:.1f} mm high: {} mm do not fit.", place.label.height_mm, wanted.height_mm);
  return std::move(place);
}

}  // namespace kerf
