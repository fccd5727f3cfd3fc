#include "sim/tool_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/marching_cubes.h"
#include "geometry/sample_field.h"
#include "geometry/sweep.h"
#include "sim/sweep_cutter.h"

namespace kerf {

double defaultVoxel(const Tool& tool) {
  return tool.kind == ToolKind::kBur ? tool.head_diameter_mm / 20 : tool.thickness_mm / 10;
}

Expected<ToolCheck> checkTool(const Tool& tool, double voxel_mm) {
  ToolCheck out;
  const bool is_bur = tool.kind == ToolKind::kBur;
  const double thinnest = is_bur ? tool.head_diameter_mm : tool.kerfWidth();
  const double h = out.voxel_mm = voxel_mm == 0 ? defaultVoxel(tool) : voxel_mm;
  // The block is sampled whole: finer than a hundredth of the tool, memory runs out before anything is learnt.
  if (!(h >= thinnest / 100 && h <= thinnest / 3))
    return fail({Error::Code::kBadValue, "", "voxel", fmt::format("{} mm", voxel_mm),
                 fmt::format("{:.3g} to {:.3g} mm, a hundredth to a third of the tool", thinnest / 100, thinnest / 3),
                 ""});
  out.depth_mm = is_bur ? std::min(1.5 * tool.head_length_mm, 3.0) : 3.0;
  out.expected_mm3 = plungeVolume(tool, out.depth_mm);

  // In the tool's frame with the tip just touching: the block begins at the tip and reaches on along the plunge.
  const Vec3d way = tool.plunge_direction;
  Box3 block = tool.cut->bounds();
  block.grow(6 * h);
  if (!is_bur) {
    const double envelope = tool.blade_length_mm + tool.stroke_mm, middle = 0.5 * tool.blade_length_mm;
    out.block_width_mm = std::min(4.0, envelope);
    if (out.block_width_mm < envelope) {  // otherwise the whole blade goes in, ends and all
      block.min[2] = middle - 0.5 * out.block_width_mm, block.max[2] = middle + 0.5 * out.block_width_mm;
      out.expected_mm3 *= out.block_width_mm / envelope;
    }
  }
  const int axis = is_bur ? 2 : 0;
  block.max[axis] = 0, block.min[axis] = -out.depth_mm - 6 * h;

  const Rigid3 askew{Eigen::Quaterniond(Eigen::AngleAxisd(0.6, Vec3d(1, 2, 3).normalized())),
                     0.37 * h * Vec3d(1, -1, 1)};
  const Rigid3 back = askew.inverse();
  const BoxShape solid(block);
  Box3 around;
  for (int c = 0; c < 8; ++c)
    around.add(askew * Vec3d(c & 1 ? block.max[0] : block.min[0], c & 2 ? block.max[1] : block.min[1],
                             c & 4 ? block.max[2] : block.min[2]));
  const BrickField phi0 = sampleDistance([&](const Vec3d& p) { return solid.distance(back * p); }, around, h);

  SweepCutter cutter(phi0);
  const Rigid3 from = askew * Rigid3{Eigen::Quaterniond::Identity(), Vec3d(-way * 6 * h)};
  const Rigid3 to = askew * Rigid3{Eigen::Quaterniond::Identity(), Vec3d(way * out.depth_mm)};
  cutter.advance(SweptTool(*tool.cut, from, to));

  // What is in the block and in the sweep.
  const BrickField& psi = cutter.sweep();
  BrickField removed(h, psi.background());
  BrickValues values;
  for (std::size_t b = 0; b < psi.brickCount(); ++b) {
    const Vec3i c = psi.brickCoord(b);
    const int found = phi0.find(c);
    for (std::size_t n = 0; n < kBrickNodes; ++n)
      values[n] =
          std::max(psi.brick(b)[n], found < 0 ? phi0.constantAt(c) : phi0.brick(static_cast<std::size_t>(found))[n]);
    removed.add(c, values);
  }
  out.removed_mm3 = signedVolume(marchingCubes(removed));
  return out;
}

}  // namespace kerf
