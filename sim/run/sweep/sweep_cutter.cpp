#include "sim/run/sweep/sweep_cutter.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace kerf {

MergedPath mergedFor(const ToolShape& cut, const CutPath& path, double voxel_mm) {
  constexpr double kShortMotion = 0.5;  // voxels
  double reach = 0;
  const Box3 box = cut.bounds();
  for (int n = 0; n < 8; ++n) reach = std::max(reach, box.corner(n).norm());
  return mergeShortMotions(path, {kShortMotion * voxel_mm, kMergeTolerance * voxel_mm, reach});
}

SweepCutter::SweepCutter(const BrickField& phi0, const SweepCutterOptions& options)
    : phi0_(phi0),
      options_(options),
      psi_(phi0.voxel(), static_cast<float>(options.band_voxels * phi0.voxel())),
      object_(phi0.bounds()) {
  if (object_.isEmpty()) return;
  for (const Vec3i& brick : phi0.interiorBricks()) {  // a fine region may have some beyond the surface bricks
    object_.add(phi0.position(brick * kBrickSide));
    object_.add(phi0.position(brick * kBrickSide + Vec3i::Constant(kBrickSide - 1)));
  }
}

bool SweepCutter::advance(const SweptTool& sweep, const GoesOn& goes_on) {
  const double h = phi0_.voxel(), band = psi_.background(), tolerance = options_.tolerance_voxels * h;
  Box3 box = sweep.bounds();
  box.grow(band);
  // Nothing can be cut beyond the surface bricks: a far or very long motion costs no more than one through the object.
  // A field without bricks is tissue everywhere.
  if (!object_.isEmpty()) {
    box.min = box.min.cwiseMax(object_.min);
    box.max = box.max.cwiseMin(object_.max);
  }
  if (box.isEmpty()) return false;

  // Finds the bricks with tissue that the tool may reach (tested in parallel: a long motion's box holds many).
  const Vec3i low = brickOf((box.min / h).array().floor().cast<int>().matrix());
  const Vec3i high = brickOf((box.max / h).array().ceil().cast<int>().matrix());
  const double brick_radius = 0.5 * std::sqrt(3.0) * (kBrickSide - 1) * h;
  std::vector<Vec3i> tissue;
  for (int x = low[0]; x <= high[0]; ++x)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int z = low[2]; z <= high[2]; ++z)
        if (const Vec3i c{x, y, z}; phi0_.find(c) >= 0 || phi0_.constantAt(c) < 0) tissue.push_back(c);
  std::vector<char> reached(tissue.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, tissue.size(), 64), [&](const auto& range) {
    for (std::size_t n = range.begin(); n != range.end(); ++n) {
      const Vec3d center = psi_.position(tissue[n] * kBrickSide) + Vec3d::Constant(0.5 * (kBrickSide - 1) * h);
      reached[n] = sweep.mayReach(center, brick_radius, band);
    }
  });
  std::vector<std::size_t> near;
  for (std::size_t n = 0; n < tissue.size(); ++n)
    if (reached[n]) near.push_back(psi_.touch(tissue[n]));

  const double least = 0.1 * h;
  std::vector<char> is_cut(near.size());
  const auto cutBrick = [&](std::size_t n) {
    const std::size_t b = near[n];
    const BrickValues* const loaded = phi0_.valuesAt(psi_.brickCoord(b));
    const float constant = phi0_.constantAt(psi_.brickCoord(b));
    const Vec3i base = psi_.brickCoord(b) * kBrickSide;
    BrickValues& v = psi_.brick(b);
    std::size_t at = 0;
    for (int i = 0; i < kBrickSide; ++i)
      for (int j = 0; j < kBrickSide; ++j)
        for (int k = 0; k < kBrickSide; ++k, ++at) {
          const double now = v[at];
          if (now <= -band) continue;
          const double d = sweep.distance(psi_.position(base + Vec3i{i, j, k}), now, tolerance, -band);
          if (!(d < now)) continue;
          v[at] = static_cast<float>(std::max(d, -band));
          const double before = std::max<double>(loaded ? (*loaded)[at] : constant, -now);
          if (before < 0 && -d > before + least) is_cut[n] = 1;
        }
  };

  constexpr std::size_t kAtOnce = 16;  // bricks; a second or two for a mesh of 1.5 M triangles
  const std::size_t stride = goes_on ? kAtOnce : std::max<std::size_t>(1, near.size());
  for (std::size_t begin = 0; begin < near.size(); begin += stride) {
    if (goes_on && !goes_on(static_cast<double>(begin) / static_cast<double>(near.size()))) return false;
    tbb::parallel_for(begin, std::min(begin + stride, near.size()), cutBrick);
  }
  return std::any_of(is_cut.begin(), is_cut.end(), [](char is) { return is != 0; });
}

BrickField SweepCutter::cutField() const {
  BrickField out(phi0_.voxel(), phi0_.background(), phi0_.interior());
  BrickValues cut;
  for (std::size_t b = 0; b < psi_.brickCount(); ++b) {
    const int found = phi0_.find(psi_.brickCoord(b));
    const float constant = phi0_.constantAt(psi_.brickCoord(b));
    bool differs = false;
    for (std::size_t n = 0; n < kBrickNodes; ++n) {
      const float before = found < 0 ? constant : phi0_.brick(static_cast<std::size_t>(found))[n];
      cut[n] = std::max(before, -psi_.brick(b)[n]);
      differs |= cut[n] != before;
    }
    if (differs) out.add(psi_.brickCoord(b), cut);
  }
  return out;
}

}  // namespace kerf
