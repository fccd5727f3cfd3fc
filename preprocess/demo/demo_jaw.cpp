#include "preprocess/demo/demo_jaw.h"

#include <array>
#include <limits>
#include <numbers>
#include <vector>

#include "preprocess/demo/demo_dimensions.h"
#include "preprocess/demo/demo_teeth.h"

namespace kerf::internal {
namespace {

constexpr DemoMandibleDimensions kJawDimensions;

// ---------------------------------------------------------------------------------------------------------- body

// Stations from the midline backwards, mm: the middle of the lower border in plan, heights of border and crest, half
// thickness near the border, half way up and at the crest. The crest follows the dental arch (kArch).
struct Station {
  double border_x, border_y, border_z, crest_z, low, middle, high;
};
constexpr std::array<Station, kArch.size()> kStations = {{{0, -0.5, -40.4, -10.7, 5.4, 4.5, 3.1},
                                                          {6.2, 0.5, -40.5, -10.8, 5.5, 4.5, 3.1},
                                                          {12.5, 3.4, -40.2, -11.5, 5.4, 4.7, 3.6},
                                                          {18.5, 9.0, -39.4, -11.4, 5.2, 5.2, 3.7},
                                                          {22.8, 15.4, -38.4, -10.2, 5.0, 5.4, 3.9},
                                                          {26.4, 22.4, -37.1, -9.7, 4.9, 5.8, 4.6},
                                                          {29.9, 30.0, -35.5, -9.2, 4.7, 6.2, 5.0},
                                                          {33.4, 38.3, -33.9, -8.6, 4.3, 6.0, 4.8},
                                                          {37.0, 47.2, -32.2, -8.6, 3.4, 4.8, 3.4},
                                                          {40.2, 55.0, -29.0, -11.0, 2.4, 2.6, 1.6}}};

struct Sample {
  Vec2d border, crest;
  double border_z, crest_z, low, middle, high;
};
constexpr int kPerStation = 40;
std::vector<Sample> sampleStations() {
  std::vector<Sample> samples;
  const auto along = [](double u, auto value) {
    std::array<Knot, kStations.size()> knots;
    for (std::size_t i = 0; i < knots.size(); ++i) knots[i] = {static_cast<double>(i), value(i)};
    return curve(knots, u);
  };

  // Catmull-Rom ends flat; in the midline x must run on, as its mirror image does.
  const auto x_along = [&](double u, auto value) {
    return u < 1 ? value(1) * (u + 0.5 * (value(2) / (2 * value(1)) - 1) * u * u * (u - 1)) : along(u, value);
  };

  for (int n = 0; n <= kPerStation * static_cast<int>(kStations.size() - 1); ++n) {
    const double u = static_cast<double>(n) / kPerStation;
    Sample s;
    s.border = {x_along(u, [](std::size_t i) { return kStations[i].border_x; }),
                along(u, [](std::size_t i) { return kStations[i].border_y; })};
    s.crest = {x_along(u, [](std::size_t i) { return kArch[i][0]; }),
               along(u, [](std::size_t i) { return kArch[i][1]; })};
    s.border_z = along(u, [](std::size_t i) { return kStations[i].border_z; });
    s.crest_z = along(u, [](std::size_t i) { return kStations[i].crest_z; });
    s.low = along(u, [](std::size_t i) { return kStations[i].low; });
    s.middle = along(u, [](std::size_t i) { return kStations[i].middle; });
    s.high = along(u, [](std::size_t i) { return kStations[i].high; });
    samples.push_back(s);
  }
  return samples;
}

/// Where a point lies in the body of the jaw.
struct InBody {
  double from_middle;  ///< mm in plan from the middle surface; beyond its hind end: from that end
  double height;       ///< 0 at the lower border, 1 at the crest
  Sample here;
};
InBody inBody(const Vec3d& p) {
  static const std::vector<Sample> samples = sampleStations();
  const Vec2d at = p.head<2>();
  InBody found{};
  double t = std::clamp((p.z() + 38) / 28, 0.0, 1.0);
  for (int round = 0; round < 2; ++round) {
    const auto far2 = [&](std::size_t i) {
      return (samples[i].border + t * (samples[i].crest - samples[i].border) - at).squaredNorm();
    };
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    constexpr std::size_t kCoarse = 10;
    for (std::size_t i = 0; i < samples.size(); i += kCoarse)
      if (const double d = far2(i); d < least) {
        least = d;
        best = i;
      }

    const std::size_t from = best > kCoarse ? best - kCoarse : 0, to = std::min(samples.size() - 1, best + kCoarse);
    for (std::size_t i = from; i <= to; ++i)
      if (const double d = far2(i); d < least) {
        least = d;
        best = i;
      }

    // Between the samples: the nearest point of the two segments that end here, and everything else blended likewise.
    double blend = 0;
    std::size_t other = best;
    for (const std::size_t i : {best ? best - 1 : best, std::min(best + 1, samples.size() - 1)}) {
      if (i == best) continue;
      const Vec2d a = samples[best].border + t * (samples[best].crest - samples[best].border),
                  d = samples[i].border + t * (samples[i].crest - samples[i].border) - a;
      const double f = std::clamp((at - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
      if (const double d2 = (at - a - f * d).squaredNorm(); d2 < least) {
        least = d2;
        blend = f;
        other = i;
      }
    }

    const Sample &a = samples[best], &b = samples[other];
    found.here = {a.border + blend * (b.border - a.border),
                  a.crest + blend * (b.crest - a.crest),
                  mix(a.border_z, b.border_z, blend),
                  mix(a.crest_z, b.crest_z, blend),
                  mix(a.low, b.low, blend),
                  mix(a.middle, b.middle, blend),
                  mix(a.high, b.high, blend)};

    found.from_middle = std::sqrt(least);
    found.height = (p.z() - found.here.border_z) / (found.here.crest_z - found.here.border_z);
    t = std::clamp(found.height, 0.0, 1.0);
  }
  return found;
}

/// An upright plate of varying half thickness with a round lower border and a rounded crest.
double body(const Vec3d& p) {
  const InBody at = inBody(p);
  const Sample& s = at.here;
  const std::array<Knot, 4> thickness = {
      {{0.0, s.low}, {0.22, mix(s.low, s.middle, 0.25)}, {0.55, s.middle}, {1.0, s.high}}};
  const double half = curve(thickness, at.height);
  const bool low = p.z() < 0.5 * (s.border_z + s.crest_z);
  const double round = low ? 0.85 * s.low : 2.2;
  const double out = at.from_middle - half + round, over = (low ? s.border_z - p.z() : p.z() - s.crest_z) + round;
  return std::hypot(std::max(out, 0.0), std::max(over, 0.0)) + std::min(std::max(out, over), 0.0) - round;
}

// --------------------------------------------------------------------------------------------------------- ramus

// In the side view the ramus has axes of its own: `up` along it, `front` across it, from its hind border forwards. The
// gonial angle lies between `up` and the lower border of the body.
constexpr double kGonionY = 73, kGonionZ = -30;
const double kBodySlope = 8.1 * std::numbers::pi / 180;  // of the lower border against the occlusal plane
const double kUpAngle = std::numbers::pi + kBodySlope - kJawDimensions.gonial_angle_deg * std::numbers::pi / 180;
const Vec2d kUp(std::cos(kUpAngle), std::sin(kUpAngle)), kFront(-kUp.y(), kUp.x());

Vec2d inRamus(double y, double z) {
  const Vec2d q(y - kGonionY, z - kGonionZ);
  return {q.dot(kFront), q.dot(kUp)};
}

// Outline of the ramus in its axes, mm: hind border, neck, notch, coronoid process, front border, into the body, lower
// border.
constexpr double kOutline[][2] = {{0.6, 5},      {0.2, 13},    {0.6, 22},    {1.0, 31},    {0.6, 39},     {-0.6, 46},
                                  {-0.4, 50},    {2.4, 52},    {5.6, 50},    {6.6, 46},    {8.4, 40.5},   {11.6, 36.2},
                                  {15.4, 35.2},  {18.6, 35.6}, {20.8, 38.4}, {22.6, 41.6}, {24.6, 43.8},  {26.6, 43.6},
                                  {28.6, 40.6},  {30.2, 36},   {31.0, 31},   {31.3, 25},   {31.6, 18.5},  {32.8, 11},
                                  {35.4, 4},     {38.5, -3},   {39.5, -10},  {36, -16.5},  {30.5, -17.8}, {25, -15.8},
                                  {19.5, -12.0}, {14, -8.4},   {8.5, -5.0},  {3.8, -1.2},  {1.6, 1.6}};

/// Signed distance to the outline, from a grid, in between by a quadratic B-spline: smooth where the distance has
/// kinks.
class RamusOutline {
 public:
  RamusOutline() {
    std::vector<Vec2d> fine;
    const std::size_t n = std::size(kOutline);
    const auto corner = [&](std::size_t i) { return Vec2d(kOutline[i % n][0], kOutline[i % n][1]); };
    for (std::size_t i = 0; i < n; ++i)
      for (double t = 0; t < 1; t += 0.25) {  // Catmull-Rom
        const Vec2d a = corner(i + n - 1), b = corner(i), c = corner(i + 1), d = corner(i + 2);
        fine.push_back(
            0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t + (3 * b - a - 3 * c + d) * t * t * t));
      }
    for (int j = 0; j < kRows; ++j)
      for (int i = 0; i < kColumns; ++i) {
        const Vec2d p = kLow + kStep * Vec2d(i, j);
        double d2 = 1e18;
        bool inside = false;
        for (std::size_t k = 0; k < fine.size(); ++k) {
          const Vec2d a = fine[k], b = fine[(k + 1) % fine.size()], e = b - a;
          const double t = std::clamp((p - a).dot(e) / e.squaredNorm(), 0.0, 1.0);
          d2 = std::min(d2, (p - a - t * e).squaredNorm());
          if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (p.y() - a.y()) / e.y() * e.x()) inside = !inside;
        }
        at(i, j) = (inside ? -1 : 1) * std::sqrt(d2);
      }
  }

  double distance(const Vec2d& p) const {
    const Vec2d g = (p - kLow) / kStep;
    const Vec2d inner = g.cwiseMax(Vec2d(1, 1)).cwiseMin(Vec2d(kColumns - 2.001, kRows - 2.001));
    const int i = static_cast<int>(std::lround(inner.x())), j = static_cast<int>(std::lround(inner.y()));
    const auto weights = [](double f) {
      return std::array<double, 3>{0.5 * square(0.5 - f), 0.75 - f * f, 0.5 * square(0.5 + f)};
    };
    const auto wx = weights(inner.x() - i), wy = weights(inner.y() - j);
    double sum = 0;
    for (int b = 0; b < 3; ++b)
      for (int a = 0; a < 3; ++a)
        sum += wx[static_cast<std::size_t>(a)] * wy[static_cast<std::size_t>(b)] * at(i + a - 1, j + b - 1);
    return sum + kStep * (g - inner).norm();
  }

 private:
  static constexpr int kColumns = 80, kRows = 120;
  static constexpr double kStep = 0.9;
  inline static const Vec2d kLow{-14, -38};
  double at(int i, int j) const { return values_[static_cast<std::size_t>(j * kColumns + i)]; }
  double& at(int i, int j) { return values_[static_cast<std::size_t>(j * kColumns + i)]; }
  std::vector<double> values_ = std::vector<double>(static_cast<std::size_t>(kColumns * kRows));
};

/// x of the middle surface of the ramus, mm. It stands in a plane almost, turned out backwards; to the front it becomes
/// the middle surface of the body, which leans in towards the teeth.
double ramusMiddle(double y, double z) {
  const double plane = 45 + 0.27 * (y - kGonionY) - 0.03 * (z - kGonionZ) + 0.0022 * square(std::max(0.0, z + 5));
  const double border = 33.4 + 0.41 * (y - 38.3), crest = 25.2 + 0.55 * (y - 38.3);
  return mix(plane, mix(border, crest, std::clamp((z + 33.5) / 25, 0.0, 1.0)), smoothStep(66, 40, y));
}
double ramusHalfThickness(const Vec2d& r) {
  const double front = r.x(), up = r.y();
  return 2.35 + 0.55 * bell(front - 3, 6) + 0.5 * smoothStep(0, 15, up) - 0.9 * smoothStep(22, 38, up) +
         0.9 * bell(front - 30, 5) * smoothStep(38, 20, up) + 1.0 * smoothStep(24, 32, front) * smoothStep(20, 4, up);
}

double ramus(const Vec3d& p) {
  static const RamusOutline outline;
  const Vec2d r = inRamus(p.y(), p.z());
  const double half = ramusHalfThickness(r), off = p.x() - ramusMiddle(p.y(), p.z());
  return std::hypot(std::max(outline.distance(r) + half, 0.0), off) - half;
}

/// The head of the jaw with its neck.
double condyle(const Vec3d& p) {
  constexpr double kTurn = 18 * std::numbers::pi / 180;  // its inner pole lies further back
  const Vec2d side = Vec2d(kGonionY, kGonionZ) + 2.6 * kFront + 51.0 * kUp;
  const Vec3d q = p - Vec3d(49.6, side.x(), side.y());
  const Vec3d turned(std::cos(kTurn) * q.x() + std::sin(kTurn) * q.y(),
                     -std::sin(kTurn) * q.x() + std::cos(kTurn) * q.y(), q.z() + 0.035 * q.x() * q.x());
  const double head = ellipsoid(turned, Vec3d(9.4, 4.3, 4.6));
  const Vec2d low = Vec2d(kGonionY, kGonionZ) + 3.4 * kFront + 38.0 * kUp;
  const Vec3d root(ramusMiddle(low.x(), low.y()), low.x(), low.y());
  // In the front view the neck widens to both poles, more to the inner one.
  const std::array<Bead, 3> neck = {
      {{{54.0, side.x() - 0.8, side.y() - 1.6}, 3.2}, {root, 2.6}, {{44.6, side.x() + 0.6, side.y() - 1.8}, 3.2}}};
  return smoothMin(head, tube(neck, p), 3.0);
}

// ---------------------------------------------------------------------------------------------------- muscle marks

double chin(const Vec3d& p) {
  const double middle = ellipsoid(p - Vec3d(0, -2.5, -34.2), Vec3d(10.5, 3.6, 6.2));
  return smoothMin(middle, ellipsoid(p - Vec3d(8.5, -1.5, -36.8), Vec3d(5.0, 3.2, 3.0)), 5.0);
}

const std::array<Bead, 5> kObliqueLine = {{{{39.6, 58.0, 7.0}, 0.2},
                                           {{39.2, 51.5, -5.0}, 2.1},
                                           {{36.2, 45.0, -12.0}, 2.4},
                                           {{32.8, 37.5, -17.0}, 1.8},
                                           {{30.0, 29.5, -22.0}, 0.8}}};
const std::array<Bead, 4> kMylohyoidLine = {
    {{{30.5, 50.5, -12.0}, 1.2}, {{26.0, 40.0, -15.5}, 1.3}, {{21.6, 28.0, -20.5}, 0.9}, {{15.0, 15.0, -27.5}, 0.5}}};

/// Axis of the canal on the left side, mm, before smoothing.
constexpr double kPath[][3] = {{36.3, 69.6, -2.6},  {38.4, 68.0, -4.6},  {40.3, 65.6, -7.6},  {40.4, 62.0, -11.6},
                               {38.3, 56.0, -16.4}, {35.6, 49.3, -20.6}, {31.9, 42.4, -22.9}, {28.7, 35.6, -24.3},
                               {27.0, 29.0, -25.1}, {24.5, 23.0, -24.7}, {22.5, 17.8, -24.2}, {22.3, 14.8, -23.6},
                               {24.2, 14.6, -22.6}, {26.6, 15.0, -21.4}, {28.6, 15.3, -20.6}};

std::vector<Bead> smoothPath() {
  std::vector<Bead> beads;
  const auto corner = [](std::ptrdiff_t i) {
    const auto n = static_cast<std::ptrdiff_t>(std::size(kPath));
    const auto& c = kPath[std::clamp<std::ptrdiff_t>(i, 0, n - 1)];
    return Vec3d(c[0], c[1], c[2]);
  };
  const double radius = 0.5 * kJawDimensions.canal_diameter;
  for (std::ptrdiff_t i = 0; i + 1 < static_cast<std::ptrdiff_t>(std::size(kPath)); ++i)
    for (double t = 0; t < 1; t += 0.25) {
      const Vec3d a = corner(i - 1), b = corner(i), c = corner(i + 1), d = corner(i + 2);
      beads.push_back(
          {0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t + (3 * b - a - 3 * c + d) * t * t * t),
           radius});
    }
  beads.push_back({corner(std::size(kPath) - 1), radius});
  return beads;
}

Vec3d leftHalf(const Vec3d& p) { return {std::abs(p.x()), p.y(), p.z()}; }

/// A lower bound of the distance where the jaw is far; nothing near it.
double farAway(const Vec3d& p) {
  static const Box3 box{Vec3d(0, -12, -46), Vec3d(64, 106, 34)};
  return (p - p.cwiseMax(box.min).cwiseMin(box.max)).norm();
}

}  // namespace

