// Time of a geometry-only tool motion.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/bench.h"
#include "bench/scenes/fluted_mesh.h"
#include "geometry/tool/tool_shape.h"
#include "geometry/tool/turned_mesh.h"
#include "sim/run/sweep/sweep_cutter.h"

namespace kerf::cli {
namespace {

// A block of 12 x 8 x 5 mm with its top at z = 0. Every node of its box is stored.
BrickField blockField(double h) {
  Box3 box;
  box.add(Vec3d(-6, -4, -5));
  box.add(Vec3d(6, 4, 0));
  const BoxShape block(box);
  BrickField phi0(h, static_cast<float>(3 * h), static_cast<float>(-4 * h));
  const Vec3i low = brickOf((box.min / h).array().floor().cast<int>().matrix() - Vec3i::Constant(4));
  const Vec3i high = brickOf((box.max / h).array().ceil().cast<int>().matrix() + Vec3i::Constant(4));
  for (int x = low[0]; x <= high[0]; ++x)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int z = low[2]; z <= high[2]; ++z) {
        BrickValues& v = phi0.brick(phi0.touch({x, y, z}));
        for (int n = 0; n < kBrickNodes; ++n)
          v[static_cast<std::size_t>(n)] = static_cast<float>(std::clamp(
              block.distance(h * Vec3d(8 * x + (n >> 6), 8 * y + (n >> 3 & 7), 8 * z + (n & 7))), -4 * h, 3 * h));
      }
  return phi0;
}

// Tissue in the sweep, mm3, by counting nodes.
double removedBy(const SweepCutter& cutter, const BrickField& block) {
  std::size_t nodes = 0;
  for (std::size_t b = 0; b < cutter.sweep().brickCount(); ++b)
    if (const int at = block.find(cutter.sweep().brickCoord(b)); at >= 0)
      for (std::size_t n = 0; n < kBrickNodes; ++n)
        nodes += std::max(cutter.sweep().brick(b)[n], block.brick(static_cast<std::size_t>(at))[n]) < 0;
  return static_cast<double>(nodes) * std::pow(block.voxel(), 3);
}

}  // namespace

// A bur drawn through the block along a wavy line, 0.6 mm deep.
Expected<Result> benchCutBur(const Bench& bench) {
  KERF_TRY(tool, toolOfRack("round-014"));
  const BrickField phi0 = blockField(0.05);
  SweepCutter cutter(phi0), mesh_cutter(phi0);
  const double length = tool.cutting->highest();
  const Mesh mesh = flutedMesh([&](double z) { return tool.cutting->radiusAt(z); }, length);
  const auto turned = shapeOf(turnedMesh(mesh, 0, length));
  const auto pose = [](int n) {
    const double x = -4 + 0.02 * n;
    return Rigid3{Eigen::Quaterniond::Identity(), Vec3d(x, 0.6 * std::sin(x), -0.6)};
  };

  Result r(SceneId::kCutBur, "one motion of 0.02 mm of round-014 in a block at 0.05 mm");
  double mesh_ms = 0, bur_ms = 0;
  for (int n = 0; n < 400; ++n) {
    if (n % 16 == 0 && !report(bench.progress, n / 400.0, "cutting")) return cancelled();
    const double start = now();
    cutter.advance(SweptTool(*tool.cut, pose(n), pose(n + 1)));
    r.ms.push_back(now() - start);
    bur_ms += r.ms.back();
    const double mesh_start = now();
    mesh_cutter.advance(SweptTool(*turned, pose(n), pose(n + 1)));
    mesh_ms += now() - mesh_start;
  }
  r.state_hash = fmt::format("{:016x}", cutter.sweep().stateHash());
  r.add("a fluted mesh of it: time over the bur's", mesh_ms / bur_ms);
  r.add("  removal off by", 100 * std::abs(removedBy(mesh_cutter, phi0) / removedBy(cutter, phi0) - 1), "%");
  return r;
}

}  // namespace kerf::cli
