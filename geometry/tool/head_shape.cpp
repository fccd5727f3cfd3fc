#include "geometry/tool/head_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

using Outline = tl::expected<RevolvedProfile, HeadMistake>;
using Point = RevolvedProfile::Point;
using Numbers = HeadNumbers;

double orElse(double said, double otherwise) { return std::isnan(said) ? otherwise : said; }

Outline wrong(const char* key, std::string expected, std::string hint = "") {
  return tl::unexpected<HeadMistake>({key, std::move(expected), std::move(hint)});
}

// Tangent point on the circle of the line through `from`, with the circle on its left. With the line's outward normal
// (cos a, -sin a) and v = from - center: v.(cos a, -sin a) = r, so a = acos(r / |v|) - atan2(v_y, v_x).
Point touch(const Point& center, double r, const Point& from) {
  const Point v = from - center;
  const double a = std::acos(std::clamp(r / v.norm(), -1.0, 1.0)) - std::atan2(v[1], v[0]);
  return center + r * Point(std::cos(a), -std::sin(a));
}

Outline round(const Numbers& n) {
  const double r = 0.5 * n.head_diameter;
  return RevolvedProfile().arcTo({0, r}, {0, 2 * r});
}

Outline cylinder(const Numbers& n) {
  const double r = 0.5 * n.head_diameter, edge = orElse(n.edge_radius, 0);
  if (edge > std::min(r, n.head_length))
    return wrong("edge_radius", fmt::format("at most {} mm", std::min(r, n.head_length)));
  return RevolvedProfile().lineTo(r - edge, 0).arcTo({r - edge, edge}, {r, edge}).lineTo(r, n.head_length).close();
}

Outline cylinderRound(const Numbers& n) {
  const double r = 0.5 * n.head_diameter;
  if (n.head_length < r) return wrong("head_length", fmt::format("at least {} mm, half the head_diameter", r));
  return RevolvedProfile().arcTo({0, r}, {r, r}).lineTo(r, n.head_length).close();
}

// A shallow dome: the arc through the tip and (R, h) with its centre on the axis.
Outline domed(const Numbers& n) {
  const double r = 0.5 * n.head_diameter, h = orElse(n.dome_height, 0.5 * r), arc = (r * r + h * h) / (2 * h);
  if (h > r) return wrong("dome_height", fmt::format("at most {} mm, half the head_diameter", r));
  if (n.head_length < h) return wrong("head_length", fmt::format("at least the dome's height, {} mm", h));
  return RevolvedProfile().arcTo({0, arc}, {r, h}).lineTo(r, n.head_length).close();
}

Outline taperFlat(const Numbers& n) {
  const double R = 0.5 * n.head_diameter, tip = 0.5 * n.tip_diameter, edge = orElse(n.edge_radius, 0);
  if (tip > R)
    return wrong("tip_diameter", fmt::format("at most the head_diameter, {} mm", n.head_diameter),
                 "shape = \"inverted_cone\" for a head that is widest at its tip");
  // The edge where the flat end (sharp: tip wide) meets the cone of half angle a, rounded: the arc touches both.
  const double a = std::atan2(R - tip, n.head_length);
  const Point center(tip + edge * (std::sin(a) - 1) / std::cos(a), edge);
  const Point end = center + edge * Point(std::cos(a), -std::sin(a));
  if (center[0] < 0 || end[1] > n.head_length)
    return wrong("edge_radius", "an arc that fits between axis, end and top of the head", "a smaller edge_radius");
  return RevolvedProfile().lineTo(center[0], 0).arcTo(center, end).lineTo(R, n.head_length).close();
}