double jawCore(const Vec3d& original) {
  const Vec3d p = leftHalf(original);
  if (const double d = farAway(p); d > 4) return d;
  double f = p.y() < 80 ? body(p) : 1e3;
  f = smoothMin(f, chin(p), 5.5);
  if (p.y() > 20) {
    f = smoothMin(f, smoothMin(ramus(p), condyle(p), 2.5), 6.0);
    f = smoothMin(f, tube(kObliqueLine, p), 2.5);
  }
  f = smoothMin(f, tube(kMylohyoidLine, p), 2.0);
  // The hollow of the submandibular gland under the mylohyoid line.
  return smoothMinus(f, ellipsoid(p - Vec3d(20.6, 38.0, -26.5), Vec3d(5.5, 13.0, 5.0)), 3.0);
}

double jawBone(const Vec3d& original) {
  const Vec3d p = leftHalf(original);
  const double core = jawCore(p);
  if (core > 4 || p.z() > 0) return core;
  // Bone bulges over the roots; a plate of at least 0.8 mm covers them up to the crest, 1.75 mm below the junction.
  const double cover = rowUnion(p, 3.0, [](const ToothDimensions& t, const Vec3d& local) {
    return smoothMax(toothValue(t, ToothTissue::kTooth, local) - 0.9, local.z() + kJawDimensions.junction_to_crest,
                     0.8);
  });
  return smoothMin(core, cover, 1.4);
}

