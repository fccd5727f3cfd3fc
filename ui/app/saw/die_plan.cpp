#include "ui/app/saw/die_plan.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

constexpr double kDieDegree = std::numbers::pi / 180;
constexpr double kStation = 0.25;                // mm along the row
constexpr double kLookedAlong = 10;              // mm: an end is searched so far from the point
constexpr double kLeastHalf = 1;                 // mm: the ends are at least so far from the point
constexpr double kHalfWide = 7;                  // mm to either side of the row's line
constexpr double kUnderTop = 4, kOverTop = 1.5;  // mm: heights that count as the crown's upper part
constexpr double kSampled = 0.3;                 // mm
constexpr double kContactShare = 0.8;            // of the sections to both sides: a contact. Fissures: above 0.9
constexpr double kGapShare = 0.3;                // of the tooth's section: a gap
constexpr std::size_t kAroundMinimum = 4, kNextTooth = 16;  // stations
constexpr double kMostYaw = 12, kYawStep = 3;               // degrees
constexpr double kContact = 2;          // mm under the top: there the ends stay in place for any taper
constexpr double kCrown = 7;            // mm under the top: the sides beside the tooth leave this whole
constexpr double kBesideCrown = 0.4;    // mm
constexpr double kAcrossArch = 15;      // mm: with two sides a third plane spares the other side of the arch
constexpr double kRoom = 25;            // mm from the tooth: half the side of the room that is looked at
constexpr double kWall = 1;             // mm of the die around the pin hole
constexpr double kBeyondUnderside = 1;  // mm
constexpr double kTooth = 5;            // mm around the point

tl::unexpected<Error> noDie(std::string found, std::string expected, std::string hint) {
  return fail({.code = Error::Code::kGeometry,
               .place = "die",
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = std::move(hint)});
}

/// A place on the line of the row of teeth.
struct Station {
  Vec3d point;
  Vec3d along;  // unit, in the occlusal plane, to the mesial side
};

Vec3d flattened(const Vec3d& v, const Vec3d& occlusal) { return v - occlusal.dot(v) * occlusal; }

// ---- The line of the row

// Station `mm` from the curve point nearest to the tooth; straight beyond the curve's ends.
Station stationOn(const DentalArch& arch, std::size_t nearest, int step, double mm) {
  const auto last = static_cast<int>(arch.curve.size()) - 1;
  int n = static_cast<int>(nearest);
  int by = mm < 0 ? -step : step;
  double left = std::abs(mm);
  while (n + by >= 0 && n + by <= last) {
    const Vec3d way = arch.curve[static_cast<std::size_t>(n + by)] - arch.curve[static_cast<std::size_t>(n)];
    if (way.norm() >= left) break;
    left -= way.norm();
    n += by;
  }
  const int a = std::clamp(n - step, 0, last), b = std::clamp(n + step, 0, last);
  const Vec3d along =
      flattened(arch.curve[static_cast<std::size_t>(b)] - arch.curve[static_cast<std::size_t>(a)], arch.occlusal)
          .normalized();
  return {arch.curve[static_cast<std::size_t>(n)] + (mm < 0 ? -left : left) * along, along};
}

