#include "bench/scenes/carved_field.h"

#include <algorithm>

#include "geometry/field/sample_field.h"

namespace kerf::scenes {
namespace {

// Values of a stored or unstored brick before a cut.
BrickEdit editOf(const OverlayField& field, const Vec3i& brick) {
  BrickEdit edit;
  edit.brick = brick;
  if (const BrickValues* now = field.valuesAt(brick))
    edit.phi = *now;
  else
    edit.phi.fill(field.constantAt(brick));
  return edit;
}

}  // namespace

BrickField ballWithAHole(double r, double h) {
  Box3 box;
  box.add(Vec3d::Zero());
  box.grow(r);
  return sampleDistance(
      [r](const Vec3d& p) { return std::max(p.norm() - r, 0.3 * r - Vec3d(p[0] - 0.21 * r, p[1], 0).norm()); }, box, h);
}

std::vector<BrickEdit> carve(OverlayField& field, const Vec3d& center, double radius, bool add) {
  const double h = field.voxel(), reach = radius + field.background();
  const Vec3i low = brickOf(((center.array() - reach) / h).floor().cast<int>().matrix());
  const Vec3i high = brickOf(((center.array() + reach) / h).ceil().cast<int>().matrix());

  std::vector<BrickEdit> edits;
  for (int x = low[0]; x <= high[0]; ++x)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int z = low[2]; z <= high[2]; ++z) {
        BrickEdit edit = editOf(field, {x, y, z});
        bool changed = false;
        std::size_t at = 0;
        for (int i = 0; i < kBrickSide; ++i)
          for (int j = 0; j < kBrickSide; ++j)
            for (int k = 0; k < kBrickSide; ++k, ++at) {
              const Vec3d p = h * (edit.brick * kBrickSide + Vec3i{i, j, k}).cast<double>();
              const auto tau = static_cast<float>((p - center).norm() - radius);
              const float limit = field.background();
              const float v = add ? std::min(edit.phi[at], std::max(tau, field.interior()))
                                  : std::max(edit.phi[at], std::min(-tau, limit));
              changed |= v != edit.phi[at];
              edit.phi[at] = v;
            }
        if (changed) {
          edits.push_back(edit);
          field.set(edit);
        }
      }
  return edits;
}

std::vector<BrickEdit> carveAtRandom(OverlayField& field, double r, std::mt19937& random) {
  std::normal_distribution<double> n;
  std::uniform_real_distribution<double> u(0, 1);
  const Vec3d direction = Vec3d(n(random), n(random), n(random)).normalized();
  const double depth = u(random) < 0.8 ? r * (0.9 + 0.15 * u(random)) : r * 0.9 * u(random);
  const double radius = field.voxel() * (0.7 + 3.3 * u(random));
  return carve(field, depth * direction, radius, u(random) < 0.3);
}

}  // namespace kerf::scenes
