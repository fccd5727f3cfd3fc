#include "geometry/field/brick_field.h"

#include <algorithm>
#include <cmath>

#include "geometry/field/brick_hash.h"

namespace kerf {

std::size_t BrickField::touch(const Vec3i& brick_coord) {
  if (const std::int32_t known = index_.find(brick_coord); known >= 0) return static_cast<std::size_t>(known);
  const float constant = constantAt(brick_coord);
  values_.emplace_back().fill(constant);
  coords_.push_back(brick_coord);
  index_.add(brick_coord, static_cast<std::int32_t>(coords_.size() - 1));
  return coords_.size() - 1;
}

std::size_t BrickField::add(const Vec3i& brick_coord, std::span<const float, kBrickNodes> values) {
  index_.add(brick_coord, static_cast<std::int32_t>(coords_.size()));
  coords_.push_back(brick_coord);
  BrickValues& fresh = values_.emplace_back();
  std::copy(values.begin(), values.end(), fresh.begin());
  return coords_.size() - 1;
}

double BrickField::sample(const Vec3d& p) const {
  const Vec3d g = p / voxel_;
  const Vec3i n = g.array().floor().cast<int>();
  const Vec3d f = g - n.cast<double>();
  double sum = 0;
  for (int c = 0; c < 8; ++c) {
    const Vec3i d{c >> 2, (c >> 1) & 1, c & 1};
    const double w = (d[0] ? f[0] : 1 - f[0]) * (d[1] ? f[1] : 1 - f[1]) * (d[2] ? f[2] : 1 - f[2]);
    if (w != 0) sum += w * static_cast<double>(at(n + d));
  }
  return sum;
}

Box3 BrickField::bounds() const {
  Box3 box;
  for (const Vec3i& c : coords_) {
    box.add(position(c * kBrickSide));
    box.add(position((c * kBrickSide).array() + (kBrickSide - 1)));
  }
  return box;
}

std::uint64_t BrickField::stateHash() const {
  std::uint64_t sum = hashOfNoBricks(voxel_);
  for (std::size_t b = 0; b < coords_.size(); ++b)
    sum += brickHashes<1>({coordKey(coords_[b])}, {values_[b].data()})[0];  // a sum does not care about the order
  return sum;
}

}  // namespace kerf