class Row {
 public:
  Row(const Vec3d& at, const OcclusalSide& occlusal, const Mesh& solid) : occlusal_(*occlusal.normal) {
    if (occlusal.arch) {
      arch_ = &*occlusal.arch;
      occlusal_ = arch_->occlusal;
      frame_ = {arch_->sidesAt(at), true};
      nearest_ = arch_->nearest(at);
      step_ = nearest_ < arch_->middle ? 1 : -1;
      return;
    }
    // Without an arch: the longest direction of the upper surface around the tooth.
    constexpr double kAround = 12;  // mm
    double top = -1e9;
    for (const Vec3d& v : solid.vertices)
      if (flattened(v - at, occlusal_).norm() < kTooth) top = std::max(top, occlusal_.dot(v));
    Vec3d sum = Vec3d::Zero();
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    double count = 0;
    for (const Vec3d& v : solid.vertices) {
      const Vec3d d = flattened(v - at, occlusal_);
      if (d.norm() > kAround || occlusal_.dot(v) < top - kUnderTop) continue;
      sum += d;
      spread += d * d.transpose();
      ++count;
    }
    const Vec3d mean = sum / std::max(count, 1.0);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread / std::max(count, 1.0) - mean * mean.transpose());
    ToothSides sides;
    sides.occlusal = occlusal_;
    sides.mesial = flattened(axes.eigenvectors().col(2), occlusal_).normalized();
    sides.buccal = sides.mesial.cross(occlusal_);
    frame_ = {sides, false};
    middle_ = at + mean.dot(sides.buccal) * sides.buccal;
  }

  const Vec3d& occlusal() const { return occlusal_; }
  const DieFrame& frame() const { return frame_; }
  Station at(double mm) const {
    if (arch_) return stationOn(*arch_, nearest_, step_, mm);
    return {middle_ + mm * frame_.sides.mesial, frame_.sides.mesial};
  }

 private:
  const DentalArch* arch_ = nullptr;
  std::size_t nearest_ = 0;
  int step_ = 1;
  Vec3d occlusal_, middle_ = Vec3d::Zero();
  DieFrame frame_;
};

// ---- The ends

// Area of the crown's upper part in the plane square to the row, mm^2.
double crownArea(const Station& s, const Vec3d& occlusal, double top, double yaw_deg, const BrickField& bone) {
  const Vec3d along = Eigen::AngleAxisd(yaw_deg * kDieDegree, occlusal) * s.along;
  const Vec3d across = occlusal.cross(along);
  const Vec3d base = s.point - occlusal.dot(s.point) * occlusal;
  int inside = 0;
  for (double w = -kHalfWide; w <= kHalfWide; w += kSampled)
    for (double h = top - kUnderTop; h <= top + kOverTop; h += kSampled)
      inside += bone.sample(base + w * across + h * occlusal) < 0;
  return kSampled * kSampled * inside;
}

// The end of the tooth towards mesial (direction 1) or distal (-1).
Station endOf(const Row& row, double direction, double top, const BrickField& bone) {
  std::vector<double> areas;
  for (double mm = 0; mm <= kLookedAlong; mm += kStation)
    areas.push_back(crownArea(row.at(direction * mm), row.occlusal(), top, 0, bone));
  const auto first = static_cast<std::size_t>(kLeastHalf / kStation);
  const auto from = [&](std::size_t n) {
    return areas.begin() + static_cast<std::ptrdiff_t>(std::min(n, areas.size()));
  };
  std::size_t at = static_cast<std::size_t>(std::min_element(from(first), areas.end()) - areas.begin());
  for (std::size_t n = first; n < areas.size(); ++n) {
    const double least = *std::min_element(from(n - std::min(n, kAroundMinimum)), from(n + kAroundMinimum + 1));
    const double inner = *std::max_element(from(0), from(n + 1));
    const double outer = *std::max_element(from(n), from(n + kNextTooth));
    const bool is_end = areas[n] < std::max(kContactShare * std::min(inner, outer), kGapShare * inner);
    if (areas[n] > least || !is_end) continue;
    at = n;
    break;
  }
  Station out = row.at(direction * kStation * static_cast<double>(at));
  double best = areas[at], yaw = 0;
  for (double deg = -kMostYaw; deg <= kMostYaw; deg += kYawStep) {
    const double area = crownArea(out, row.occlusal(), top, deg, bone);
    if (area < 0.97 * best) {
      best = area;
      yaw = deg;
    }
  }
  out.along = Eigen::AngleAxisd(yaw * kDieDegree, row.occlusal()) * out.along;
  return out;
}

// ---- The die between its planes

Plane planeOfSide(const Vec3d& outwards, const Vec3d& at, const Vec3d& occlusal, double taper_deg) {
  const double taper = taper_deg * kDieDegree;
  return {at, (-std::cos(taper) * outwards + std::sin(taper) * occlusal).normalized()};
}

double heightIn(std::span<const SawPlane> planes, const Vec3d& p) {
  double out = 1e9;
  for (const SawPlane& plane : planes) out = std::min(out, plane.normal.dot(p - plane.point));
  return out;
}

