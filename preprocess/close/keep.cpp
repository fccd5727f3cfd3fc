// Which triangles of an arrangement bound {winding number >= 1}.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "preprocess/close/arrangement.h"
#include "preprocess/close/poll.h"
#include "preprocess/close/winding.h"

namespace kerf::internal {
namespace {

/// Triangles connected through edges that exactly two of them share: the winding numbers on either side are constant.
std::vector<std::uint32_t> patchLabels(const std::vector<Triangle>& triangles, std::uint32_t& count) {
  struct Use {
    std::uint64_t edge;
    std::uint32_t t;
  };
  std::vector<Use> uses;
  uses.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t p = triangles[t][k], q = triangles[t][(k + 1) % 3];
      uses.push_back({(std::min(p, q) << 32) | std::max(p, q), t});
    }
  std::sort(uses.begin(), uses.end(),
            [](const Use& x, const Use& y) { return x.edge != y.edge ? x.edge < y.edge : x.t < y.t; });

  std::vector<std::uint32_t> parent(triangles.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto find = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::size_t i = 0, j = 0; i < uses.size(); i = j) {
    while (j < uses.size() && uses[j].edge == uses[i].edge) ++j;
    if (j - i != 2) continue;
    const std::uint32_t a = find(uses[i].t), b = find(uses[i + 1].t);
    if (a != b) parent[std::max(a, b)] = std::min(a, b);
  }

  std::vector<std::uint32_t> label(triangles.size());
  count = 0;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const std::uint32_t root = find(t);
    label[t] = root == t ? count++ : label[root];
  }
  return label;
}

/// Sample points for the winding number of each patch.
struct Probes {
  std::vector<std::uint32_t> fattest;  ///< the triangle: its incentre is farthest from everything else
  std::vector<double> fatness;         ///< mm, the radius of its incircle
  std::vector<Vec3d> point;            ///< that incentre
};

Probes probesOf(const Arrangement& arrangement, const std::vector<std::uint32_t>& label, std::uint32_t count) {
  Probes out{std::vector<std::uint32_t>(count, kAdded), std::vector<double>(count, -1), std::vector<Vec3d>(count)};
  for (std::uint32_t t = 0; t < arrangement.triangles.size(); ++t) {
    const Triangle& f = arrangement.triangles[t];
    const Vec3d &a = arrangement.points[f[0]], &b = arrangement.points[f[1]], &c = arrangement.points[f[2]];
    const double la = (b - c).norm(), lb = (c - a).norm(), lc = (a - b).norm(), perimeter = la + lb + lc;
    const double radius = perimeter > 0 ? (b - a).cross(c - a).norm() / perimeter : 0;
    const std::uint32_t l = label[t];
    if (!(radius > out.fatness[l])) continue;
    out.fatness[l] = radius;
    out.fattest[l] = t;
    out.point[l] = perimeter > 0 ? Vec3d((la * a + lb * b + lc * c) / perimeter) : a;
  }
  return out;
}

/// Winding number of the chain on the back of a patch. @param t  its triangle at the probe.
double windingBehind(const Mesh& chain, const Arrangement& arrangement, std::uint32_t t, const Vec3d& probe,
                     const std::optional<RayWinding>& rays) {
  // The patch itself counts half: leave out the chain triangles it lies in, add half its multiplicity.
  const std::span<const std::uint32_t> except = arrangement.twin_of[t] == kAdded
                                                    ? std::span(&arrangement.parent[t], 1)
                                                    : std::span(arrangement.twins[arrangement.twin_of[t]]);
  if (rays) {
    const Triangle& f = arrangement.triangles[t];
    const Vec3d &a = arrangement.points[f[0]], &b = arrangement.points[f[1]], &c = arrangement.points[f[2]];
    const Vec3d normal = (b - a).cross(c - a).normalized();
    const auto ahead =
        rays->at(probe, [&](std::uint32_t s) { return std::find(except.begin(), except.end(), s) != except.end(); });
    const double facing = normal.dot(rays->direction());
    if (ahead && std::abs(facing) > 1e-3) return *ahead + (facing > 0 ? arrangement.multiplicity[t] : 0);
  }
  return windingNumberExcept(chain, probe, except) + 0.5 * arrangement.multiplicity[t];
}

}  // namespace

Expected<Kept> keepWindingBoundary(const Mesh& chain, const Arrangement& arrangement, const Progress& progress) {
  Kept kept;
  std::uint32_t count = 0;
  const std::vector<std::uint32_t> label = patchLabels(arrangement.triangles, count);
  kept.patches = count;
  const Probes probes = probesOf(arrangement, label, count);

  // Solid angles of all triangles also detect an open surface, but sponges have thousands of patches.
  constexpr double kMostAngles = 1e8;  // some seconds
  std::optional<RayWinding> rays;
  if (static_cast<double>(count) * static_cast<double>(chain.triangles.size()) > kMostAngles) rays.emplace(chain);
  std::vector<double> behind(count);
  constexpr std::uint32_t kAtOnce = 256;  // before asking again whether to go on
  for (std::uint32_t from = 0; from < count; from += kAtOnce) {
    if (!report(progress, 0.6 + 0.2 * from / count, "winding numbers")) return cancelled();
    tbb::parallel_for(from, std::min(count, from + kAtOnce), [&](std::uint32_t l) {
      behind[l] = windingBehind(chain, arrangement, probes.fattest[l], probes.point[l], rays);
    });
  }

  std::vector<char> keep_patch(count);
  for (std::uint32_t l = 0; l < count; ++l) {
    const double whole = std::round(behind[l]);
    // A patch a few nanometres wide (below float32) may be probed too near its rim: it decides nothing visible.
    if (std::abs(behind[l] - whole) > 0.1 && probes.fatness[l] > 1e-7) {
      const Vec3d& p = probes.point[l];
      return fail({.code = Error::Code::kGeometry,
                   .place = fmt::format("near ({:.3f}, {:.3f}, {:.3f}) mm", p.x(), p.y(), p.z()),
                   .found = fmt::format("a winding number of {:.3f}", behind[l]),
                   .expected = "a whole number: the surface is not closed",
                   .hint = "--close wrap"});
    }
    keep_patch[l] = whole >= 1 && whole - arrangement.multiplicity[probes.fattest[l]] <= 0;
    kept.patches_kept += keep_patch[l] != 0;
  }
  kept.keep.resize(arrangement.triangles.size());
  for (std::size_t t = 0; t < kept.keep.size(); ++t) kept.keep[t] = keep_patch[label[t]];
  return kept;
}

}  // namespace kerf::internal
