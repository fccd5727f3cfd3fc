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

}  // namespace

Expected<Kept> keepWindingBoundary(const Mesh& chain, const Arrangement& arrangement, const Progress& progress) {
  Kept kept;
  std::uint32_t count = 0;
  const std::vector<std::uint32_t> label = patchLabels(arrangement.triangles, count);
  kept.patches = count;
  // The fattest triangle of each patch: its incentre is farthest from everything else.
  std::vector<std::uint32_t> fattest(count, kAdded);
  std::vector<double> fatness(count, -1);
  std::vector<Vec3d> probe(count);
  for (std::uint32_t t = 0; t < arrangement.triangles.size(); ++t) {
    const Triangle& f = arrangement.triangles[t];
    const Vec3d &a = arrangement.points[f[0]], &b = arrangement.points[f[1]], &c = arrangement.points[f[2]];
    const double la = (b - c).norm(), lb = (c - a).norm(), lc = (a - b).norm(), perimeter = la + lb + lc;
    const double radius = perimeter > 0 ? (b - a).cross(c - a).norm() / perimeter : 0;
    const std::uint32_t l = label[t];
    if (!(radius > fatness[l])) continue;
    fatness[l] = radius;
    fattest[l] = t;
    probe[l] = perimeter > 0 ? Vec3d((la * a + lb * b + lc * c) / perimeter) : a;
  }
  std::vector<double> behind(count);  // winding number on the back of the patch
  // Solid angles of all triangles tell an open surface too, but sponges have thousands of patches.
  constexpr double kMostAngles = 1e8;  // some seconds
  std::optional<RayWinding> rays;
  if (static_cast<double>(count) * static_cast<double>(chain.triangles.size()) > kMostAngles) rays.emplace(chain);
  const auto look = [&](std::uint32_t l) {
    const std::uint32_t t = fattest[l];
    // The patch itself counts half: leave out the chain triangles it lies in, add half its multiplicity.
    const std::span<const std::uint32_t> except = arrangement.twin_of[t] == kAdded
                                                      ? std::span(&arrangement.parent[t], 1)
                                                      : std::span(arrangement.twins[arrangement.twin_of[t]]);
    if (rays) {
      const Triangle& f = arrangement.triangles[t];
      const Vec3d &a = arrangement.points[f[0]], &b = arrangement.points[f[1]], &c = arrangement.points[f[2]];
      const Vec3d normal = (b - a).cross(c - a).normalized();
      const auto ahead = rays->at(
          probe[l], [&](std::uint32_t s) { return std::find(except.begin(), except.end(), s) != except.end(); });
      const double facing = normal.dot(rays->direction());
      if (ahead && std::abs(facing) > 1e-3) {
        behind[l] = *ahead + (facing > 0 ? arrangement.multiplicity[t] : 0);
        return;
      }
    }
    behind[l] = windingNumberExcept(chain, probe[l], except) + 0.5 * arrangement.multiplicity[t];
  };
  constexpr std::uint32_t kAtOnce = 256;  // between two looks at whether to go on
  for (std::uint32_t from = 0; from < count; from += kAtOnce) {
    if (!report(progress, 0.6 + 0.2 * from / count, "winding numbers")) return cancelledError();
    tbb::parallel_for(from, std::min(count, from + kAtOnce), look);
  }
  std::vector<char> keep_patch(count);
  for (std::uint32_t l = 0; l < count; ++l) {
    const double whole = std::round(behind[l]);
    // A patch a few nanometres wide (below float32) may be probed too near its rim: it decides nothing visible.
    if (std::abs(behind[l] - whole) > 0.1 && fatness[l] > 1e-7) {
      Error error;
      error.code = Error::Code::kGeometry;
      error.place = fmt::format("near ({:.3f}, {:.3f}, {:.3f}) mm", probe[l].x(), probe[l].y(), probe[l].z());
      error.found = fmt::format("a winding number of {:.3f}", behind[l]);
      error.expected = "a whole number: the surface is not closed";
      error.hint = "--close wrap";
      return fail(std::move(error));
    }
    keep_patch[l] = whole >= 1 && whole - arrangement.multiplicity[fattest[l]] <= 0;
    kept.patches_kept += keep_patch[l] != 0;
  }
  kept.keep.resize(arrangement.triangles.size());
  for (std::size_t t = 0; t < kept.keep.size(); ++t) kept.keep[t] = keep_patch[label[t]];
  return kept;
}

}  // namespace kerf::internal
