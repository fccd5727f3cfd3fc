#include "geometry/boolean/removed_solid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "geometry/field/marching_cubes.h"

namespace kerf {
namespace {

// A field with the bricks of `shape`, each node computed from the two fields' values there.
template <class F>
BrickField combineFields(const BrickField& phi0, const BrickField& shape, float background, F value) {
  BrickField out(phi0.voxel(), background);
  out.reserve(shape.brickCount());
  for (std::size_t b = 0; b < shape.brickCount(); ++b) out.touch(shape.brickCoord(b));

  tbb::parallel_for(std::size_t{0}, shape.brickCount(), [&](std::size_t b) {
    const int found = phi0.find(shape.brickCoord(b));
    const float constant = phi0.constantAt(shape.brickCoord(b));
    const BrickValues& s = shape.brick(b);
    BrickValues& o = out.brick(b);
    for (std::size_t n = 0; n < kBrickNodes; ++n)
      o[n] = std::clamp(value(found < 0 ? constant : phi0.brick(static_cast<std::size_t>(found))[n], s[n]), -background,
                        background);
  });
  return out;
}

}  // namespace

BrickField removedFieldFromSweep(const BrickField& phi0, const BrickField& sweep) {
  const auto h = static_cast<float>(phi0.voxel());
  return combineFields(phi0, sweep, 4 * h, [h](float p0, float psi) { return std::max(psi, p0 - 2 * h); });
}

BrickField removedFieldFromCut(const BrickField& phi0, const BrickField& phi) {
  const auto h = static_cast<float>(phi0.voxel()), eps = 0.1f * h;
  return combineFields(phi0, phi, 4 * h, [h, eps](float p0, float p) {
    return std::max({-p, p0 + eps - p, p0 - 2 * h});
  });
}

BrickField addedFieldFromFill(const BrickField& phi0, const BrickField& phi) {
  const auto h = static_cast<float>(phi0.voxel()), eps = 0.1f * h;
  return combineFields(phi0, phi, 4 * h, [h, eps](float p0, float p) {
    return std::max({p, p - p0 + eps, -p0 - 2 * h});
  });
}

void clearAwayFromInside(BrickField& rho) {
  std::vector<char> has_inside(rho.brickCount());
  for (std::size_t b = 0; b < rho.brickCount(); ++b)
    has_inside[b] = std::any_of(rho.brick(b).begin(), rho.brick(b).end(), [](float v) { return v < 0; });
  for (std::size_t b = 0; b < rho.brickCount(); ++b) {
    bool is_near = false;
    for (int n = 0; n < 27 && !is_near; ++n) {
      const int near = rho.find(rho.brickCoord(b) + Vec3i{n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1});
      is_near = near >= 0 && has_inside[static_cast<std::size_t>(near)];
    }
    if (!is_near) rho.brick(b).fill(rho.background());
  }
}

RemovedSolid meshRemovedSolid(const BrickField& rho) {
  RemovedSolid out;
  const Mesh all = marchingCubes(rho);
  const Pieces pieces = edgeConnectedPieces(all);
  std::vector<double> volume(pieces.count, 0);
  if (!all.vertices.empty()) {
    const Vec3d c = bounds(all).center();
    for (std::size_t t = 0; t < all.triangles.size(); ++t)
      volume[pieces.label[t]] += (all.corner(t, 0) - c).dot((all.corner(t, 1) - c).cross(all.corner(t, 2) - c)) / 6;
  }

  const double crumb = std::pow(rho.voxel(), 3);
  std::vector<char> keep(all.triangles.size(), 1);
  for (std::uint32_t p = 0; p < pieces.count; ++p)
    if (std::abs(volume[p]) < crumb) {
      ++out.parts_dropped;
      out.dropped_volume_mm3 += std::abs(volume[p]);
    }

  for (std::size_t t = 0; t < keep.size(); ++t) keep[t] = std::abs(volume[pieces.label[t]]) >= crumb;
  out.mesh = out.parts_dropped ? subset(all, keep) : all;
  return out;
}

}  // namespace kerf
