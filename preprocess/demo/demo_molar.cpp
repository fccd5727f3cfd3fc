#include "preprocess/demo/demo_molar.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <span>

#include "preprocess/demo/demo_anatomy.h"
#include "preprocess/demo/demo_dimensions.h"
#include "preprocess/demo/demo_teeth.h"
#include "preprocess/demo/implicit.h"
#include "preprocess/volume/tetrahedral_mesher.h"

namespace kerf {
namespace {

using namespace internal;

// ---------------------------------------------------------------------------------------------- occlusal surface

struct Cusp {
  Vec3d tip;           ///< mm
  Vec2d fossa;         ///< where its triangular ridge runs to, mm
  double inner_slope;  ///< fall along the ridge, mm per mm
};
const std::array<Cusp, 5> kCusps = {{
    {{2.65, 2.75, 7.3}, {0.6, 0.1}, 0.62},     // mesiobuccal
    {{-0.85, 2.95, 7.15}, {-0.5, 0.1}, 0.66},  // distobuccal
    {{-3.6, 1.35, 6.7}, {-1.6, 0.0}, 0.55},    // distal
    {{2.4, -2.95, 7.75}, {0.5, -0.3}, 0.66},   // mesiolingual
    {{-2.0, -3.0, 7.55}, {-0.9, -0.3}, 0.66},  // distolingual
}};

const std::array<Vec2d, 5> kCentralFissure = {
    {{3.15, -0.05}, {1.4, -0.45}, {0.15, -0.05}, {-1.4, -0.45}, {-2.95, -0.35}}};
const std::array<Vec2d, 3> kMesiobuccalFissure = {{{0.4, -0.1}, {0.85, 1.7}, {0.95, 5.2}}};
const std::array<Vec2d, 3> kDistobuccalFissure = {{{-1.4, -0.45}, {-2.35, 1.5}, {-3.0, 4.4}}};
const std::array<Vec2d, 3> kLingualFissure = {{{-0.35, -0.1}, {0.15, -1.8}, {0.2, -4.8}}};
// Short grooves beside the triangular ridges, and at the pits.
const std::array<std::array<Vec2d, 2>, 7> kSideGrooves = {{{{{3.1, -0.05}, {3.75, 1.15}}},
                                                           {{{3.1, -0.05}, {3.6, -1.35}}},
                                                           {{{1.5, -0.4}, {1.85, 1.2}}},
                                                           {{{1.3, -0.45}, {1.2, -1.7}}},
                                                           {{{-1.4, -0.45}, {-1.05, -1.8}}},
                                                           {{{-2.9, -0.35}, {-3.35, -1.5}}},
                                                           {{{-2.9, -0.35}, {-3.9, -0.1}}}}};
const std::array<Vec2d, 3> kPits = {{{0.1, -0.1}, {3.1, -0.05}, {-2.9, -0.35}}};

/// Depth of the fissures below the surface the cusps make, mm.
double fissureDepth(const Vec2d& p) {
  const auto groove = [&](std::span<const Vec2d> chain, double depth, double width) {
    const double d = distanceToChain(chain, p) / width;
    return depth / (1 + d * d * (1 + 0.35 * d * d));  // a narrow valley with a round floor
  };
  double depth = groove(kCentralFissure, 0.62, 0.62);
  depth = smoothMax(depth, groove(kMesiobuccalFissure, 0.55, 0.56), 0.1);
  depth = smoothMax(depth, groove(kDistobuccalFissure, 0.50, 0.56), 0.1);
  depth = smoothMax(depth, groove(kLingualFissure, 0.55, 0.56), 0.1);
  for (const auto& side : kSideGrooves) depth = smoothMax(depth, groove(side, 0.28, 0.34), 0.1);
  for (const Vec2d& pit : kPits) depth += 0.28 * bell((p - pit).norm(), 0.5);
  return depth;
}

/// Height of the chewing surface over the CEJ plane without its fissures, mm.
double cuspHeight(const Vec2d& p) {
  double height = -1e9;
  for (const Cusp& cusp : kCusps) {
    const Vec2d from_tip = p - cusp.tip.head<2>(), to_fossa = (cusp.fossa - cusp.tip.head<2>()).normalized();
    const double along = from_tip.dot(to_fossa), across = from_tip.dot(Vec2d(-to_fossa.y(), to_fossa.x()));
    // Falls gently along the triangular ridge, faster to its sides and outwards.
    const double a = along * (along > 0 ? cusp.inner_slope : 0.50), c = across * 0.80;
    constexpr double kRound = 0.42;
    height = smoothMax(height, cusp.tip.z() - (std::sqrt(a * a + c * c + kRound * kRound) - kRound), 0.7);
  }
  // Marginal ridges join the cusps at both ends; low in their middle.
  const auto ridge = [&](double x, double middle_y, double low) {
    const double off = (p.x() - x) * 0.85, y = p.y() - middle_y;
    return low + 0.055 * y * y - (std::sqrt(off * off + 0.3) - std::sqrt(0.3));
  };
  height = smoothMax(height, ridge(4.25, -0.1, 6.15), 0.5);
  height = smoothMax(height, ridge(-4.3, -0.5, 5.85), 0.5);
  // Nothing is lower than the floor of the central basin.
  height = smoothMax(height, 5.15, 0.6);
  return height;
}

double occlusalHeight(const Vec2d& p) { return cuspHeight(p) - fissureDepth(p); }

// ------------------------------------------------------------------------------------------------------- crown

// Half widths over the height, mm. The buccal side bulges low and leans in, the lingual one bulges half way up.
constexpr std::array<Knot, 6> kMesial = {{{-1.0, 4.05}, {0.0, 4.53}, {2.0, 5.02}, {4.6, 5.5}, {6.0, 5.32}, {8.0, 4.6}}};
constexpr std::array<Knot, 6> kDistal = {{{-1.0, 4.05}, {0.0, 4.50}, {2.0, 4.98}, {4.2, 5.5}, {5.8, 5.28}, {8.0, 4.4}}};
constexpr std::array<Knot, 6> kBuccal = {{{-1.0, 4.05}, {0.0, 4.55}, {1.9, 5.5}, {3.6, 5.28}, {5.6, 4.62}, {8.0, 3.7}}};
constexpr std::array<Knot, 6> kLingual = {
    {{-1.0, 3.85}, {0.0, 4.32}, {2.0, 4.75}, {4.0, 5.08}, {6.0, 4.78}, {8.0, 4.2}}};

double crownSides(const Vec3d& p) {
  // The outline narrows to the lingual and, a little, to the distal side.
  const double x = p.x() / (1 + 0.014 * p.y()), y = p.y() / (1 + 0.008 * p.x());
  const double u = x / curve(x > 0 ? kMesial : kDistal, p.z()), v = y / curve(y > 0 ? kBuccal : kLingual, p.z());
  double f = (roundedNorm(u, v, 2.55) - 1) * 5.0;
  // The fissures run over onto the sides and fade; between them the lobes of the cusps stand out.
  if (y > 0) {
    const double outer = smoothStep(2.0, 4.0, y);
    f += outer * smoothStep(1.6, 5.4, p.z()) * 0.6 * bell(x - 0.95, 0.65);
    f += outer * smoothStep(2.4, 5.6, p.z()) * 0.48 * bell(x + 2.9, 0.62);
  } else {
    f += smoothStep(2.0, 4.0, -y) * smoothStep(3.2, 6.4, p.z()) * 0.5 * bell(x - 0.2, 0.70);
  }
  return f;
}

/// Height of the cemento-enamel junction, mm: it rises between the teeth and dips on the buccal and lingual sides.
double junctionHeight(const Vec3d& p) {
  const double r2 = p.x() * p.x() + p.y() * p.y();
  return r2 > 0 ? 0.4 * (p.x() * p.x() - p.y() * p.y()) / r2 : 0;
}

double crown(const Vec3d& p) {
  // Enamel ends in a thin lip over the cementum.
  const double lip = 0.10 * (1 - smoothStep(-0.15, 0.35, p.z() - junctionHeight(p)));
  const double sides = crownSides(p) + lip;
  const double top = (p.z() - occlusalHeight(p.head<2>())) * 0.78;
  return smoothMax(smoothMax(sides, top, 1.1), -(p.z() + 0.6), 0.3);
}

// ------------------------------------------------------------------------------------------------------- roots

struct Root {
  std::array<Knot, 5> middle_x;  ///< its axis, mm
  std::array<Knot, 5> half_md, half_bl;
  double apex;    ///< z, mm
  double groove;  ///< depth of the long hollows on its mesial and distal faces, mm
};
const Root kMesialRoot = {{{{-14.2, 1.45}, {-11.0, 2.45}, {-7.5, 3.05}, {-4.0, 2.90}, {0.0, 2.20}}},
                          {{{-14.2, 1.00}, {-11.0, 1.28}, {-7.5, 1.55}, {-4.0, 1.78}, {0.0, 2.00}}},
                          {{{-14.2, 1.40}, {-11.0, 2.42}, {-7.5, 3.30}, {-4.0, 3.75}, {0.0, 3.95}}},
                          -14.15,
                          0.42};
const Root kDistalRoot = {{{{-13.4, -4.35}, {-10.5, -3.95}, {-7.0, -3.45}, {-4.0, -2.90}, {0.0, -2.20}}},
                          {{{-13.4, 1.00}, {-10.5, 1.28}, {-7.0, 1.55}, {-4.0, 1.78}, {0.0, 2.00}}},
                          {{{-13.4, 1.15}, {-10.5, 1.85}, {-7.0, 2.60}, {-4.0, 3.25}, {0.0, 3.70}}},
                          -13.3,
                          0.24};

/// Draws the roots in above the CEJ, so that they end out of sight inside the crown.
double hiddenTop(double z) { return 0.5 * smoothStep(-0.5, 0.6, z) + 4.0 * std::max(0.0, z - 0.6); }

double root(const Root& r, const Vec3d& p) {
  const double x = p.x() - curve(r.middle_x, p.z()), half_md = curve(r.half_md, p.z()),
               half_bl = curve(r.half_bl, p.z());
  const double hollow = r.groove * bell(p.y(), 0.33 * half_bl) * smoothStep(r.apex + 1, r.apex + 4.5, p.z());
  const double sides = (roundedNorm(x / (half_md - hollow), p.y() / half_bl, 2.25) - 1) * half_md;
  return smoothMax(sides, r.apex - p.z(), 1.6) + hiddenTop(p.z());
}

/// The undivided part above the furcation, hollowed towards it on the buccal and lingual sides.
double trunk(const Vec3d& p) {
  const double hollow = 0.75 * bell(p.x() + 0.1, 1.3) * smoothStep(-0.5, -3.4, p.z());
  const double u = p.x() / (4.38 + 0.03 * p.z()), v = (p.y() - 0.1) / (4.28 + 0.09 * p.z() - hollow);
  const double sides = (roundedNorm(u, v, 2.5) - 1) * 4.3;
  // The roof of the furcation is an arch: higher in the middle line than towards the roots.
  const double roof = -3.1 - p.z() - 0.10 * p.x() * p.x();
  return smoothMax(sides, roof, 0.8) + hiddenTop(p.z());
}

double implicit(const Vec3d& p) {
  const double roots = smoothMin(root(kMesialRoot, p), root(kDistalRoot, p), 0.35);
  return smoothMin(crown(p), smoothMin(trunk(p), roots, 0.7), 0.35);
}

// ------------------------------------------------------------------------------------------------------- tissues

constexpr DemoMolarDimensions kDimensions;
constexpr double kBeyond = 0.3;  ///< mm by which enamel and caries reach out of the tooth

/// The dentino-enamel junction, negative on the side of the dentin. It follows the cusps, not the fissures: that is why
/// enamel is thin under these.
double junction(const Vec3d& p) {
  const Vec2d at = p.head<2>();
  double near_tip = 0;
  for (const Cusp& cusp : kCusps) near_tip = std::max(near_tip, bell((at - cusp.tip.head<2>()).norm(), 1.4));
  const double up = std::clamp((p.z() - junctionHeight(p)) / 3.0, 0.0, 1.0);
  const double sides = crownSides(p) + 1.50 * up * (2 - up);
  const double top = (p.z() - cuspHeight(at)) * 0.78 + mix(1.10, 1.97, near_tip);
  return smoothMax(sides, top, 0.9);
}

double enamel(const Vec3d& p) {
  const double inside = smoothMax(implicit(p) - kBeyond, junctionHeight(p) - p.z(), 0.1);
  return smoothMinus(inside, junction(p), 0.06);
}

// Where the canals run, mm. They end 0.5 to 1 mm short of the apices.
const std::array<Bead, 5> kMesialCanal = {{{{2.05, 1.25, -0.45}, 0.45},
                                           {{2.75, 1.70, -4.0}, 0.36},
                                           {{2.95, 1.65, -7.5}, 0.29},
                                           {{2.45, 1.25, -11.0}, 0.22},
                                           {{1.92, 0.90, -12.85}, 0.17}}};
const std::array<Bead, 5> kDistalCanal = {{{{-2.1, 0.0, -0.45}, 0.45},
                                           {{-2.85, 0.0, -4.0}, 0.38},
                                           {{-3.42, 0.0, -7.0}, 0.30},
                                           {{-3.95, 0.0, -10.5}, 0.23},
                                           {{-4.25, 0.0, -12.4}, 0.17}}};
constexpr double kDistalCanalWidth = 1.7;  ///< bucco-lingual over mesio-distal: a ribbon

/// Chamber with a horn under every cusp, two mesial canals and a distal one.
double pulp(const Vec3d& p) {
  const double ceiling = kCusps[0].tip.z() - 0.1 - kDimensions.cusp_to_pulp_ceiling;  // the tip is rounded off
  const double floor = ceiling - kDimensions.pulp_chamber_height;
  const double x = p.x() - 0.1, y = p.y() / (1 + 0.06 * x);
  const double sides = (roundedNorm(x / 2.65, y / 2.05, 2.8) - 1) * 2.2;
  // The ceiling sags a little in the middle, the floor rises.
  const double r2 = x * x + y * y;
  double f = smoothMax(sides, std::max(p.z() - ceiling - 0.02 * r2, floor - 0.02 * r2 - p.z()), 0.6);
  for (const Cusp& cusp : kCusps) {
    const Vec2d tip = cusp.tip.head<2>();
    const std::array<Bead, 2> horn = {{{{0.62 * tip.x(), 0.55 * tip.y(), ceiling - 0.5}, 0.42},
                                       {{0.76 * tip.x(), 0.72 * tip.y(), ceiling + 1.15}, 0.16}}};
    f = smoothMin(f, tube(horn, p), 0.3);
  }
  const Vec3d either(p.x(), std::abs(p.y()), p.z()), flat(p.x(), p.y() / kDistalCanalWidth, p.z());
  f = smoothMin(f, tube(kMesialCanal, either), 0.35);
  return smoothMin(f, tube(kDistalCanal, flat), 0.35);
}

/// A lesion of the central fissure. In enamel it widens towards the junction, along it it spreads, and in the dentin it
/// narrows again on its way to the pulp: two triangles with their bases at the junction.
double caries(const Vec3d& p) {
  static constexpr double kInDentin = 1.9, kInEnamel = 1.2;  // mm
  const std::array<Vec2d, 3> fissure = {{{0.75, -0.22}, {0.15, -0.05}, {-0.6, -0.22}}};
  const double depth = -junction(p);
  const double in_enamel = mix(0.65, 0.25, std::clamp(-depth / kInEnamel, 0.0, 1.0));
  const double in_dentin = mix(1.10, 0.15, std::clamp(depth / kInDentin, 0.0, 1.0));
  const double radius = mix(in_enamel, in_dentin, smoothStep(-0.15, 0.1, depth));
  const double sides = 0.75 * (distanceToChain(fissure, p.head<2>()) - radius);
  return smoothMax(smoothMax(sides, depth - kInDentin, 0.3), implicit(p) - kBeyond, 0.1);
}

Rgba8 colorAt(const Vec3d& p) {
  const Vec3d enamel(236, 226, 205), dentin(219, 198, 158), stain(190, 164, 124);
  Vec3d c = dentin + (enamel - dentin) * smoothStep(-0.35, 0.35, p.z() - junctionHeight(p));
  c += (stain - c) * 0.6 * smoothStep(0.36, 0.75, fissureDepth(p.head<2>())) * smoothStep(4.4, 5.4, p.z());
  const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround(v)); };
  return {byte(c.x()), byte(c.y()), byte(c.z()), 255};
}

}  // namespace