// A sphere of the tip's diameter with its lowest point at the tip, and the cone through (R, L) that touches it.
Outline sphereAndCone(const Numbers& n, double tip_diameter) {
  const double r = 0.5 * tip_diameter, R = 0.5 * n.head_diameter;
  if (r > R) return wrong("tip_diameter", fmt::format("at most the head_diameter, {} mm", n.head_diameter));
  if (n.head_length < R)
    return wrong("head_length", fmt::format("at least {} mm, half the head_diameter", R), "shape = \"round\"");
  const Point top(R, n.head_length);
  return RevolvedProfile().arcTo({0, r}, touch({0, r}, r, top)).lineTo(top[0], top[1]).close();
}
Outline taperRound(const Numbers& n) { return sphereAndCone(n, n.tip_diameter); }
Outline needle(const Numbers& n) { return sphereAndCone(n, orElse(n.tip_diameter, 0.125 * n.head_diameter)); }

Outline cone(const Numbers& n) { return RevolvedProfile().lineTo(0.5 * n.head_diameter, n.head_length).close(); }

// The pointed arch: an arc from the tip that touches the side where the point ends. With P = (d / 2, h) there and the
// side's outward normal m = (cos a, -sin a), the centre is P - s m at the distance s from the tip: s = P.P / (2 P.m).
Outline torpedo(const Numbers& n) {
  const double R = 0.5 * n.head_diameter, r = 0.5 * orElse(n.tip_diameter, n.head_diameter), h = n.point_length;
  if (r > R) return wrong("tip_diameter", fmt::format("at most the head_diameter, {} mm", n.head_diameter));
  if (h >= n.head_length) return wrong("point_length", fmt::format("less than the head_length, {} mm", n.head_length));

  const double a = std::atan2(R - r, n.head_length - h);
  const Point P(r, h), normal(std::cos(a), -std::sin(a));

  const double s = P.dot(normal) > 0 ? P.squaredNorm() / (2 * P.dot(normal)) : 0;
  const Point center = P - s * normal;

  if (s <= 0 || center[0] > 0)
    return wrong("point_length",
                 fmt::format("a point between half as long as it is wide, {:.3g} mm, and one that the "
                             "sides can meet without a kink",
                             r),
                 "shape = \"cylinder_round\" for a blunt end, \"cone\" for a sharp one");
  return RevolvedProfile().arcTo(center, P).lineTo(R, n.head_length).close();
}

Outline invertedCone(const Numbers& n) {
  const double R = 0.5 * n.head_diameter, top = 0.5 * n.top_diameter, edge = orElse(n.edge_radius, 0);
  if (top > R)
    return wrong("top_diameter", fmt::format("at most the head_diameter, {} mm", n.head_diameter),
                 "shape = \"taper_flat\" for a head that is widest at its top");
  if (edge > R || 2 * edge > n.head_length)
    return wrong("edge_radius", fmt::format("at most {:.3g} mm", std::min(R, 0.5 * n.head_length)));

  const Point center(R - edge, edge), last(top, n.head_length);
  RevolvedProfile head;
  head.lineTo(center[0], 0);
  if (edge > 0) head.arcTo(center, touch(center, edge, last));
  return head.lineTo(last[0], last[1]).close();
}

// A sphere and the cone that narrows from it towards the shank.
Outline pear(const Numbers& n) {
  const double R = 0.5 * n.head_diameter, top = 0.5 * n.top_diameter;
  if (top > R) return wrong("top_diameter", fmt::format("at most the head_diameter, {} mm", n.head_diameter));
  if (std::hypot(top, n.head_length - R) <= R || n.head_length < R)
    return wrong("head_length", "a top beyond the sphere at the tip", "shape = \"round\"");
  const Point last(top, n.head_length);
  return RevolvedProfile().arcTo({0, R}, touch({0, R}, R, last)).lineTo(last[0], last[1]).close();
}

