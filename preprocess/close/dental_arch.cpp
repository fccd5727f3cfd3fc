#include "preprocess/close/dental_arch.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kBelow = 4, kAbove = 2;  // mm of the plane
constexpr double kFacing = 0.3;           // cosine of the angle to the normal
constexpr double kLeastGap = 60;          // degrees: the back of an arch
constexpr double kLeastReach = 50;        // degrees to either side of the midline
constexpr double kMostReach = 80;         // beyond it only half a tooth is visible: the curve would turn round its back
constexpr double kLeastDepth = 0.45;      // of the width: a quadrant is a flat arch about another axis
constexpr double kMostScatter = 5;        // mm rms about the curve
constexpr double kLeastRadius = 8;        // mm
constexpr double kMostInside = 0.1;       // of the area, nearer than half the radius
constexpr double kLeastCovered = 0.5;     // of the angles between the ends
constexpr double kCovered = 1;            // mm^2: of a step of the angle that has teeth
constexpr double kAngleStep = 5;          // degrees
constexpr int kDegreeOfCurve = 6;

using Vec2 = Eigen::Vector2d;

/// A bit of the row of teeth, seen along the normal.
struct Bit {
  Vec2 at;      // mm
  double area;  // mm^2
};

std::vector<Bit> rowOf(const Mesh& mesh, const OcclusalPlane& plane, const Vec3d& u, const Vec3d& v) {
  std::vector<Bit> out;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3d twice = doubleAreaVector(mesh, t);
    const double along = twice.dot(plane.normal);
    if (along <= kFacing * twice.norm()) continue;
    const Vec3d middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3 - plane.point;
    const double height = middle.dot(plane.normal);
    if (height < -kBelow || height > kAbove) continue;
    out.push_back({{middle.dot(u), middle.dot(v)}, 0.5 * along});
  }
  return out;
}

Vec2 meanOf(const std::vector<Bit>& row) {
  Vec2 sum = Vec2::Zero();
  double area = 0;
  for (const Bit& bit : row) {
    sum += bit.area * bit.at;
    area += bit.area;
  }
  return sum / area;
}

/// The angle in the middle of the widest gap around a point, rad. None: no gap is as wide as the back of an arch.
std::optional<double> gapAround(const std::vector<Bit>& row, const Vec2& middle) {
  constexpr int kBins = 72;
  std::array<double, kBins> area{};
  for (const Bit& bit : row) {
    const Vec2 off = bit.at - middle;
    const double turn = std::atan2(off.y(), off.x()) / (2 * std::numbers::pi) + 0.5;
    area[static_cast<std::size_t>(std::clamp(static_cast<int>(turn * kBins), 0, kBins - 1))] += bit.area;
  }

  int best = 0, best_end = 0, run = 0;
  for (int n = 0; n < 2 * kBins; ++n) {  // twice round: a gap may go over the end
    run = area[static_cast<std::size_t>(n % kBins)] < kCovered ? run + 1 : 0;
    if (run <= best || run > kBins) continue;
    best = run;
    best_end = n + 1;
  }
  if (best * 360 / kBins < kLeastGap) return {};
  return ((best_end - 0.5 * best) / kBins - 0.5) * 2 * std::numbers::pi;
}

/// An axis in the plane.
struct Axis {
  Vec2 point = Vec2::Zero();   // mm
  Vec2 front = Vec2::UnitY();  // unit
  Vec2 right() const { return {front.y(), -front.x()}; }
};

/// Overlap of the row with its mirror image, mm^2. The picture of the row has cells of 1 mm, and is blurred by as much:
/// real teeth are no mirror images to the millimetre.
class Mirror {
 public:
  Mirror(const std::vector<Bit>& row, const Vec2& middle) : middle_(middle) {
    std::vector<double> sharp(kSide * kSide, 0.0);
    for (const Bit& bit : row)
      if (const auto n = cell(bit.at)) sharp[*n] += bit.area;
    for (double& area : sharp) area = std::min(area, 1.0);  // a steep or doubled surface counts once

    blurred_.assign(kSide * kSide, 0.0);
    for (std::size_t y = 1; y + 1 < kSide; ++y)
      for (std::size_t x = 1; x + 1 < kSide; ++x) {
        double sum = 0;
        for (std::size_t dy = 0; dy < 3; ++dy)
          for (std::size_t dx = 0; dx < 3; ++dx) sum += sharp[(y + dy - 1) * kSide + x + dx - 1];
        blurred_[y * kSide + x] = sum / 9;
        if (sharp[y * kSide + x] > 0) cells_.push_back(middle_ + Vec2(x + 0.5, y + 0.5) - Vec2::Constant(0.5 * kSide));
      }
  }

