#include "ui/app/upright.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/case/case_bundle.h"
#include "preprocess/close/occlusal_plane.h"
#include "sim/run/run_files.h"

namespace kerf {
namespace {

// Where a base looks: the axis that the largest flat part of the surface is square to. None: no flat part to speak of.
// How sure one can be of it.
struct FlatSide {
  double cosine = 0.9999;     // of the largest angle to the axis
  double least_share = 0.04;  // of the area
  double times_opposite = 0;  // at least so many times what is flat on the other side: a block has no base
};
std::optional<Vec3d> baseNormalOf(const Mesh& solid, const FlatSide& side = {}) {
  std::array<double, 6> area{};
  double all = 0;
  for (const Triangle& t : solid.triangles) {
    const Vec3d& a = solid.vertices[t[0]];
    const Vec3d twice = (solid.vertices[t[1]] - a).cross(solid.vertices[t[2]] - a);
    all += twice.norm();
    for (std::size_t n = 0; n < 6; ++n) {
      const double along = (n < 3 ? -1 : 1) * twice[static_cast<Eigen::Index>(n % 3)];
      if (along > side.cosine * twice.norm()) area[n] += along;
    }
  }
  const auto most = static_cast<std::size_t>(std::max_element(area.begin(), area.end()) - area.begin());
  if (!(area[most] > side.least_share * all)) return {};
  if (area[most] < side.times_opposite * area[(most + 3) % 6]) return {};
  return (most < 3 ? -1.0 : 1.0) * Vec3d::Unit(static_cast<Eigen::Index>(most % 3));
}

// Of the area that faces a plane, the share close to it: most of a trimmed underside, little of a row of teeth.
double shareNear(const Mesh& solid, const OcclusalPlane& plane) {
  constexpr double kNear = 2, kFacing = 0.7;  // mm; cosine of the angle
  double all = 0, near = 0;
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    const Vec3d twice = doubleAreaVector(solid, t);
    const double along = twice.dot(plane.normal);
    if (along < kFacing * twice.norm()) continue;
    all += along;
    if (std::abs(plane.normal.dot(solid.corner(t, 0) - plane.point)) < kNear) near += along;
  }
  return all > 0 ? near / all : 0;
}

}  // namespace

std::optional<Vec3d> awayFromOpening(const Mesh& mesh) {
  constexpr double kLeastShare = 0.05;  // of the area
  Vec3d twice = Vec3d::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) twice += doubleAreaVector(mesh, t);
  if (!(twice.norm() > kLeastShare * 2 * surfaceArea(mesh))) return {};
  return twice.normalized();
}

OcclusalSide occlusalSideOf(const Mesh& solid) {
  const auto of = [&](const OcclusalPlane& plane) { return OcclusalSide{plane.normal, findDentalArch(solid, plane)}; };
  constexpr double kFlat = 0.05;  // mm
  if (const auto base = baseNormalOf(solid)) {
    const auto found = findOcclusalPlane(solid, -*base);
    if (found && found->rms_mm > kFlat && found->normal.dot(-*base) > 0.5) return of(*found);
    return {Vec3d(-*base), {}};
  }
  std::optional<OcclusalPlane> best;
  double best_score = 0;
  for (int n = 0; n < 6; ++n) {
    const auto found = findOcclusalPlane(solid, (n < 3 ? 1.0 : -1.0) * Vec3d::Unit(n % 3));
    if (!found || found->rms_mm <= kFlat) continue;
    const double score = static_cast<double>(found->tips) * (1 - shareNear(solid, *found));
    if (score <= best_score) continue;
    best = *found;
    best_score = score;
  }
  if (!best) return {};
  return of(*best);
}

std::optional<Vec3d> occlusalNormalOf(const Mesh& solid) { return occlusalSideOf(solid).normal; }

std::optional<Vec3d> surelyUp(const Mesh& mesh) {
  constexpr FlatSide kBase{.times_opposite = 2};
  constexpr FlatSide kTrimmed{.cosine = 0.97, .least_share = 0.12, .times_opposite = 3};  // a scanned plaster cast
  std::optional<Vec3d> up = awayFromOpening(mesh);
  for (const FlatSide& side : {kBase, kTrimmed})
    if (const auto base = up ? std::nullopt : baseNormalOf(mesh, side)) up = -*base;
  if (!up) return {};
  int axis = 0;
  up->cwiseAbs().maxCoeff(&axis);
  return Vec3d(((*up)[axis] < 0 ? -1.0 : 1.0) * Vec3d::Unit(axis));
}

std::optional<Vec3d> surelyUp(const std::filesystem::path& scene, const Mesh& mesh) {
  std::filesystem::path case_folder;
  if (isCase(scene)) case_folder = scene;
  if (isRun(scene)) case_folder = caseOfRun(scene).value_or("");
  if (case_folder.empty()) return surelyUp(mesh);
  const auto solid = readCaseSolid(case_folder);
  return solid ? surelyUp(*solid) : std::nullopt;
}

}  // namespace kerf