namespace internal {
double molarTooth(const Vec3d& p) { return implicit(p); }
double molarEnamel(const Vec3d& p) { return enamel(p); }
double molarPulp(const Vec3d& p) { return pulp(p); }
}  // namespace internal

double demoMolarDistance(const Vec3d& p) {
  constexpr double kStep = 1e-4;
  Vec3d gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3d d = kStep * Vec3d::Unit(axis);
    gradient[axis] = (implicit(p + d) - implicit(p - d)) / (2 * kStep);
  }
  // Where the gradient fades (the axis of a root, say) the function itself is the better guess.
  return implicit(p) / std::max(gradient.norm(), 0.5);
}

Mesh demoMolar(double edge_mm) {
  assert(edge_mm >= 0.05 && edge_mm <= 2);
  const Box3 box{Vec3d(-7.5, -7.5, -15.5), Vec3d(7.5, 7.5, 9.0)};
  Mesh mesh = meshImplicit(implicit, box, edge_mm / kEdgeToSpacing);
  evenOut(mesh, implicit, 6);
  mesh.vertex_colors.reserve(mesh.vertices.size());
  for (const Vec3d& p : mesh.vertices) mesh.vertex_colors.push_back(colorAt(p));
  return mesh;
}

Expected<DemoAnatomy> demoMolarAnatomy(double detail, const Progress& progress) {
  DemoAnatomy anatomy{"molar", "Demo lower first molar", 0.05, {}, {}, {"tooth.ply"}};
  struct Tissue {
    const char* material;
    double (*value)(const Vec3d&);
    Box3 box;
    double edge_mm;
    double coarsest_mm;  ///< with which thin parts stay in one piece
    Rgba8 color;
  };
  const Tissue tissues[] = {
      {"caries", caries, {Vec3d(-3.5, -3.5, 0.5), Vec3d(3.5, 3.5, 6.5)}, 0.10, 0.30, {92, 62, 38, 255}},
      {"enamel", enamel, {Vec3d(-7, -7, -1.5), Vec3d(7, 7, 9)}, 0.16, 0.50, {238, 232, 218, 255}},
      {"pulp", pulp, {Vec3d(-6, -4, -14.5), Vec3d(5, 4, 4)}, 0.10, 0.13, {186, 58, 52, 255}},
  };

  double done = 0;
  const auto step = [&](const std::string& material) {
    return report(progress, done++ / (std::size(tissues) + 1.0), "modelling " + material);
  };

  for (const Tissue& tissue : tissues) {
    if (!step(tissue.material)) return cancelled();
    const std::string file = std::string(tissue.material) + ".ply";
    const double edge_mm = std::min(detail * tissue.edge_mm, tissue.coarsest_mm);
    Mesh mesh = meshImplicit(tissue.value, tissue.box, edge_mm / kEdgeToSpacing);
    evenOut(mesh, tissue.value, 3);
    mesh.vertex_colors.assign(mesh.vertices.size(), tissue.color);
    anatomy.files.push_back({file, std::move(mesh)});
    anatomy.parts.push_back({tissue.material, file});
  }

  if (!step("dentin")) return cancelled();
  anatomy.files.push_back({"tooth.ply", demoMolar(0.18 * detail)});
  anatomy.parts.push_back({"dentin", "tooth.ply"});
  return anatomy;
}

}  // namespace kerf