  double likeness(const Axis& axis) const {
    double sum = 0;
    const Vec2 right = axis.right();
    for (const Vec2& p : cells_)
      if (const auto n = cell(p - 2 * right.dot(p - axis.point) * right)) sum += blurred_[*n];
    return sum;
  }

 private:
  static constexpr std::size_t kSide = 160;  // cells
  std::optional<std::size_t> cell(const Vec2& p) const {
    const Vec2 at = p - middle_ + Vec2::Constant(0.5 * kSide);
    if (!(at.minCoeff() >= 0 && at.maxCoeff() < kSide)) return {};
    return static_cast<std::size_t>(at.y()) * kSide + static_cast<std::size_t>(at.x());
  }

  Vec2 middle_;
  std::vector<double> blurred_;
  std::vector<Vec2> cells_;  // that have teeth: their middles
};

Axis midlineOf(const std::vector<Bit>& row, const Vec2& middle, const Vec2& front) {
  constexpr int kMostTurn = 30, kMostAside = 8;  // degrees, mm
  const Mirror mirror(row, middle);
  Axis best;
  double most = -1;
  for (int turn = -kMostTurn; turn <= kMostTurn; ++turn)
    for (int aside = -2 * kMostAside; aside <= 2 * kMostAside; ++aside) {
      Axis axis{middle, Eigen::Rotation2Dd(turn * kDegree) * front};
      axis.point += 0.5 * aside * axis.right();
      const double likeness = mirror.likeness(axis);
      if (likeness <= most) continue;
      most = likeness;
      best = axis;
    }
  return best;
}

/// The row about the origin: its angle from the front, rad, growing to the right, and its radius, mm.
struct Polar {
  double angle, radius, area;
};

double valueOf(const Eigen::VectorXd& curve, double angle) {
  double out = 0;
  for (Eigen::Index n = curve.size(); n-- > 0;) out = out * angle + curve[n];
  return out;
}

Eigen::VectorXd fit(const std::vector<Polar>& row) {
  constexpr int kTerms = kDegreeOfCurve + 1;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(kTerms, kTerms);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(kTerms);
  for (const Polar& bit : row) {
    Eigen::VectorXd powers(kTerms);
    powers[0] = 1;
    for (int n = 1; n < kTerms; ++n) powers[n] = powers[n - 1] * bit.angle;
    normal += bit.area * powers * powers.transpose();
    right += bit.area * bit.radius * powers;
  }
  return normal.ldlt().solve(right);
}

/// From where to where there are teeth, degrees. None: it does not reach round, or has too many gaps.
struct Reach {
  double from, to;
};
std::optional<Reach> reachOf(const std::vector<Polar>& row) {
  constexpr int kBins = static_cast<int>(190 / kAngleStep);
  constexpr double kFirst = -0.5 * kBins * kAngleStep;
  std::array<double, kBins> area{};
  for (const Polar& bit : row) {
    const int n = static_cast<int>(std::floor((bit.angle / kDegree - kFirst) / kAngleStep));
    if (n >= 0 && n < kBins) area[static_cast<std::size_t>(n)] += bit.area;
  }
  const auto is_covered = [](double mm2) { return mm2 >= kCovered; };
  const auto first = std::find_if(area.begin(), area.end(), is_covered);
  const auto last = std::find_if(area.rbegin(), area.rend(), is_covered).base();
  if (first >= last) return {};
  if (std::count_if(first, last, is_covered) < kLeastCovered * static_cast<double>(last - first)) return {};

  const Reach out{kFirst + kAngleStep * static_cast<double>(first - area.begin()),
                  kFirst + kAngleStep * static_cast<double>(last - area.begin())};
  if (out.from > -kLeastReach || out.to < kLeastReach) return {};
  return out;
}

