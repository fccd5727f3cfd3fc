#include "preprocess/demo/demo_teeth.h"

#include <numbers>
#include <vector>

#include "preprocess/demo/implicit.h"

namespace kerf::internal {
namespace {

// ------------------------------------------------------------------------------- incisors, canine and premolars

struct Faces {
  double mesial, buccal, lingual;  ///< half widths at a height, mm; buccal and lingual are signed places on y
};

Faces facesAt(const ToothDimensions& t, double z) {
  const double h = t.crown, cx = 0.5 * t.cervix_mesiodistal, cy = 0.5 * t.cervix_buccolingual;
  const double mx = 0.5 * t.mesiodistal, by = 0.5 * t.buccolingual;
  if (z < 0) {  // the root narrows, slowly at first
    const double s = std::min(1.0, -z / t.root), k = 1 - 0.18 * s - 0.42 * s * s * s;
    return {cx * k, cy * k, -cy * k};
  }
  const double s = z / h;
  if (t.position <= 3) {
    const double widest = t.position == 3 ? 0.72 : 0.88;
    const std::array<Knot, 4> width = {
        {{0, cx}, {widest, mx}, {1.0, mx * (t.position == 3 ? 0.86 : 0.97)}, {1.2, mx * 0.7}}};
    const std::array<Knot, 5> front = {
        {{0, cy}, {0.22, by + 0.10}, {0.55, 0.72 * by}, {0.85, 0.36 * by}, {1.1, 0.12 * by}}};
    const std::array<Knot, 5> back = {{{0, -cy}, {0.16, -by}, {0.5, -0.46 * by}, {0.8, -0.22 * by}, {1.1, -0.14 * by}}};
    return {curve(width, s), curve(front, s), curve(back, s)};
  }
  const std::array<Knot, 4> width = {{{0, cx}, {0.62, mx}, {0.9, 0.9 * mx}, {1.15, 0.72 * mx}}};
  const std::array<Knot, 4> front = {{{0, cy}, {0.3, by}, {0.7, 0.82 * by}, {1.15, 0.50 * by}}};
  const std::array<Knot, 4> back = {{{0, -cy}, {0.45, -by}, {0.75, -0.9 * by}, {1.15, -0.6 * by}}};
  return {curve(width, s), curve(front, s), curve(back, s)};
}

/// Height of the incisal edge or the chewing surface, without fissures, mm.
double edgeHeight(const ToothDimensions& t, double x, double y) {
  const double soft_x = std::sqrt(x * x + 0.15) - std::sqrt(0.15);
  if (t.position <= 2) return t.crown - 0.03 * x * x + 0.12 * y;
  if (t.position == 3) return t.crown + 0.1 - 0.42 * soft_x - 0.10 * std::abs(y);
  const double by = 0.5 * t.buccolingual;
  const auto cusp = [&](double cx, double cy, double height) {
    const double dx = 0.55 * (x - cx), dy = 0.75 * (y - cy);
    return height - (std::sqrt(dx * dx + dy * dy + 0.12) - std::sqrt(0.12));
  };

  double height = cusp(0, 0.48 * by, t.crown);
  if (t.position == 4) {
    height = smoothMax(height, cusp(-0.3, -0.55 * by, t.crown - 2.3), 0.5);
  } else {  // two lingual cusps
    height = smoothMax(height, cusp(1.0, -0.58 * by, t.crown - 1.0), 0.4);
    height = smoothMax(height, cusp(-1.5, -0.55 * by, t.crown - 1.5), 0.4);
  }
  // Marginal ridges and the floor of the fossae.
  const double mx = 0.5 * t.mesiodistal, off = std::abs(x) - 0.80 * mx;
  height = smoothMax(height, t.crown - 1.9 + 0.04 * y * y - (std::sqrt(off * off + 0.15) - std::sqrt(0.15)), 0.4);
  return smoothMax(height, t.crown - 2.9, 0.5);
}
double fissure(const ToothDimensions& t, double x, double y) {
  if (t.position < 4) return 0;
  const double mx = 0.5 * t.mesiodistal, off = (y + 0.1 * t.buccolingual - 0.04 * x * x) / 0.45;
  return 0.5 / (1 + off * off) * (1 - smoothStep(0.45 * mx, 0.85 * mx, std::abs(x))) +
         0.3 * bell(std::hypot(std::abs(x) - 0.48 * mx, y + 0.1 * t.buccolingual), 0.55);
}

double neckHeight(const ToothDimensions& t, const Vec3d& p) {
  const double r2 = p.x() * p.x() + p.y() * p.y();
  const double rise = t.position <= 3 ? 1.0 : 0.4;  // the junction of front teeth is a deep arc
  return r2 > 1e-6 ? rise * (p.x() * p.x() - p.y() * p.y()) / r2 * smoothStep(0, 2, r2) : 0;
}

/// Distance, to first order, from the sides; `n` says how square the section is.
double sidesOf(const ToothDimensions& t, const Vec3d& p, double n) {
  const Faces f = facesAt(t, p.z());
  const double half_y = 0.5 * (f.buccal - f.lingual);
  // A little narrower on the lingual side.
  const double u = std::abs(p.x()) / (f.mesial * (1 + 0.03 * p.y())),
               v = std::abs(p.y() - 0.5 * (f.buccal + f.lingual)) / half_y;
  const double k = roundedNorm(u, v, n);
  if (k < 1e-6) return -std::min(f.mesial, half_y);
  const double gu = std::pow(u / k, n - 1) / f.mesial, gv = std::pow(v / k, n - 1) / half_y;
  return (k - 1) / std::hypot(gu, gv);
}

double crownOf(const ToothDimensions& t, const Vec3d& p) {
  const double top = 0.85 * (p.z() - edgeHeight(t, p.x(), p.y()) + fissure(t, p.x(), p.y()));
  return smoothMax(sidesOf(t, p, 2.4), top, t.position <= 2 ? 0.5 : 0.9);
}

double simpleTooth(const ToothDimensions& t, const Vec3d& p) {
  if (p.z() > 0) return crownOf(t, p) + 0.08 * (1 - smoothStep(-0.15, 0.4, p.z() - neckHeight(t, p)));
  const double lip = 0.08 * (1 - smoothStep(-0.15, 0.4, p.z() - neckHeight(t, p)));
  return smoothMax(sidesOf(t, p, 2.4) + lip, -t.root - p.z(), 2.2);
}

double simpleEnamel(const ToothDimensions& t, const Vec3d& p) {
  constexpr double kBeyond = 0.3;  // mm that the solid reaches out of the tooth
  const double neck = neckHeight(t, p), up = std::clamp((p.z() - neck) / (0.5 * t.crown), 0.0, 1.0);
  const bool front = t.position <= 3;
  const double sides = sidesOf(t, p, 2.4) + (front ? 0.85 : 1.25) * up * (2 - up);
  const double top = 0.85 * (p.z() - edgeHeight(t, p.x(), p.y())) + (front ? 1.9 : 1.5);
  const double junction = smoothMax(sides, top, 0.8);
  const double inside = smoothMax(simpleTooth(t, p) - kBeyond, neck - p.z(), 0.1);
  return smoothMinus(inside, junction, 0.06);
}

double simplePulp(const ToothDimensions& t, const Vec3d& p) {
  const std::array<Bead, 5> beads = {{{{0, 0, 0.42 * t.crown}, 0.18},
                                      {{0, 0, 0.12 * t.crown}, 0.50},
                                      {{0, 0, -0.15 * t.root}, 0.46},
                                      {{0, 0, -0.6 * t.root}, 0.30},
                                      {{0, 0, 1.0 - t.root}, 0.20}}};
  return tube(beads, Vec3d(p.x(), p.y() / 1.6, p.z()));  // wider bucco-lingually
}

// -------------------------------------------------------------------------------------------------------- the row

struct ArchPoint {
  double s;  ///< along the arch from the midline, mm
  Vec2d at, forward;
};
/// The arch, finely sampled.
std::vector<ArchPoint> arch() {
  std::array<Knot, kArch.size()> x, y;
  for (std::size_t i = 0; i < kArch.size(); ++i) {
    x[i] = {static_cast<double>(i), kArch[i][0]};
    y[i] = {static_cast<double>(i), kArch[i][1]};
  }
  std::vector<ArchPoint> points;
  constexpr int kSamples = 40;
  for (int n = 0; n <= kSamples * static_cast<int>(kArch.size() - 1); ++n) {
    const double u = static_cast<double>(n) / kSamples;
    const Vec2d at(curve(x, u), curve(y, u));
    const double s = points.empty() ? 0 : points.back().s + (at - points.back().at).norm();
    points.push_back({s, at, Vec2d::Zero()});
  }
  for (std::size_t i = 1; i + 1 < points.size(); ++i)
    points[i].forward = (points[i - 1].at - points[i + 1].at).normalized();  // towards the midline: mesial
  return points;
}

std::array<ToothPose, 7> makeRow() {
  const std::vector<ArchPoint> points = arch();
  // Inclination of the crown towards the tongue, degrees, and height of the cusps over the occlusal plane, mm: the row
  // sags in its middle (curve of Spee).
  constexpr std::array<double, 7> kLean = {-4, -3, 0, 4, 8, 12, 15};
  constexpr std::array<double, 7> kHeight = {0, 0.1, 0.5, 0.0, -0.5, -0.6, -0.1};
  std::array<ToothPose, 7> row;
  double s = -0.05;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const ToothDimensions& t = kLowerTeeth[i];
    constexpr double kContact = 0.975;  // teeth touch in areas, not in points
    const double middle = s + 0.5 * kContact * t.mesiodistal;
    s += kContact * t.mesiodistal;

    std::size_t n = 1;
    while (points[n].s < middle) ++n;
    const Vec3d mesial(points[n].forward.x(), points[n].forward.y(), 0), up = Vec3d::UnitZ();
    Eigen::Matrix3d axes;
    axes << mesial, up.cross(mesial), up;

    Rigid3 pose;
    pose.rotation = Eigen::Quaterniond(axes) *
                    Eigen::Quaterniond(Eigen::AngleAxisd(kLean[i] * std::numbers::pi / 180, Vec3d::UnitX()));
    pose.translation = Vec3d(points[n].at.x(), points[n].at.y(), kHeight[i] - t.crown);
    const Vec3d middle_in_tooth(0, 0, 0.5 * (t.crown - t.root));
    row[i] = {pose.inverse(), &t, pose * middle_in_tooth, 0.5 * (t.crown + t.root) + 2.5};
  }
  return row;
}

}  // namespace