// Corners of the die at a height, as seen along the normal; a square of the room where no plane cuts it.
std::vector<Vec3d> outlineAt(std::span<const SawPlane> sides, const Vec3d& at, const Vec3d& occlusal, double height) {
  const Vec3d u = occlusal.unitOrthogonal(), v = occlusal.cross(u);
  const Vec3d middle = at + (height - occlusal.dot(at)) * occlusal;
  std::vector<Vec3d> out;
  for (const auto& [i, j] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
    out.push_back(middle + kRoom * (i * u + j * v));
  for (const SawPlane& plane : sides) {
    std::vector<Vec3d> left;
    for (std::size_t n = 0; n < out.size(); ++n) {
      const Vec3d &a = out[n], &b = out[(n + 1) % out.size()];
      const double high = plane.normal.dot(a - plane.point), next = plane.normal.dot(b - plane.point);
      if (high >= 0) left.push_back(a);
      if ((high >= 0) != (next >= 0)) left.push_back(a + high / (high - next) * (b - a));
    }
    out = std::move(left);
  }
  return out;
}

// Lowest height with material under the die.
std::optional<double> undersideOf(std::span<const SawPlane> planes, const Vec3d& at, const Vec3d& occlusal,
                                  const BrickField& bone, double from, double to) {
  const Vec3d u = occlusal.unitOrthogonal(), v = occlusal.cross(u);
  const double step = 0.5 * bone.voxel();
  std::optional<double> out;
  for (double i = -kRoom; i <= kRoom; i += 1)
    for (double j = -kRoom; j <= kRoom; j += 1) {
      const Vec3d foot = at - occlusal.dot(at) * occlusal + i * u + j * v;
      if (heightIn(planes, foot + to * occlusal) < 0) continue;
      for (double h = from; h < out.value_or(to); h += step)
        if (bone.sample(foot + h * occlusal) < 0) {
          out = h;
          break;
        }
    }
  return out;
}

// A wall of the model left beside the die would be thinner than 1 mm in places: the plane moves out, past the wall,
// unless that is thick elsewhere.
void spareThinWalls(SawPlane& side, std::span<const SawPlane> ends, const Vec3d& occlusal, double from, double to,
                    const BrickField& bone) {
  constexpr double kThin = 1, kThick = 5, kThinShare = 0.1, kOutside = 0.5, kStep = 0.2;  // mm
  const Vec3d outwards = -flattened(side.normal, occlusal).normalized(), across = side.across();
  const Vec3d down = side.approach / -occlusal.dot(side.approach);  // by 1 mm of height
  int walls = 0, thin = 0;
  double thickest = 0;
  for (double h = from; h <= to; h += 1)
    for (double w = -kLookedAlong; w <= kLookedAlong; w += 1) {
      const Vec3d p = side.point + (occlusal.dot(side.point) - h) * down + w * across;
      if (heightIn(ends, p) < 0 || bone.sample(p) >= 0) continue;
      double wall = kStep;
      while (wall < kThick && bone.sample(p + wall * outwards) < 0) wall += kStep;
      ++walls;
      thin += wall < kThin;
      thickest = std::max(thickest, wall);
    }
  if (thin > kThinShare * walls && thickest < kThick) side.point += (thickest + kOutside) * outwards;
}

// The rectangle of a side: from the outline at the top to that at the base.
void bound(SawPlane& plane, std::span<const Vec3d> corners) {
  constexpr double kOnPlane = 1e-6, kBeyond = 0.5;  // mm
  double low_u = 1e9, high_u = -1e9, low_v = 1e9, high_v = -1e9;
  for (const Vec3d& corner : corners) {
    const Vec3d p = plane.toPlane(corner);
    if (std::abs(p[2]) > kOnPlane) continue;
    low_u = std::min(low_u, p[0]);
    high_u = std::max(high_u, p[0]);
    low_v = std::min(low_v, p[1]);
    high_v = std::max(high_v, p[1]);
  }
  if (!(high_u > low_u)) return;
  plane.point = plane.fromPlane(0.5 * (low_u + high_u), low_v - kBeyond);
  plane.width = std::clamp(high_u - low_u + 2 * kBeyond, SawPlan::kLeastSide, SawPlan::kMostSide);
  plane.depth = std::clamp(high_v - low_v + 2 * kBeyond, SawPlan::kLeastSide, SawPlan::kMostSide);
}

double topNear(const Mesh& solid, const Vec3d& at, const Vec3d& occlusal) {
  double out = occlusal.dot(at);
  for (const Vec3d& v : solid.vertices) {
    const Vec3d d = v - at;
    if (flattened(d, occlusal).norm() < kTooth) out = std::max(out, occlusal.dot(v));
  }
  return out;
}

}  // namespace

