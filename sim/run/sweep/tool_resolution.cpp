#include "sim/run/sweep/tool_resolution.h"

#include <fmt/format.h>

#include <algorithm>

namespace kerf {
namespace {

constexpr double kFewestAcross = 1.8;                  // voxels
constexpr double kPointed = 3, kPointLength = 4;       // voxels
constexpr double kFine = 0.1;                          // mm: measured errors up to a third
constexpr double kFinest = 0.005;                      // mm: least voxel size of a case
constexpr double kWithinLimit = 0.95;                  // keeps advice valid after rounding to two digits
constexpr double kRounding = 1e-9;                     // mm
constexpr double kPointWidth = 0.3, kLongPoint = 0.4;  // mm

// Distance of both parts: negative inside.
double distanceOf(const Tool& tool, const Vec3d& at) {
  return tool.body ? std::min(tool.cut->distance(at), tool.body->distance(at)) : tool.cut->distance(at);
}

}  // namespace

double pointLength(const Tool& tool, double width_mm) {
  if (!tool.cut || tool.kind == ToolKind::kBlade || !(width_mm > 0)) return 0;
  const Box3 box = tool.cut->bounds();
  const double step = 0.05 * width_mm;
  bool is_solid = tool.kind != ToolKind::kMesh;
  for (double z = box.min[2] + step; z < box.max[2]; z += step) {
    const double inside = -distanceOf(tool, {0, 0, z});
    if (inside >= 0.5 * width_mm) return z - box.min[2];
    is_solid |= inside > 0;
  }
  return is_solid ? box.size()[2] : 0;
}

bool isPointed(const Tool& tool) { return pointLength(tool, kPointWidth) > kLongPoint; }

std::optional<CoarseVoxels> tooCoarseFor(const Tool& tool, double voxel_mm, Held held) {
  if (!(voxel_mm > 0)) return std::nullopt;
  const double across = tool.finest();
  if (across < kFewestAcross * voxel_mm)
    return CoarseVoxels{
        fmt::format("{} cuts {:.1f} voxels wide: volumes may be off by a tenth and more", tool.id, across / voxel_mm),
        std::max(kFinest, kWithinLimit * across / 3)};

  const bool is_fine = voxel_mm <= kFine + kRounding;
  if (held == Held::kOnPath && is_fine) return std::nullopt;
  const double point = pointLength(tool, kPointed * voxel_mm);
  const bool is_slender = tool.kind == ToolKind::kBur && tool.head_diameter_mm < kPointed * voxel_mm - kRounding;
  if (!is_slender && point <= kPointLength * voxel_mm) return std::nullopt;
  const std::string what = fmt::format("{} is thinner than three voxels for {:.1f} mm", tool.id, point);
  const char* then = held == Held::kOnPath ? "volumes may be off by a tenth"
                     : is_fine             ? "plunges by hand may be off by a third"
                                           : "plunges by hand may be off by half";
  const double finer = held == Held::kOnPath ? kFine : std::max(kFinest, 0.5 * voxel_mm);
  return CoarseVoxels{what + ": " + then, finer};
}

}  // namespace kerf