double toothValue(const ToothDimensions& t, ToothTissue tissue, const Vec3d& p) {
  if (t.position >= 6) {
    // Both molars have the form of the detailed first one.
    const ToothDimensions& first = kLowerTeeth[5];
    const double k = t.mesiodistal / first.mesiodistal;
    const Vec3d q(p.x() / k, p.y() / k, p.z() / (p.z() > 0 ? t.crown / first.crown : t.root / first.root));
    return k * (tissue == ToothTissue::kTooth    ? molarTooth(q)
                : tissue == ToothTissue::kEnamel ? molarEnamel(q)
                                                 : molarPulp(q));
  }
  return tissue == ToothTissue::kTooth    ? simpleTooth(t, p)
         : tissue == ToothTissue::kEnamel ? simpleEnamel(t, p)
                                          : simplePulp(t, p);
}

const std::array<ToothPose, 7>& lowerRow() {
  static const std::array<ToothPose, 7> row = makeRow();
  return row;
}

double heightOnNearestTooth(const Vec3d& p) {
  double nearest = 1e9, height = 0;
  for (const ToothPose& pose : lowerRow()) {
    if ((p - pose.middle).norm() - pose.radius >= nearest) continue;
    const Vec3d local = pose.T_tooth_jaw * p;
    const double value = toothValue(*pose.tooth, ToothTissue::kTooth, local);
    if (value < nearest) {
      nearest = value;
      height = local.z();
    }
  }
  return height;
}

}  // namespace kerf::internal