double cortexThickness(const Vec3d& original) {
  const Vec3d p = leftHalf(original);
  const double height = std::clamp((p.z() + 40) / 30, 0.0, 1.0);
  const double in_body = mix(kJawDimensions.cortex.most, kJawDimensions.cortex.least, smoothStep(0.1, 0.8, height));
  return mix(in_body, kJawDimensions.ramus_cortex, smoothStep(48, 62, p.y()));
}

std::span<const Bead> nervePath() {
  static const std::vector<Bead> path = smoothPath();
  return path;
}
double nerveCanal(const Vec3d& p) { return tube(nervePath(), leftHalf(p)); }

double jawOutline(const Vec3d& original) {
  const Vec3d p = leftHalf(original);
  double f = jawBone(p);
  if (f > 6 && p.z() < -14) return f;
  // Funnels where the nerve enters and leaves.
  const auto path = nervePath();
  f = smoothMinus(f, (p - path.front().at).norm() - 2.6, 1.2);
  f = smoothMinus(f, (p - path.back().at).norm() - 2.7, 1.0);
  return smoothMin(f, rowValue(ToothTissue::kTooth, p, 3.0), 0.3);
}

double ligament(const Vec3d& original) {
  return rowUnion(leftHalf(original), 3.0, [](const ToothDimensions& t, const Vec3d& local) {
    return smoothMax(toothValue(t, ToothTissue::kTooth, local) - kJawDimensions.ligament,
                     local.z() + kJawDimensions.junction_to_crest - 0.3, 0.1);
  });
}