bool isRow(const std::vector<Polar>& row, const Eigen::VectorXd& curve) {
  double area = 0, squares = 0, inside = 0;
  for (const Polar& bit : row) {
    const double radius = valueOf(curve, bit.angle);
    area += bit.area;
    squares += bit.area * (bit.radius - radius) * (bit.radius - radius);
    if (bit.radius < 0.5 * radius) inside += bit.area;
  }
  return std::sqrt(squares / area) <= kMostScatter && inside <= kMostInside * area;
}

}  // namespace

std::size_t DentalArch::nearest(const Vec3d& p) const {
  const auto off = [&](const Vec3d& q) {
    const Vec3d d = p - q;
    return (d - occlusal.dot(d) * occlusal).squaredNorm();
  };
  std::size_t best = 0;
  for (std::size_t n = 1; n < curve.size(); ++n)
    if (off(curve[n]) < off(curve[best])) best = n;
  return best;
}

ToothSides DentalArch::sidesAt(const Vec3d& p) const {
  const std::size_t n = nearest(p), before = n > 0 ? n - 1 : 0, after = std::min(n + 1, curve.size() - 1);
  const Vec3d along = (curve[after] - curve[before]).normalized();
  ToothSides out;
  out.occlusal = occlusal;
  out.buccal = along.cross(occlusal).normalized();
  if (out.buccal.dot(curve[n] - origin) < 0) out.buccal = -out.buccal;
  out.mesial = n < middle ? along : Vec3d(-along);
  return out;
}

std::optional<DentalArch> findDentalArch(const Mesh& mesh, const OcclusalPlane& plane) {
  int least = 0;
  plane.normal.cwiseAbs().minCoeff(&least);
  const Vec3d u = (Vec3d::Unit(least) - plane.normal[least] * plane.normal).normalized(), v = plane.normal.cross(u);
  const std::vector<Bit> row = rowOf(mesh, plane, u, v);
  if (row.empty()) return {};

  // Where the back is, then the midline.
  const Vec2 middle = meanOf(row);
  const auto gap = gapAround(row, middle);
  if (!gap) return {};
  Axis axis = midlineOf(row, middle, -Vec2(std::cos(*gap), std::sin(*gap)));

  // The origin level with the hindmost teeth: there the curve is square to the radius.
  std::vector<double> heights;
  for (const Bit& bit : row) heights.push_back(axis.front.dot(bit.at - axis.point));
  const auto hindmost = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 50);
  std::nth_element(heights.begin(), hindmost, heights.end());
  axis.point += *hindmost * axis.front;

  std::vector<Polar> polar;
  for (const Bit& bit : row) {
    const Vec2 off = bit.at - axis.point;
    polar.push_back({std::atan2(axis.right().dot(off), axis.front.dot(off)), off.norm(), bit.area});
  }
  std::erase_if(polar, [](const Polar& bit) { return std::abs(bit.angle) > 95 * kDegree; });
  const auto reach = reachOf(polar);
  if (!reach) return {};
  const Eigen::VectorXd radii = fit(polar);
  if (!isRow(polar, radii)) return {};

  DentalArch out;
  const auto inSpace = [&](const Vec2& p) { return Vec3d(p.x() * u + p.y() * v); };
  out.origin = plane.point + inSpace(axis.point);
  out.occlusal = plane.normal;
  out.front = inSpace(axis.front);
  const Vec3d right = inSpace(axis.right());
  const double from = std::max(reach->from, -kMostReach), to = std::min(reach->to, kMostReach);
  for (double degrees = from; degrees <= to; ++degrees) {
    const double angle = degrees * kDegree, radius = valueOf(radii, angle);
    if (radius < kLeastRadius) return {};
    if (degrees == 0) out.middle = out.curve.size();
    out.curve.push_back(out.origin + radius * (std::cos(angle) * out.front + std::sin(angle) * right));
  }
  const double depth = out.front.dot(out.curve[out.middle] - out.origin);
  const double width = right.dot(out.curve.back() - out.curve.front());
  if (depth < kLeastDepth * width) return {};
  return out;
}

}  // namespace kerf
