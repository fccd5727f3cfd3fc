#include "sim/run/removed_volumes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/object/baked_object.h"

namespace kerf::internal {

double commonVolume(const BrickField& phi0, const BrickField& one, const BrickField& other) {
  const double half_width = kShellHalfWidth * phi0.voxel(), cell = std::pow(phi0.voxel(), 3);
  double sum = 0;
  for (std::size_t b = 0; b < one.brickCount(); ++b) {
    const Vec3i& brick = one.brickCoord(b);
    const int in_other = other.find(brick), found = phi0.find(brick);
    if (in_other < 0) continue;
    const float constant = phi0.constantAt(brick);
    for (std::size_t n = 0; n < kBrickNodes; ++n) {
      const float before = found < 0 ? constant : phi0.brick(static_cast<std::size_t>(found))[n];
      // What is left of the node in the one that takes less.
      const float after = std::min(one.brick(b)[n], other.brick(static_cast<std::size_t>(in_other))[n]);
      if (after > before) sum += cell * (insidePart(before, half_width) - insidePart(after, half_width));
    }
  }
  return sum;
}

VolumeByNumber removedVolumes(const BrickField& phi0, const BrickField& cut, const MaterialsOf& materials) {
  const double half_width = kShellHalfWidth * phi0.voxel(), cell = std::pow(phi0.voxel(), 3);
  VolumeByNumber out{};
  std::array<std::uint8_t, kBrickNodes> numbers;
  for (std::size_t b = 0; b < cut.brickCount(); ++b) {
    const Vec3i& brick = cut.brickCoord(b);
    const int found = phi0.find(brick);
    const float constant = phi0.constantAt(brick);
    materials(brick, numbers);
    for (std::size_t n = 0; n < kBrickNodes; ++n) {
      const float before = found < 0 ? constant : phi0.brick(static_cast<std::size_t>(found))[n];
      const float after = cut.brick(b)[n];
      if (before == after) continue;
      out[numbers[n]] += cell * (insidePart(before, half_width) - insidePart(after, half_width));
    }
  }
  return out;
}

MaterialsOf materialsOf(const MaterialField& materials, Material fallback) {
  return [&materials, fallback](const Vec3i& brick, std::span<std::uint8_t, kBrickNodes> out) {
    materials.copyBrick(brick, out);
    std::replace(out.begin(), out.end(), std::uint8_t{0}, static_cast<std::uint8_t>(fallback));
  };
}

MaterialsOf materialsOf(const BakedObject& object) {
  return [&object](const Vec3i& brick, std::span<std::uint8_t, kBrickNodes> out) {
    const std::int32_t s = object.directory().find(brick);
    const std::uint8_t* const from =
        s < 0 ? object.fallbackMaterials() : object.slots()[static_cast<std::size_t>(s)].materials;
    std::copy_n(from, kBrickNodes, out.begin());
  };
}

}  // namespace kerf::internal
