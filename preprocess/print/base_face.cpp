#include "preprocess/print/base_face.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace kerf {
namespace {

constexpr double kFlat = 0.05;               // mm
constexpr double kTowards = 0.906;           // cosine
constexpr double kSameDirection = 0.999;     // cosine
constexpr double kLeastArea = 20;            // mm^2
constexpr double kLeastShare = 0.02;         // of the surface
constexpr std::size_t kMostCandidates = 64;  // planes compared
constexpr double kNormalSteps = 20;          // of a normal's coordinate from 0 to 1
constexpr double kHeightStep = 0.5;          // mm

// The outermost vertices in some directions: they rule out most planes.
std::vector<Vec3d> extremes(const Mesh& mesh) {
  std::vector<Vec3d> out;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        const Vec3d direction(x, y, z);
        if (direction.isZero()) continue;
        out.push_back(
            *std::max_element(mesh.vertices.begin(), mesh.vertices.end(),
                              [&](const Vec3d& a, const Vec3d& b) { return a.dot(direction) < b.dot(direction); }));
      }
  return out;
}

bool allBelow(const std::vector<Vec3d>& points, const Plane& plane) {
  return std::all_of(points.begin(), points.end(), [&](const Vec3d& p) { return plane.height(p) <= kFlat; });
}

}  // namespace

std::optional<BaseFace> findBase(const Mesh& solid, const Vec3d& down) {
  if (solid.triangles.empty()) return {};
  const std::size_t count = solid.triangles.size();
  std::vector<Vec3d> normals(count);
  std::vector<double> areas(count);
  double surface = 0;
  const Vec3d middle_of_box = bounds(solid).center();
  for (std::size_t t = 0; t < count; ++t) {
    const Vec3d twice = doubleAreaVector(solid, t);
    areas[t] = 0.5 * twice.norm();
    surface += areas[t];
    normals[t] = areas[t] > 0 ? Vec3d(twice.normalized()) : Vec3d(Vec3d::Zero());
  }
  // Planes, roughly: triangles of about the same normal and height. The one with most area first.
  struct Candidate {
    double area_mm2 = 0;
    std::uint32_t largest = 0;  // triangle
  };
  std::map<std::array<int, 4>, Candidate> planes;
  for (std::uint32_t t = 0; t < count; ++t) {
    if (areas[t] == 0) continue;
    const Eigen::Vector3i n = (kNormalSteps * normals[t]).array().round().cast<int>();
    const int height = static_cast<int>(std::lround(normals[t].dot(solid.corner(t, 0) - middle_of_box) / kHeightStep));
    const auto [it, is_new] = planes.try_emplace({n[0], n[1], n[2], height}, Candidate{0, t});
    if (areas[t] > areas[it->second.largest]) it->second.largest = t;
    it->second.area_mm2 += areas[t];
  }
  std::vector<Candidate> candidates;
  for (const auto& plane : planes) candidates.push_back(plane.second);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.area_mm2 > b.area_mm2; });
  if (candidates.size() > kMostCandidates) candidates.resize(kMostCandidates);

  const std::vector<Vec3d> outermost = extremes(solid);
  std::vector<char> is_counted(count, 0);
  std::optional<BaseFace> best;
  for (const Candidate& candidate : candidates) {
    const std::uint32_t t = candidate.largest;
    if (is_counted[t]) continue;
    const Plane plane{solid.corner(t, 0), normals[t]};
    if (!allBelow(outermost, plane) || !allBelow(solid.vertices, plane)) continue;
    BaseFace face;
    Vec3d normal = Vec3d::Zero(), middle = Vec3d::Zero();
    for (std::size_t other = 0; other < count; ++other) {
      const Vec3d center = (solid.corner(other, 0) + solid.corner(other, 1) + solid.corner(other, 2)) / 3;
      if (normals[other].dot(plane.normal) < kSameDirection || plane.height(center) < -kFlat) continue;
      is_counted[other] = 1;
      face.area_mm2 += areas[other];
      normal += areas[other] * normals[other];
      middle += areas[other] * center;
    }
    face.plane = {middle / face.area_mm2, normal.normalized()};
    if (face.area_mm2 < std::max(kLeastArea, kLeastShare * surface)) continue;
    const auto rank = [&](const BaseFace& f) {
      return std::pair(f.plane.normal.dot(down.stableNormalized()) > kTowards, f.area_mm2);
    };
    if (!best || rank(face) > rank(*best)) best = face;
  }
  return best;
}

}  // namespace kerf