// Two arcs that meet, upright, where the head is widest: up from the tip (a sphere, or a point), and on to the top.
// The lower one has its centre at (R - s, w); it holds the tip's sphere of radius r inside and touches it if the
// centres are s - r apart: s = (R^2 + (w - r)^2 - r^2) / (2 (R - r)).
Outline twoArcs(const Numbers& n, double widest_at, double tip_diameter, double top_diameter) {
  const double R = 0.5 * n.head_diameter, L = n.head_length;
  const double w = orElse(n.widest_at, widest_at * L), r = 0.5 * orElse(n.tip_diameter, tip_diameter * n.head_diameter);
  const double top = 0.5 * orElse(n.top_diameter, top_diameter * n.head_diameter), up = L - w;

  if (w >= L) return wrong("widest_at", fmt::format("less than the head_length, {} mm", L));
  if (w < R)
    return wrong(std::isnan(n.widest_at) ? "head_length" : "widest_at",
                 fmt::format("a head that is widest no lower than half its diameter, {:.3g} mm above the tip", R),
                 "a longer head, or shape = \"pear\" or \"round\"");

  constexpr double kNearly = 1 - 1e-6;  // beyond, the arc's centre is too far away for its numbers to hold
  if (r > kNearly * R) return wrong("tip_diameter", fmt::format("less than the head_diameter, {} mm", n.head_diameter));
  if (top > R) return wrong("top_diameter", fmt::format("at most the head_diameter, {} mm", n.head_diameter));
  if (up < R - top)
    return wrong("top_diameter", fmt::format("at least {:.3g} mm: an arc cannot bend in faster", 2 * (R - up)));

  const double s = (R * R + (w - r) * (w - r) - r * r) / (2 * (R - r));
  const Point lower(R - s, w), tip(0, r);
  RevolvedProfile head;
  if (r > 0) head.arcTo(tip, lower + s * (tip - lower).normalized());
  head.arcTo(lower, {R, w});
  if (top > kNearly * R) return head.lineTo(R, L).close();

  const double q = ((R - top) * (R - top) + up * up) / (2 * (R - top));
  return head.arcTo({R - q, w}, {top, L}).close();
}
Outline flame(const Numbers& n) { return twoArcs(n, 0.65, 0, 0.7); }
Outline bud(const Numbers& n) { return twoArcs(n, 0.55, 0, 0.6); }
Outline football(const Numbers& n) { return twoArcs(n, 0.5, 0.5, 0.5); }
Outline acorn(const Numbers& n) { return twoArcs(n, 0.65, 0.25, 1); }

Outline wheel(const Numbers& n) {
  const double R = 0.5 * n.head_diameter, edge = 0.5 * n.head_length;
  if (edge > R) return wrong("head_length", fmt::format("at most the head_diameter, {} mm", n.head_diameter));
  return RevolvedProfile().lineTo(R - edge, 0).arcTo({R - edge, edge}, {R - edge, 2 * edge}).close();
}

Outline drill(const Numbers& n) {
  const double R = 0.5 * n.head_diameter, point = R / std::tan(0.5 * n.point_angle * std::numbers::pi / 180);
  if (point > n.head_length) return wrong("head_length", fmt::format("at least the point's length, {:.3g} mm", point));
  return RevolvedProfile().lineTo(R, point).lineTo(R, n.head_length).close();
}