Expected<DiePlan> planDie(const Vec3d& at, const OcclusalSide& side, const Mesh& solid, const BrickField& bone,
                          const DieChoice& choice) {
  if (!side.normal)
    return noDie("no upper side: no base, and no cusp tips to find it from", "a jaw with teeth",
                 "plan planes by saw.line, then plane.cut");
  const Row row(at, side, solid);
  const Vec3d occlusal = row.occlusal();
  const double top = topNear(solid, at, occlusal);
  const auto onHeight = [&](const Vec3d& p, double height) -> Vec3d {
    return p + (height - occlusal.dot(p)) * occlusal;
  };

  DiePlan out;
  out.frame = row.frame();
  const auto add = [&](const char* name, const Plane& plane, const Vec3d& approach) {
    SawPlane& made = out.planes.emplace_back();
    made.name = name;
    made.normal = plane.normal;
    made.point = plane.point;
    made.approach = (approach - made.normal.dot(approach) * made.normal).normalized();
  };
  const bool is_named = out.frame.is_of_arch;
  for (const double direction : {1.0, -1.0}) {
    const Station end = endOf(row, direction, top, bone);
    const Vec3d point = onHeight(end.point, top - kContact);
    add(direction > 0 ? (is_named ? "mesial" : "end 1") : (is_named ? "distal" : "end 2"),
        planeOfSide(direction * end.along, point, occlusal, choice.taper_deg), -occlusal);
  }

  // Beside the tooth: clear of the crown.
  const Vec3d middle = onHeight(row.at(0).point, top - kCrown);
  for (const double direction : {1.0, -1.0}) {
    const Vec3d outwards = direction * out.frame.sides.buccal;
    double away = 0;
    if (choice.has_four_sides) {
      for (const Vec3d& v : solid.vertices) {
        const Vec3d d = v - middle;
        const double above = occlusal.dot(d), beside = outwards.dot(d);
        if (above < 0 || beside > kHalfWide + 2 || heightIn({out.planes.data(), 2}, v) < 0) continue;
        away = std::max(away, beside - std::tan(choice.taper_deg * kDieDegree) * above);
      }
      away += kBesideCrown / std::cos(choice.taper_deg * kDieDegree);
    } else if (direction < 0) {
      away = kAcrossArch;
    } else {
      continue;
    }
    add(direction > 0 ? (is_named ? "buccal" : "side 1") : (is_named ? "lingual" : "side 2"),
        planeOfSide(outwards, middle + away * outwards, occlusal, choice.taper_deg), -occlusal);
  }

  double lowest = top;
  for (const Vec3d& v : solid.vertices) lowest = std::min(lowest, occlusal.dot(v));
  const auto underside = undersideOf(out.planes, at, occlusal, bone, lowest - 0.5, top - kCrown);
  if (!underside)
    return noDie("no model under the tooth", "a closed model with a base", "close the scan with a base first");
  const double base = *underside + choice.base_mm;
  if (base > top - kCrown)
    return noDie(fmt::format("a base {:.1f} mm above the underside, {:.1f} mm under the top of the tooth",
                             choice.base_mm, top - base),
                 fmt::format("at most {:.1f} mm above the underside", top - kCrown - *underside),
                 "lower it: plane.die-set base MM");

  if (choice.has_four_sides)
    for (std::size_t n = 2; n < 4; ++n)
      spareThinWalls(out.planes[n], {out.planes.data(), 2}, occlusal, base, top - kCrown, bone);

  std::vector<Vec3d> corners = outlineAt(out.planes, at, occlusal, top);
  const std::vector<Vec3d> at_base = outlineAt(out.planes, at, occlusal, base);
  if (at_base.size() < 3)
    return noDie("sides that meet above the base", "a die that reaches its base",
                 "less taper: plane.die-set taper DEG");
  corners.insert(corners.end(), at_base.begin(), at_base.end());
  for (SawPlane& plane : out.planes) bound(plane, corners);
  if (choice.base_mm > 0) {
    Vec3d centre = Vec3d::Zero();
    for (const Vec3d& p : at_base) centre += p / static_cast<double>(at_base.size());
    add("base", {centre, occlusal}, -out.frame.sides.buccal);
    bound(out.planes.back(), at_base);
  }
  return out;
}

