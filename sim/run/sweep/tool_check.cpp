#include "sim/run/sweep/tool_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/field/marching_cubes.h"
#include "geometry/field/sample_field.h"
#include "geometry/tool/sweep.h"
#include "sim/run/sweep/sweep_cutter.h"

namespace kerf {
namespace {

// Long edges meet a block this wide, mm; the ends of longer edges stay outside.
constexpr double kBlockWidth = 4;

double plungeDepth(const Tool& tool) {
  constexpr double kDeepest = 3;  // mm
  if (tool.kind == ToolKind::kBlade) return kDeepest;
  if (tool.kind == ToolKind::kMesh) return std::min(1.5 * tool.cut->bounds().size()[2], kDeepest);
  return std::min(tool.cuts_end ? 1.5 * tool.head_length_mm : tool.head_diameter_mm, kDeepest);
}

// The block in the tool's frame with the tip just touching: it begins at the contact of the cutting part and extends
// along the plunge. Also sets width and expected volume.
Box3 blockFor(const Tool& tool, double h, ToolCheck& out) {
  Box3 block = tool.cut->bounds();
  block.grow(6 * h);

  if (const int along = tool.motion ? tool.motion->edge_axis : -1; along >= 0) {
    out.block_width_mm = std::min(kBlockWidth, tool.cut->bounds().size()[along]);
    if (out.block_width_mm == kBlockWidth) {
      const double middle = tool.cut->bounds().center()[along];
      block.min[along] = middle - 0.5 * kBlockWidth;
      block.max[along] = middle + 0.5 * kBlockWidth;
      out.expected_mm3 = plungeVolume(tool, out.depth_mm, kBlockWidth);
    }
  }
  if (out.expected_mm3 == 0) out.expected_mm3 = plungeVolume(tool, out.depth_mm);

  const int axis = tool.plunge_direction[2] != 0 ? 2 : 0;
  const double touch = tool.cut->bounds().min[axis];
  block.max[axis] = touch;
  block.min[axis] = touch - out.depth_mm - 6 * h;
  return block;
}

BrickField sampleBlock(const Box3& block, const Rigid3& pose, double h) {
  const Rigid3 back = pose.inverse();
  const BoxShape solid(block);
  return sampleDistance([&](const Vec3d& p) { return solid.distance(back * p); }, block.transformed(pose), h);
}

// The intersection of block and sweep.
BrickField intersection(const BrickField& phi0, const BrickField& psi) {
  BrickField removed(phi0.voxel(), psi.background());
  BrickValues values;
  for (std::size_t b = 0; b < psi.brickCount(); ++b) {
    const Vec3i c = psi.brickCoord(b);
    const int found = phi0.find(c);
    for (std::size_t n = 0; n < kBrickNodes; ++n)
      values[n] =
          std::max(psi.brick(b)[n], found < 0 ? phi0.constantAt(c) : phi0.brick(static_cast<std::size_t>(found))[n]);
    removed.add(c, values);
  }
  return removed;
}

}  // namespace

double defaultVoxel(const Tool& tool) {
  if (tool.kind == ToolKind::kBlade) return tool.thickness_mm / 10;
  const Vec3d size = tool.cut->bounds().size();
  return std::min(std::min(size[0], size[1]) / 20, tool.finest() / 6);
}

Expected<ToolCheck> checkTool(const Tool& tool, double voxel_mm, const Progress& progress) {
  ToolCheck out;
  const double thinnest = tool.finest();
  out.depth_mm = plungeDepth(tool);
  // A wide head cuts a shallow bowl: its depth must be resolved, too.
  const double resolved = std::max(std::min(defaultVoxel(tool), out.depth_mm / 12), thinnest / 100);
  const double h = out.voxel_mm = voxel_mm == 0 ? resolved : voxel_mm;
  // The block is sampled whole: finer than a hundredth of the tool exhausts memory without a result.
  if (!(h >= thinnest / 100 && h <= thinnest / 3))
    return fail({.code = Error::Code::kBadValue,
                 .place = "voxel",
                 .found = fmt::format("{} mm", voxel_mm),
                 .expected = fmt::format("{:.3g} to {:.3g} mm, a hundredth to a third of the tool", thinnest / 100,
                                         thinnest / 3),
                 .hint = "omit --voxel"});

  if (!report(progress, 0.0, "preparing a block")) return cancelled();
  const Box3 block = blockFor(tool, h, out);
  const Rigid3 askew{Eigen::Quaterniond(Eigen::AngleAxisd(0.6, Vec3d(1, 2, 3).normalized())),
                     0.37 * h * Vec3d(1, -1, 1)};
  const BrickField phi0 = sampleBlock(block, askew, h);

  SweepCutter cutter(phi0);
  const Vec3d way = tool.plunge_direction;
  const Rigid3 from = askew * Rigid3{Eigen::Quaterniond::Identity(), Vec3d(-way * 6 * h)};
  const Rigid3 to = askew * Rigid3{Eigen::Quaterniond::Identity(), Vec3d(way * out.depth_mm)};
  bool is_cancelled = false;
  const auto goesOn = [&](double done) {
    is_cancelled = !report(progress, 0.1 + 0.85 * done, "plunging");
    return !is_cancelled;
  };
  cutter.advance(SweptTool(*tool.cut, from, to), goesOn);
  if (is_cancelled || !report(progress, 0.95, "measuring")) return cancelled();
  out.removed_mm3 = signedVolume(marchingCubes(intersection(phi0, cutter.sweep())));
  return out;
}

}  // namespace kerf