// From a drawing. Rounding in the drawing may lower a point by less than kLevel.
Outline drawnOutline(const std::vector<OutlinePiece>& pieces) {
  constexpr double kLevel = 1e-6, kLongest = 50;  // mm
  RevolvedProfile head;
  head.lineTo(pieces.front().from[0], 0);
  for (const OutlinePiece& piece : pieces) {
    const Point from = head.end(), to(piece.to[0], std::max(piece.to[1], from[1]));
    const auto refuse = [&](const char* expected) {
      return wrong("profile_file", fmt::format("{} from ({:.4g}, {:.4g}) to ({:.4g}, {:.4g}) mm", expected, from[0],
                                               from[1], piece.to[0], piece.to[1]));
    };
    if (piece.to[1] < from[1] - kLevel) return refuse("heights that do not decrease");
    if (std::abs(piece.bulge) < 1e-9) {
      head.lineTo(to[0], to[1]);
      continue;
    }

    const Point center = OutlinePiece{from, to, piece.bulge}.center();
    const double side = piece.bulge > 0 ? 1 : -1;
    if (std::abs(piece.bulge) > 1 + kLevel || side * (from[0] - center[0]) < -kLevel ||
        side * (to[0] - center[0]) < -kLevel)
      return refuse("an arc whose heights do not decrease");
    if (piece.bulge < 0 && from[1] <= center[1] && to[1] >= center[1] && center[0] < (from - center).norm())
      return refuse("an arc that stays off the axis");
    piece.bulge > 0 ? head.arcTo(center, to) : head.hollowArcTo(center, to);
  }
  if (!(head.highest() > 0 && head.highest() <= kLongest))
    return wrong("profile_file", fmt::format("a head up to {} mm long, not {:.4g} mm", kLongest, head.highest()),
                 "the unit of the drawing: $INSUNITS in DXF, width and height in SVG");
  return head.close();
}

Outline freeOutline(const Numbers& n) {
  if (!n.outline.empty()) return drawnOutline(n.outline);
  RevolvedProfile head;
  for (std::size_t i = 0; i < n.profile.size(); ++i) {
    const ProfilePoint& p = n.profile[i];
    const Point from = head.end(), to(0.5 * p.diameter, p.height);
    if (p.arc_radius == 0) {
      head.lineTo(to[0], to[1]);
      continue;
    }

    const double half = 0.5 * (to - from).norm(), radius = std::abs(p.arc_radius);
    const std::string which = fmt::format("point {}: ", i + 1);
    if (i == 0 || half <= 0) return wrong("profile", which + "two numbers: no arc leads here");
    if (radius < half)
      return wrong(
          "profile",
          fmt::format("{}an arc radius of at least {:.4g} mm, half the way from the point before", which, half),
          fmt::format("{:.4g} for a half circle", half));

    // The centre lies beside the middle of the segment: inwards (left of it) for a bulge.
    const Point along = (to - from) / (2 * half), left(-along[1], along[0]);
    const double off = std::sqrt(std::max(0.0, radius * radius - half * half));
    const Point center = 0.5 * (from + to) + (p.arc_radius > 0 ? off : -off) * left;
    const double side = p.arc_radius > 0 ? 1 : -1;  // heights never decrease: the arc stays on one side of its centre
    if (side * (from[0] - center[0]) < -1e-9 || side * (to[0] - center[0]) < -1e-9)
      return wrong("profile", which + "an arc whose heights do not decrease", "a larger arc radius");
    if (p.arc_radius < 0 && from[1] <= center[1] && to[1] >= center[1] && center[0] - radius < 0)
      return wrong("profile", which + "an arc that stays off the axis", "a larger arc radius");

    p.arc_radius > 0 ? head.arcTo(center, to) : head.hollowArcTo(center, to);
  }
  return head.close();
}

}  // namespace

std::span<const HeadKey> headKeys() {
  static const HeadKey kKeys[] = {
      {"head_diameter", 0.1, 50, "mm", &Numbers::head_diameter, "the widest of the head"},
      {"head_length", 0.05, 50, "mm", &Numbers::head_length, "from the tip to the head's top"},
      {"tip_diameter", 0.01, 50, "mm", &Numbers::tip_diameter, "at the tip"},
      {"top_diameter", 0.01, 50, "mm", &Numbers::top_diameter, "at the head's top"},
      {"widest_at", 0.01, 50, "mm", &Numbers::widest_at, "height above the tip where the head is widest"},
      {"edge_radius", 0, 25, "mm", &Numbers::edge_radius, "radius that rounds the edge of a flat end"},
      {"point_length", 0.01, 50, "mm", &Numbers::point_length, "height of the pointed end"},
      {"point_angle", 10, 179, "degrees", &Numbers::point_angle, "whole angle at the point"},
      {"dome_height", 0.01, 25, "mm", &Numbers::dome_height, "height of the domed end"},
  };
  return kKeys;
}

