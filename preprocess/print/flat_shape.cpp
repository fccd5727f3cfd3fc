#include "preprocess/print/flat_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "preprocess/close/plane_arrangement.h"

namespace kerf::internal {
namespace {

constexpr double kJoint = 0.03;  // mm, half a diagonal of a square at a point where parts touch

double cross(const Point2d& a, const Point2d& b) { return a.x() * b.y() - a.y() * b.x(); }

Error notTriangulated() {
  return {.code = Error::Code::kGeometry,
          .place = "label text",
          .found = "outlines that could not be united",
          .expected = "outlines of a font",
          .hint = "another height or font"};
}

struct Triangulated {
  FlatShape shape;
  std::vector<std::pair<Point2d, int>> pinches;  // points where parts touch, with the winding number beside them
};

std::optional<Triangulated> triangulated(const std::vector<Contour>& contours, double square_mm) {
  std::vector<Segment> segments;
  Point2d low = contours[0][0], high = low;
  for (const Contour& contour : contours)
    for (std::size_t n = 0; n < contour.size(); ++n) {
      const Point2d &p = contour[n], &q = contour[(n + 1) % contour.size()];
      segments.push_back({{p.x(), p.y()}, {q.x(), q.y()}});
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  const std::size_t outlines = segments.size();
  if (square_mm > 0)
    for (const int axis : {0, 1}) {
      const int count = static_cast<int>(std::ceil((high - low)[axis] / square_mm));
      for (int n = 1; n < count; ++n) {
        Point2d from = low.array() - 0.1, to = high.array() + 0.1;
        from[axis] = to[axis] = low[axis] + n * (high - low)[axis] / count;
        segments.push_back(
            {{roundedToFloat(from.x()), roundedToFloat(from.y())}, {roundedToFloat(to.x()), roundedToFloat(to.y())}});
      }
    }

  Cdt cdt;
  const Progress none;
  Poll poll(none, 0, "");
  if (!arrange(segments, cdt, poll) || cdt.dimension() < 2) return std::nullopt;
  Net net;
  for (std::size_t s = 0; s < outlines; ++s) count(segments[s], net);

  Triangulated out;
  std::map<Point2, std::uint32_t> number;
  std::vector<int> winding_at;
  forEachFace(cdt, net, [&](const std::array<Point2, 3>& corners, int winding) {
    if (winding == 0) return;
    Triangle triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [it, is_new] = number.try_emplace(corners[k], static_cast<std::uint32_t>(out.shape.points.size()));
      if (is_new) {
        out.shape.points.push_back({corners[k][0], corners[k][1]});
        winding_at.push_back(winding);
      }
      triangle[k] = it->second;
    }
    out.shape.triangles.push_back(triangle);
  });

  std::vector<int> leaving(out.shape.points.size(), 0);
  for (const auto& [from, to] : out.shape.border()) ++leaving[from];
  for (std::size_t v = 0; v < leaving.size(); ++v)
    if (leaving[v] > 1) out.pinches.push_back({out.shape.points[v], winding_at[v]});
  return out;
}

}  // namespace

std::vector<std::array<std::uint32_t, 2>> FlatShape::border() const {
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) edges.push_back({t[k], t[(k + 1) % 3]});
  std::sort(edges.begin(), edges.end());
  std::vector<std::array<std::uint32_t, 2>> out;
  for (const auto& [from, to] : edges)
    if (!std::binary_search(edges.begin(), edges.end(), std::array{to, from})) out.push_back({from, to});
  return out;
}

double FlatShape::area() const {
  double sum = 0;
  for (const Triangle& t : triangles) sum += cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]) / 2;
  return sum;
}

Point2d FlatShape::low() const {
  Point2d out = points[0];
  for (const Point2d& p : points) out = out.cwiseMin(p);
  return out;
}

Point2d FlatShape::high() const {
  Point2d out = points[0];
  for (const Point2d& p : points) out = out.cwiseMax(p);
  return out;
}

double FlatShape::leastStroke(double most_mm) const {
  constexpr double kOpposite = -0.95;  // cosine between the directions of the edges: else it is a corner
  constexpr double kStep = 0.1;        // mm, between the places tried on an edge
  struct Place {
    double width;
    Point2d at;
    double length;  // mm of border that it stands for
  };
  std::vector<Place> places;
  const auto edges = border();
  for (const auto& [from, to] : edges) {
    const Point2d p = points[from], along = points[to] - p;
    const double length = along.norm();
    const Point2d inwards = Point2d(-along.y(), along.x()) / length;
    const int steps = std::max(1, static_cast<int>(length / kStep));
    for (int n = 0; n < steps; ++n) {
      const Point2d at = p + (n + 0.5) / steps * along;
      double nearest = most_mm;
      bool is_stroke = false;
      for (const auto& [a, b] : edges) {
        const Point2d from_here = points[a] - at, edge = points[b] - points[a];
        if (from_here.x() > nearest && from_here.x() + edge.x() > nearest) continue;
        if (from_here.x() < -nearest && from_here.x() + edge.x() < -nearest) continue;
        const double turn = cross(inwards, edge);
        if (!(turn > 0)) continue;  // the ray leaves the shape only from right to left of an edge
        const double way = cross(from_here, edge) / turn, share = cross(from_here, inwards) / turn;
        if (way <= 1e-9 || way >= nearest || share < 0 || share > 1) continue;
        nearest = way;
        is_stroke = along.dot(edge) < kOpposite * length * edge.norm();
      }
      if (is_stroke) places.push_back({nearest, at, length / steps});
    }
  }

  // A join of two strokes is narrow in one place: a stroke is as long as wide, on both sides.
  std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.width < b.width; });
  for (const Place& place : places) {
    constexpr double kAlike = 1.1;
    double length = 0;
    for (const Place& other : places) {
      if (other.width > kAlike * place.width) break;
      if ((other.at - place.at).norm() < 1.2 * place.width) length += other.length;
    }
    if (length >= 2 * place.width) return place.width;
  }
  return most_mm;
}

Expected<FlatShape> united(const std::vector<Contour>& given, double square_mm) {
  constexpr int kRounds = 6;
  std::vector<Contour> contours = given;
  for (Contour& contour : contours)
    for (Point2d& p : contour) p = {roundedToFloat(p.x()), roundedToFloat(p.y())};  // as arrange() wants them
  try {
    for (int round = 0; round < kRounds; ++round) {
      auto now = triangulated(contours, square_mm);
      if (!now || now->shape.triangles.empty()) return fail(notTriangulated());
      if (now->pinches.empty()) return std::move(now->shape);
      for (const auto& [p, winding] : now->pinches) {
        Contour square;
        for (const Point2d& to : {Point2d(1, 0), Point2d(0, 1), Point2d(-1, 0), Point2d(0, -1)})
          square.push_back({roundedToFloat(p.x() + kJoint * to.x()), roundedToFloat(p.y() + kJoint * to.y())});
        if (winding < 0) std::reverse(square.begin(), square.end());
        contours.push_back(std::move(square));
      }
    }
  } catch (const std::exception&) {
  }
  return fail(notTriangulated());
}

}  // namespace kerf::internal