Expected<RoundHole> pinOf(std::span<const SawPlane> planes, const Vec3d& occlusal, const Vec3d& at,
                          const BrickField& bone, const DieChoice& choice) {
  const Vec3d u = occlusal.unitOrthogonal(), v = occlusal.cross(u);
  const double top = occlusal.dot(at), step = 0.5 * bone.voxel();
  double level = -1e9;  // of the die's base: of its plane, else of the underside
  for (const SawPlane& plane : planes)
    if (plane.normal.dot(occlusal) > 0.9)
      level = std::max(level, occlusal.dot(plane.point + flattened(at - plane.point, plane.normal)));
  if (level < top - 2 * kRoom) {
    const auto base = undersideOf(planes, at, occlusal, bone, top - 2 * kRoom, top);
    if (!base) return noDie("nothing between the planes", "planes around a tooth", "click the tooth again");
    level = *base;
  }
  const Vec3d foot = at + (level + 0.05 - occlusal.dot(at)) * occlusal;

  Vec3d sum = Vec3d::Zero();
  int count = 0;
  for (double i = -kRoom; i <= kRoom; i += 0.5)
    for (double j = -kRoom; j <= kRoom; j += 0.5) {
      const Vec3d p = foot + i * u + j * v;
      if (heightIn(planes, p) < 0 || bone.sample(p) >= 0) continue;
      sum += p;
      ++count;
    }
  if (count == 0) return noDie("no base of the die", "planes around a tooth", "click the tooth again");
  const Vec3d centre = sum / count - 0.05 * occlusal;

  // Material all around the pin, up to the depth.
  const double radius = 0.5 * choice.pin_mm + kWall;
  const auto isInDie = [&](double above) {
    for (int n = 0; n < 12; ++n) {
      const double angle = n * std::numbers::pi / 6;
      const Vec3d p = centre + above * occlusal + radius * (std::cos(angle) * u + std::sin(angle) * v);
      if (heightIn(planes, p) < 0 || bone.sample(p) >= 0) return false;
    }
    return bone.sample(centre + above * occlusal) < 0;
  };
  double free = step;
  while (free < DieChoice::kMostPinDepth + kWall && isInDie(free)) free += step;
  const double most = free - kWall;
  if (most < choice.pin_depth_mm)
    return noDie(fmt::format("a pin hole of {:.1f} mm, {:.1f} mm deep in the die", choice.pin_mm, choice.pin_depth_mm),
                 most < 1 ? fmt::format("a base at least {:.1f} mm wide and high around it", 2 * radius)
                          : fmt::format("at most {:.1f} mm, to leave walls of {:.0f} mm", most, kWall),
                 most < 1 ? "a thinner pin, less taper, or no pin: plane.die-set pin 0"
                          : fmt::format("plane.die-set pin-depth {:.1f}", std::floor(10 * most) / 10));

  // From outside: the underside below the centre.
  double under = level;
  for (double h = level; h > top - 2 * kRoom; h -= step)
    if (bone.sample(centre + (h - level) * occlusal) < 0) under = h;
  const double begin = under - step - kBeyondUnderside;
  return RoundHole{centre + (begin - level) * occlusal, occlusal, choice.pin_mm, level - begin + choice.pin_depth_mm};
}

}  // namespace kerf