std::span<const HeadShape> headShapes() {
  static const std::vector<HeadShape> kShapes{
      {"round", "ball; all of it cuts, the neck begins inside its cap", {}, false, round},
      {"cylinder", "flat end", {{"head_length", 3}, {"edge_radius", 0.1, "sharp"}}, false, cylinder},
      {"cylinder_round", "hemispherical end", {{"head_length", 3}}, false, cylinderRound},
      {"domed",
       "cylinder with a shallow spherical end",
       {{"head_length", 3}, {"dome_height", 0.25, "a quarter of head_diameter"}},
       false,
       domed},
      {"taper_flat",
       "cone with a flat end of tip_diameter, head_diameter at the top",
       {{"head_length", 4}, {"tip_diameter", 0.6}, {"edge_radius", 0.1, "sharp"}},
       false,
       taperFlat},
      {"taper_round",
       "cone that touches a sphere of tip_diameter, head_diameter at the top",
       {{"head_length", 5}, {"tip_diameter", 0.625}},
       false,
       taperRound},
      {"cone", "sharp point, head_diameter at the top", {{"head_length", 4}}, false, cone},
      {"needle",
       "slender taper_round",
       {{"head_length", 6}, {"tip_diameter", 0.125, "an eighth of head_diameter"}},
       false,
       needle},
      {"torpedo",
       "pointed arch that runs into the side without a kink; tip_diameter is where the point ends",
       {{"head_length", 5}, {"point_length", 0.9}, {"tip_diameter", 0.9, "head_diameter: parallel sides"}},
       false,
       torpedo},
      {"inverted_cone",
       "widest at its flat end, narrows to top_diameter",
       {{"head_length", 0.85}, {"top_diameter", 0.75}, {"edge_radius", 0.1, "sharp"}},
       false,
       invertedCone},
      {"pear",
       "ball of head_diameter, then a cone that narrows to top_diameter",
       {{"head_length", 1.6}, {"top_diameter", 0.75}},
       false,
       pear},
      {"flame",
       "long arc from a point to the widest, short one back",
       {{"head_length", 5},
        {"widest_at", 3.25, "0.65 head_length"},
        {"tip_diameter", 0.1, "sharp"},
        {"top_diameter", 0.7, "0.7 head_diameter"}},
       false,
       flame},
      {"bud",
       "short flame",
       {{"head_length", 2.2},
        {"widest_at", 1.2, "0.55 head_length"},
        {"tip_diameter", 0.1, "sharp"},
        {"top_diameter", 0.6, "0.6 head_diameter"}},
       false,
       bud},
      {"football",
       "egg: arcs about the middle, round tip",
       {{"head_length", 1.9},
        {"widest_at", 0.95, "0.5 head_length"},
        {"tip_diameter", 0.5, "half of head_diameter"},
        {"top_diameter", 0.5, "half of head_diameter"}},
       false,
       football},
      {"acorn",
       "arc from a blunt point to a straight wall",
       {{"head_length", 0.95},
        {"widest_at", 0.62, "0.65 head_length"},
        {"tip_diameter", 0.25, "a quarter of head_diameter"},
        {"top_diameter", 1, "head_diameter"}},
       false,
       acorn},
      {"wheel", "disc with a round rim; head_length is its thickness", {{"head_length", 0.4}}, false, wheel},
      {"drill", "cylinder with a conical point", {{"head_length", 5}, {"point_angle", 120}}, false, drill},
      {"profile", "any other head, corner by corner or from a drawing; ends are closed flat", {}, true, freeOutline},
  };
  return kShapes;
}

const HeadShape* findHeadShape(const std::string& name) {
  for (const HeadShape& shape : headShapes())
    if (name == shape.name) return &shape;
  return nullptr;
}

}  // namespace kerf
