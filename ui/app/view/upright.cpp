#include "ui/app/view/upright.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <vector>

#include "geometry/case/case_bundle.h"
#include "preprocess/close/occlusal_plane.h"
#include "sim/run/files/run_files.h"

namespace kerf {
namespace {

// Direction of a base: the normal axis of the largest flat part of the surface. None: no notable flat part.
// Thresholds of that detection.
struct FlatSide {
  double cosine = 0.9999;     // of the largest angle to the axis
  double least_share = 0.04;  // of the area
  double times_opposite = 0;  // least ratio to the flat area on the other side: a block has no base
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

// Share of the area facing a plane that is close to it: large for a trimmed underside, small for a row of teeth.
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

// Furrows of the surface that faces a plane and lies at most 4 mm below: sum of length times angle over its concave
// edges. Per area, rad/mm, the fissures of chewing surfaces give 0.3 to 0.5; crowns closed at their necks half as much;
// the underside of a jaw almost none. Hollow caps of enamel have more, but little area that faces down.
struct Furrows {
  double sum = 0;       // mm
  double per_area = 0;  // 1/mm
};
Furrows furrowsOf(const Mesh& solid, const OcclusalPlane& plane) {
  constexpr double kFacing = 0.7, kBelow = 4;  // cosine of the angle; mm
  struct Side {
    std::uint32_t from, to;
    std::size_t triangle;
  };
  std::vector<Side> sides;
  double twice_area = 0;
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    const Vec3d twice = doubleAreaVector(solid, t);
    if (!(twice.dot(plane.normal) > kFacing * twice.norm())) continue;
    if (plane.normal.dot(plane.point - solid.corner(t, 0)) > kBelow) continue;
    twice_area += twice.norm();
    const Triangle& f = solid.triangles[t];
    for (std::size_t n = 0; n < 3; ++n)
      sides.push_back({std::min(f[n], f[(n + 1) % 3]), std::max(f[n], f[(n + 1) % 3]), t});
  }
  if (!(twice_area > 0)) return {};

  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.from, a.to, a.triangle) < std::tie(b.from, b.to, b.triangle);
  });
  Furrows furrows;
  for (std::size_t n = 0; n + 1 < sides.size(); ++n) {
    const Side &one = sides[n], &other = sides[n + 1];
    if (one.from != other.from || one.to != other.to) continue;
    const Vec3d normal = doubleAreaVector(solid, one.triangle).normalized();
    const Vec3d next = doubleAreaVector(solid, other.triangle).normalized();
    Vec3d across = Vec3d::Zero();
    for (int corner = 0; corner < 3; ++corner)
      across += solid.corner(other.triangle, corner) - solid.corner(one.triangle, corner);
    if (!(across.dot(normal) > 0)) continue;
    const double length = (solid.vertices[one.from] - solid.vertices[one.to]).norm();
    furrows.sum += length * std::atan2(normal.cross(next).norm(), normal.dot(next));
  }
  furrows.per_area = 2 * furrows.sum / twice_area;
  return furrows;
}

// The occlusal planes of a solid with unknown up: the one found from each of the six axes.
std::vector<OcclusalPlane> planesOf(const Mesh& solid) {
  constexpr double kFlat = 0.05;  // mm: tips so close to one plane are a face
  std::vector<OcclusalPlane> planes;
  for (int n = 0; n < 6; ++n) {
    const auto found = findOcclusalPlane(solid, (n < 3 ? 1.0 : -1.0) * Vec3d::Unit(n % 3));
    if (found && found->rms_mm > kFlat) planes.push_back(*found);
  }
  return planes;
}

// Guards a slow search: a tooth is smaller.
bool isAsLargeAsAnArch(const Mesh& mesh) {
  constexpr double kDeep = 20;  // mm
  Vec3d size = bounds(mesh).size();
  std::sort(size.begin(), size.end());
  return size[1] > kDeep;
}

// The plane of a full arch whose biting side is certain: by far the more furrowed one. Tips do not decide: crowns
// closed at their necks have as many there. None: no arch, as a tooth or a bone, or sides too much alike.
std::optional<OcclusalPlane> sureArchOf(const Mesh& solid, const std::vector<OcclusalPlane>& planes) {
  constexpr double kLeastPerArea = 0.15;  // 1/mm
  constexpr double kTimesOther = 1.4;     // the furrows of the other side; crowns closed at their necks: 1.56
  constexpr double kSameSide = 0.7;       // cosine of the angle between two normals
  struct Arch {
    OcclusalPlane plane;
    Furrows furrows;
  };
  std::vector<Arch> arches;
  for (const OcclusalPlane& plane : planes)
    if (findDentalArch(solid, plane)) arches.push_back({plane, furrowsOf(solid, plane)});
  if (arches.empty()) return {};

  const Arch& best = *std::max_element(arches.begin(), arches.end(),
                                       [](const Arch& a, const Arch& b) { return a.furrows.sum < b.furrows.sum; });
  const bool is_doubtful = std::any_of(arches.begin(), arches.end(), [&](const Arch& other) {
    return other.plane.normal.dot(best.plane.normal) < kSameSide && best.furrows.sum < kTimesOther * other.furrows.sum;
  });
  if (best.furrows.per_area < kLeastPerArea || is_doubtful) return {};
  return best.plane;
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

  const std::vector<OcclusalPlane> planes = planesOf(solid);
  if (const auto sure = sureArchOf(solid, planes)) return of(*sure);
  std::optional<OcclusalPlane> best;
  double best_score = 0;
  for (const OcclusalPlane& plane : planes) {
    const double score = static_cast<double>(plane.tips) * (1 - shareNear(solid, plane));
    if (score <= best_score) continue;
    best = plane;
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
  if (!up && isAsLargeAsAnArch(mesh))
    if (const auto arch = sureArchOf(mesh, planesOf(mesh))) up = arch->normal;
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
