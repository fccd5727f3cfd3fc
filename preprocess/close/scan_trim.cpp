#include "preprocess/close/scan_trim.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace kerf {
namespace {

using Vec2d = Eigen::Vector2d;

// Twice the signed area of a, b, p: > 0 to the left of a -> b.
double side(const Vec2d& a, const Vec2d& b, const Vec2d& p) {
  return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

bool isInBox(const Vec2d& a, const Vec2d& b, const Vec2d& p) {
  return (a.cwiseMin(b).array() <= p.array()).all() && (p.array() <= a.cwiseMax(b).array()).all();
}

// Touching counts.
bool doCross(const Vec2d& a, const Vec2d& b, const Vec2d& p, const Vec2d& q) {
  const double ap = side(a, b, p), aq = side(a, b, q), pa = side(p, q, a), pb = side(p, q, b);
  if (((ap > 0) != (aq > 0)) && ((pa > 0) != (pb > 0)) && ap != 0 && aq != 0 && pa != 0 && pb != 0) return true;
  return (ap == 0 && isInBox(a, b, p)) || (aq == 0 && isInBox(a, b, q)) || (pa == 0 && isInBox(p, q, a)) ||
         (pb == 0 && isInBox(p, q, b));
}

bool isInTriangle(const std::array<Vec2d, 3>& t, const Vec2d& p) {
  const double a = side(t[0], t[1], p), b = side(t[1], t[2], p), c = side(t[2], t[0], p);
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

enum class Place { kInside, kOutside, kCrossed };

// The outline in the plane of the view.
class FlatOutline {
 public:
  explicit FlatOutline(const OutlineTrim& trim) : direction_(trim.direction), eye_(trim.eye) {
    Eigen::Index least = 0;
    direction_.cwiseAbs().minCoeff(&least);
    right_ = direction_.cross(Vec3d::Unit(least)).normalized();
    up_ = right_.cross(direction_);
    for (const Vec3d& p : trim.outline) corners_.push_back(flat(p).value_or(Vec2d::Zero()));
    low_ = high_ = corners_.front();
    for (const Vec2d& c : corners_) {
      low_ = low_.cwiseMin(c);
      high_ = high_.cwiseMax(c);
    }
  }

  // None: not in front of the eye.
  std::optional<Vec2d> flat(const Vec3d& p) const {
    if (!eye_) return Vec2d(right_.dot(p), up_.dot(p));
    constexpr double kNearest = 1e-6;  // mm
    const Vec3d from_eye = p - *eye_;
    const double depth = direction_.dot(from_eye);
    if (!(depth > kNearest)) return {};
    return Vec2d(right_.dot(from_eye) / depth, up_.dot(from_eye) / depth);
  }

  // By the winding number, so that a line that crosses itself has no islands.
  bool contains(const Vec2d& p) const {
    if (!isInBox(low_, high_, p)) return false;
    int winding = 0;
    for (std::size_t n = 0; n < corners_.size(); ++n) {
      const Vec2d &a = corners_[n], &b = corners_[(n + 1) % corners_.size()];
      if (a[1] <= p[1] && b[1] > p[1] && side(a, b, p) > 0) ++winding;
      if (a[1] > p[1] && b[1] <= p[1] && side(a, b, p) < 0) --winding;
    }
    return winding != 0;
  }

  Place placeOf(const std::array<Vec2d, 3>& t, const std::array<bool, 3>& is_inside) const {
    if (is_inside[0] != is_inside[1] || is_inside[1] != is_inside[2]) return Place::kCrossed;
    const Vec2d low = t[0].cwiseMin(t[1]).cwiseMin(t[2]), high = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
    if ((low.array() > high_.array()).any() || (high.array() < low_.array()).any()) return Place::kOutside;
    for (std::size_t n = 0; n < corners_.size(); ++n) {
      const Vec2d &a = corners_[n], &b = corners_[(n + 1) % corners_.size()];
      if ((low.array() > a.cwiseMax(b).array()).any() || (high.array() < a.cwiseMin(b).array()).any()) continue;
      for (std::size_t k = 0; k < 3; ++k)
        if (doCross(a, b, t[k], t[(k + 1) % 3])) return Place::kCrossed;
    }
    if (is_inside[0]) return Place::kInside;
    return isInTriangle(t, corners_.front()) ? Place::kCrossed : Place::kOutside;
  }

 private:
  Vec3d direction_, right_, up_;
  std::optional<Vec3d> eye_;
  std::vector<Vec2d> corners_;
  Vec2d low_, high_;
};

void remove(const OutlineTrim& trim, const Mesh& scan, double scale, std::vector<char>& keep) {
  const FlatOutline outline(trim);
  std::vector<std::optional<Vec2d>> flat(scan.vertices.size());
  std::vector<char> is_inside(scan.vertices.size(), 0);
  for (std::size_t v = 0; v < flat.size(); ++v) {
    flat[v] = outline.flat(scale * scan.vertices[v]);
    is_inside[v] = flat[v] && outline.contains(*flat[v]);
  }
  const Place kept = trim.keeps_inside ? Place::kInside : Place::kOutside;
  for (std::size_t t = 0; t < keep.size(); ++t) {
    if (!keep[t]) continue;
    const auto [a, b, c] = scan.triangles[t];
    const Place place =
        flat[a] && flat[b] && flat[c]
            ? outline.placeOf({*flat[a], *flat[b], *flat[c]}, {is_inside[a] != 0, is_inside[b] != 0, is_inside[c] != 0})
            : Place::kOutside;
    keep[t] = place == kept;
  }
}

void remove(const PlaneTrim& trim, const Mesh& scan, double scale, std::vector<char>& keep) {
  const Plane plane{trim.point, trim.normal};
  for (std::size_t t = 0; t < keep.size(); ++t)
    for (const std::uint32_t v : scan.triangles[t])
      if (plane.height(scale * scan.vertices[v]) > 0) keep[t] = 0;
}

tl::unexpected<Error> badTrim(std::string found, std::string expected) {
  return fail(
      {.code = Error::Code::kBadValue, .place = "trim", .found = std::move(found), .expected = std::move(expected)});
}

// Every remaining triangle has the corners it had, bit for bit, and no area is missing.
Expected<void> compare(const Mesh& scan, const TrimmedScan& out, double scale) {
  constexpr double kRounding = 1e-9;  // of the area
  bool is_same = out.mesh.triangles.size() == out.source_triangle.size();
  for (std::size_t t = 0; is_same && t < out.source_triangle.size(); ++t)
    for (int k = 0; k < 3; ++k) is_same = is_same && out.mesh.corner(t, k) == scan.corner(out.source_triangle[t], k);
  const double before = scale * scale * surfaceArea(scan), after = scale * scale * surfaceArea(out.mesh);
  is_same = is_same && std::abs(before - after - out.removed_mm2) <= kRounding * before;
  if (is_same) return {};
  return fail({.code = Error::Code::kGeometry,
               .place = "trim",
               .found = fmt::format("{} mm2 before, {} mm2 after, {} mm2 removed", before, after, out.removed_mm2),
               .expected = "the scan without the removed triangles, unchanged"});
}

// Without a negative zero, which TOML would lose.
std::string textOf(const Vec3d& p) { return fmt::format("[{}, {}, {}]", p[0] + 0.0, p[1] + 0.0, p[2] + 0.0); }

}  // namespace

ScanTrim flipped(ScanTrim trim) {
  if (auto* const outline = std::get_if<OutlineTrim>(&trim)) outline->keeps_inside = !outline->keeps_inside;
  if (auto* const plane = std::get_if<PlaneTrim>(&trim)) plane->normal = -plane->normal;
  return trim;
}

ScanTrim scaledBy(ScanTrim trim, double factor) {
  if (auto* const outline = std::get_if<OutlineTrim>(&trim)) {
    for (Vec3d& p : outline->outline) p *= factor;
    if (outline->eye) *outline->eye *= factor;
  }
  if (auto* const plane = std::get_if<PlaneTrim>(&trim)) plane->point *= factor;
  return trim;
}

Expected<void> checkTrim(const ScanTrim& trim) {
  const auto isUnit = [](const Vec3d& v) { return v.allFinite() && std::abs(v.norm() - 1) < 1e-6; };
  if (const auto* const plane = std::get_if<PlaneTrim>(&trim)) {
    if (!isUnit(plane->normal) || !plane->point.allFinite())
      return badTrim("a plane with the normal " + textOf(plane->normal), "a normal of length 1 and a point, mm");
    return {};
  }
  const OutlineTrim& outline = std::get<OutlineTrim>(trim);
  const std::size_t corners = outline.outline.size();
  if (corners < 3 || corners > kMostCorners)
    return badTrim(fmt::format("an outline of {} corners", corners), fmt::format("3 to {}", kMostCorners));
  if (!isUnit(outline.direction))
    return badTrim("a view in the direction " + textOf(outline.direction), "a direction of length 1");
  if (outline.eye && !outline.eye->allFinite()) return badTrim("an eye at " + textOf(*outline.eye), "a point, mm");
  for (const Vec3d& p : outline.outline)
    if (!p.allFinite() || (outline.eye && !(outline.direction.dot(p - *outline.eye) > 0)))
      return badTrim("a corner at " + textOf(p), "a point in front of the eye, mm");
  return {};
}

Expected<TrimmedScan> trimScan(const Mesh& scan, std::span<const ScanTrim> trims, double scale_to_mm) {
  std::vector<char> keep(scan.triangles.size(), 1);
  for (const ScanTrim& trim : trims) {
    KERF_CHECK(checkTrim(trim));
    std::visit([&](const auto& one) { remove(one, scan, scale_to_mm, keep); }, trim);
  }

  TrimmedScan out;
  std::vector<char> is_used(scan.vertices.size(), 0);
  for (std::size_t t = 0; t < keep.size(); ++t) {
    for (const std::uint32_t v : scan.triangles[t]) is_used[v] = 1;
    if (keep[t])
      out.source_triangle.push_back(static_cast<std::uint32_t>(t));
    else
      out.removed_mm2 += 0.5 * scale_to_mm * scale_to_mm * doubleAreaVector(scan, t).norm();
  }
  if (out.source_triangle.empty())
    return fail({.code = Error::Code::kEmpty,
                 .place = "trim",
                 .found = "a cut that removes the whole scan",
                 .expected = "a part of it that remains",
                 .hint = "undo it, or flip it"});
  out.mesh = subset(scan, keep);
  out.triangles_removed = scan.triangles.size() - out.mesh.triangles.size();
  out.vertices_removed =
      static_cast<std::size_t>(std::count(is_used.begin(), is_used.end(), 1)) - out.mesh.vertices.size();
  KERF_CHECK(compare(scan, out, scale_to_mm));
  return out;
}

std::string textOf(std::span<const ScanTrim> trims) {
  std::string out;
  for (const ScanTrim& trim : trims) {
    out += "[[trim]]\n";
    if (const auto* const plane = std::get_if<PlaneTrim>(&trim)) {
      out += fmt::format("point = {}\nnormal = {}\n\n", textOf(plane->point), textOf(plane->normal));
      continue;
    }
    const OutlineTrim& outline = std::get<OutlineTrim>(trim);
    out += fmt::format("remove = \"{}\"\ndirection = {}\n", outline.keeps_inside ? "outside" : "inside",
                       textOf(outline.direction));
    if (outline.eye) out += fmt::format("eye = {}\n", textOf(*outline.eye));
    out += "outline = [\n";
    for (const Vec3d& p : outline.outline) out += fmt::format("  {},\n", textOf(p));
    out += "]\n\n";
  }
  return out;
}

}  // namespace kerf
