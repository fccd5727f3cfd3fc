#include "sim/run/tool_resolution.h"

#include <fmt/format.h>

#include <algorithm>

namespace kerf {
namespace {

constexpr double kFewestAcross = 1.8;             // voxels
constexpr double kPointed = 3, kPointLength = 4;  // voxels
constexpr double kFine = 0.1;                     // mm: as far as a third was measured
constexpr double kFinest = 0.02;                  // mm: what a case may have

// Of both parts: negative inside.
double distanceOf(const Tool& tool, const Vec3d& at) {
  return tool.body ? std::min(tool.cut->distance(at), tool.body->distance(at)) : tool.cut->distance(at);
}

}  // namespace

double pointLength(const Tool& tool, double width_mm) {
  if (!tool.cut || tool.kind == ToolKind::kBlade || !(width_mm > 0)) return 0;
  const Box3 box = tool.cut->bounds();
  const double step = 0.05 * width_mm;
  for (double z = box.min[2] + step; z < box.max[2]; z += step)
    if (-distanceOf(tool, {0, 0, z}) >= 0.5 * width_mm) return z - box.min[2];
  return tool.kind == ToolKind::kMesh ? 0 : box.size()[2];
}

std::optional<CoarseVoxels> tooCoarseFor(const Tool& tool, double voxel_mm) {
  if (!(voxel_mm > 0)) return std::nullopt;
  const double across = tool.finest();
  if (across < kFewestAcross * voxel_mm)
    return CoarseVoxels{
        fmt::format("{} cuts {:.1f} voxels wide: volumes may be off by a tenth and more", tool.id, across / voxel_mm),
        std::max(kFinest, across / 3)};

  const double point = pointLength(tool, kPointed * voxel_mm);
  const bool is_slender = tool.kind == ToolKind::kBur && tool.head_diameter_mm < kPointed * voxel_mm;
  if (!is_slender && point <= kPointLength * voxel_mm) return std::nullopt;
  return CoarseVoxels{fmt::format("{} is thinner than three voxels for {:.1f} mm: plunges by hand may be off by {}",
                                  tool.id, point, voxel_mm > kFine ? "half" : "a third"),
                      std::max(kFinest, 0.5 * voxel_mm)};
}

}  // namespace kerf
