#include "preprocess/close/occlusal_plane.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

namespace kerf {
namespace {

constexpr double kCell = 2;         ///< mm: a tip is the highest point of its cell and of the eight around it
constexpr double kTolerance = 1;    ///< mm between a tip and the plane
constexpr double kLeastSpread = 6;  ///< mm: three tips span a triangle at least this high
constexpr std::size_t kLeastTips = 6;
constexpr std::size_t kMostCandidates = 120;              ///< the search is cubic; the highest are taken
constexpr double kCosMostTilt = std::numbers::sqrt2 / 2;  // 45 degrees
constexpr int kSearches = 3, kMostRounds = 10;

/// Local maxima of the height along `up`, highest first.
std::vector<Vec3d> highPoints(const Mesh& mesh, const Vec3d& up) {
  int least = 0;
  up.cwiseAbs().minCoeff(&least);
  const Vec3d u = (Vec3d::Unit(least) - up[least] * up).normalized(), v = up.cross(u);
  struct Top {
    double height;
    std::uint32_t vertex;
  };
  std::vector<char> used(mesh.vertices.size(), 0);
  for (const Triangle& f : mesh.triangles)
    for (const std::uint32_t i : f) used[i] = 1;

  std::map<std::array<long, 2>, Top> cells;
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!used[i]) continue;
    const Vec3d& p = mesh.vertices[i];
    const double height = p.dot(up);
    const std::array<long, 2> cell{std::lround(std::floor(p.dot(u) / kCell)),
                                   std::lround(std::floor(p.dot(v) / kCell))};
    const auto [it, fresh] = cells.try_emplace(cell, Top{height, i});
    if (!fresh && height > it->second.height) it->second = {height, i};
  }

  std::vector<Top> tops;
  for (const auto& [cell, top] : cells) {
    bool highest = true;
    for (long dx = -1; dx <= 1; ++dx)
      for (long dy = -1; dy <= 1; ++dy) {
        const auto it = cells.find({cell[0] + dx, cell[1] + dy});
        if (it != cells.end() && it->second.height > top.height) highest = false;
      }
    if (highest) tops.push_back(top);
  }
  std::sort(tops.begin(), tops.end(), [](const Top& a, const Top& b) {
    return a.height != b.height ? a.height > b.height : a.vertex < b.vertex;
  });

  if (tops.size() > kMostCandidates) tops.resize(kMostCandidates);
  std::vector<Vec3d> points;
  for (const Top& t : tops) points.push_back(mesh.vertices[t.vertex]);
  return points;
}

struct Fit {
  Vec3d normal, point;
  std::vector<char> on;  ///< per candidate
  long score = -1;
};

Fit judge(const std::vector<Vec3d>& points, const Vec3d& normal, const Vec3d& point) {
  Fit f{normal, point, std::vector<char>(points.size(), 0), 0};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double d = (points[i] - point).dot(normal);
    f.on[i] = std::abs(d) <= kTolerance;
    f.score += f.on[i] ? 1 : d > 0 ? -1 : 0;
  }
  return f;
}

/// The best plane through three candidates.
Fit search(const std::vector<Vec3d>& points, const Vec3d& up) {
  Fit best;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j)
      for (std::size_t k = j + 1; k < points.size(); ++k) {
        const Vec3d a = points[j] - points[i], b = points[k] - points[i];
        Vec3d n = a.cross(b);
        const double longest = std::max({a.norm(), b.norm(), (a - b).norm()}), twice_area = n.norm();
        if (!(twice_area >= kLeastSpread * longest)) continue;
        n /= twice_area;
        if (n.dot(up) < 0) n = -n;
        if (n.dot(up) < kCosMostTilt) continue;

        long score = 0;
        for (const Vec3d& p : points) {
          const double d = (p - points[i]).dot(n);
          score += std::abs(d) <= kTolerance ? 1 : d > 0 ? -1 : 0;
        }
        if (score > best.score) {
          best.score = score;
          best.normal = n;
          best.point = points[i];
        }
      }

  if (best.score < 0) return best;
  return judge(points, best.normal, best.point);
}

Error none(std::size_t tips) {
  Error e;
  e.code = Error::Code::kGeometry;
  e.found = fmt::format("no occlusal plane: {} high points agree on one", tips);
  e.expected = fmt::format("at least {} cusp tips within {} mm of a plane, not in a line", kLeastTips, kTolerance);
  e.hint = "--occlusal-plane NX,NY,NZ with the plane's normal";
  return e;
}

/// Square to the two directions in which the mesh is widest: an arch is flat. Points the way `up` does.
Vec3d flattest(const Mesh& mesh, const Vec3d& up) {
  Vec3d mean = Vec3d::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec3d& p : mesh.vertices) mean += p / static_cast<double>(mesh.vertices.size());
  for (const Vec3d& p : mesh.vertices) spread += (p - mean) * (p - mean).transpose();
  const Vec3d n = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
  return n.dot(up) < 0 ? Vec3d(-n) : n;
}

/// Searches and fits by turns, starting with high points as seen from `from`.
Expected<OcclusalPlane> settle(const Mesh& mesh, const Vec3d& from, const Vec3d& up) {
  OcclusalPlane plane;
  plane.normal = from;
  for (int round = 0; round < kMostRounds; ++round) {
    const std::vector<Vec3d> points = highPoints(mesh, plane.normal);
    const Fit fit = round < kSearches ? search(points, up) : judge(points, plane.normal, plane.point);

    // The points on it, their mean and their spread.
    Vec3d mean = Vec3d::Zero();
    plane.tips = 0;
    for (std::size_t i = 0; i < fit.on.size(); ++i)
      if (fit.on[i]) {
        mean += points[i];
        ++plane.tips;
      }
    if (plane.tips < 3) return fail(none(plane.tips));
    mean /= static_cast<double>(plane.tips);
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < fit.on.size(); ++i)
      if (fit.on[i]) spread += (points[i] - mean) * (points[i] - mean).transpose();

    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
    const double count = static_cast<double>(plane.tips);
    Vec3d normal = axes.eigenvectors().col(0);
    if (normal.dot(up) < 0) normal = -normal;
    const bool in_a_line = std::sqrt(axes.eigenvalues()[1] / count) < kLeastSpread / 3;
    if (in_a_line || normal.dot(up) < kCosMostTilt) return fail(none(plane.tips));
    plane.rms_mm = std::sqrt(std::max(0.0, axes.eigenvalues()[0] / count));

    const bool settled = (normal - plane.normal).norm() < 1e-6 && std::abs((mean - plane.point).dot(normal)) < 1e-6;
    plane.normal = normal;
    plane.point = mean;
    if (settled && round >= kSearches) break;
  }
  if (plane.tips < kLeastTips) return fail(none(plane.tips));
  return plane;
}

}  // namespace

Expected<OcclusalPlane> findOcclusalPlane(const Mesh& mesh_mm, const Vec3d& up) {
  // The rim of a scan gives its underside only within about 40 degrees: the nearest axis and the direction in which the
  // arch is flattest are often better starts.
  const Vec3d open = up.normalized();
  int axis = 0;
  open.cwiseAbs().maxCoeff(&axis);
  Expected<OcclusalPlane> best = settle(mesh_mm, open, open);
  for (const Vec3d& from : {Vec3d((open[axis] < 0 ? -1.0 : 1.0) * Vec3d::Unit(axis)), flattest(mesh_mm, open)}) {
    if (from.dot(open) < kCosMostTilt) continue;
    auto plane = settle(mesh_mm, from, open);
    if (plane && (!best || plane->tips > best->tips)) best = plane;
  }
  return best;
}

}  // namespace kerf