double spongyBone(const Vec3d& original) {
  const Vec3d p = leftHalf(original);
  double f = jawCore(p) + cortexThickness(p);
  if (f > 3) return f;
  f = smoothMax(f, kJawDimensions.socket_wall + kJawDimensions.ligament - rowValue(ToothTissue::kTooth, p, 3.0), 0.6);
  return smoothMax(f, kJawDimensions.canal_wall - nerveCanal(p), 0.6);
}

double gingiva(const Vec3d& original) {
  const Vec3d p = leftHalf(original);
  const double jaw = jawCore(p) - 1.7;  // mucosa on the bone
  if (jaw > 6) return jaw;
  // The margin lies on the enamel, lower on the faces than between the teeth, where the papillae stand.
  const double collar = rowUnion(p, 3.0, [](const ToothDimensions& t, const Vec3d& local) {
    const double r2 = local.x() * local.x() + local.y() * local.y();
    const double margin =
        0.9 + (r2 > 1e-6 ? (t.position <= 3 ? 2.7 : 1.9) * (local.x() * local.x() - local.y() * local.y()) / r2 : 0.0);
    return smoothMax(toothValue(t, ToothTissue::kTooth, local) - 0.9, local.z() - margin, 0.9);
  });
  return smoothMin(smoothMax(jaw, p.z() + 6.0, 2.0), collar, 1.8);
}

double archSurface(const Vec3d& p) {
  return smoothMin(gingiva(p), rowValue(ToothTissue::kTooth, leftHalf(p), 3.0), 0.2);
}

}  // namespace kerf::internal
