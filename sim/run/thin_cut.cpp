#include "sim/run/thin_cut.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "geometry/boolean/removed_solid.h"

namespace kerf {
namespace {

// The nodes of a brick and the first ones beyond it: all corners of the cells whose lowest corner is in the brick.
class CellCorners {
 public:
  CellCorners(const BrickField& field, const Vec3i& brick) {
    std::array<const BrickValues*, 8> bricks;
    std::array<float, 8> constants;
    for (int n = 0; n < 8; ++n) {
      const Vec3i other = brick + Vec3i{n >> 2, n >> 1 & 1, n & 1};
      bricks[static_cast<std::size_t>(n)] = field.valuesAt(other);
      constants[static_cast<std::size_t>(n)] = field.constantAt(other);
    }
    std::size_t at = 0;
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j)
        for (int k = 0; k < kSide; ++k, ++at) {
          const auto n = static_cast<std::size_t>((i >> 3) << 2 | (j >> 3) << 1 | k >> 3);
          values_[at] = bricks[n] ? (*bricks[n])[static_cast<std::size_t>(nodeOffset(i, j, k))] : constants[n];
        }
  }

  bool hasInside() const {
    return std::any_of(values_.begin(), values_.end(), [](float value) { return value < 0; });
  }

  // Of the cell: z fastest.
  std::array<double, 8> at(int i, int j, int k) const {
    std::array<double, 8> out;
    for (int n = 0; n < 8; ++n)
      out[static_cast<std::size_t>(n)] =
          values_[static_cast<std::size_t>(((i + (n >> 2)) * kSide + j + (n >> 1 & 1)) * kSide + k + (n & 1))];
    return out;
  }

 private:
  static constexpr int kSide = kBrickSide + 1;
  std::array<float, kSide * kSide * kSide> values_;
};

struct Ends {
  double low, high;
};
// Of the line along z at (x, y) of a cell, 0 to 1.
Ends lineAlongZ(const std::array<double, 8>& cell, double x, double y) {
  const auto end = [&](std::size_t z) {
    return (1 - x) * ((1 - y) * cell[z] + y * cell[2 + z]) + x * ((1 - y) * cell[4 + z] + y * cell[6 + z]);
  };
  return {end(0), end(1)};
}

// The part of a cell where both fields are negative.
double partInside(const std::array<double, 8>& a, const std::array<double, 8>& b) {
  const auto inside = [](const std::array<double, 8>& cell) {
    return std::count_if(cell.begin(), cell.end(), [](double value) { return value < 0; });
  };
  const auto in_a = inside(a), in_b = inside(b);
  if (in_a == 0 || in_b == 0) return 0;
  if (in_a == 8 && in_b == 8) return 1;

  constexpr int kSamples = 16;
  const auto place = [](int n) { return (n + 0.5) / kSamples; };
  int count = 0;
  for (int i = 0; i < kSamples; ++i)
    for (int j = 0; j < kSamples; ++j) {
      const Ends of_a = lineAlongZ(a, place(i), place(j)), of_b = lineAlongZ(b, place(i), place(j));
      for (int k = 0; k < kSamples; ++k) {
        const double z = place(k);
        count += (1 - z) * of_a.low + z * of_a.high < 0 && (1 - z) * of_b.low + z * of_b.high < 0;
      }
    }
  return count / std::pow(kSamples, 3);
}

// In cells.
double partInBrick(const BrickField& phi0, const BrickField& psi, const Vec3i& brick) {
  const CellCorners swept(psi, brick);
  if (!swept.hasInside()) return 0;
  const CellCorners loaded(phi0, brick);
  if (!loaded.hasInside()) return 0;
  double sum = 0;
  for (int i = 0; i < kBrickSide; ++i)
    for (int j = 0; j < kBrickSide; ++j)
      for (int k = 0; k < kBrickSide; ++k) sum += partInside(swept.at(i, j, k), loaded.at(i, j, k));
  return sum;
}

}  // namespace

double sweptVolume(const BrickField& phi0, const BrickField& psi) {
  std::vector<double> cells(psi.brickCount());
  tbb::parallel_for(std::size_t{0}, cells.size(),
                    [&](std::size_t b) { cells[b] = partInBrick(phi0, psi, psi.brickCoord(b)); });
  return std::accumulate(cells.begin(), cells.end(), 0.0) * std::pow(psi.voxel(), 3);
}

double thinCutVolume(const BrickField& phi0, const BrickField& sweep) {
  const BrickField rho = removedFieldFromSweep(phi0, sweep);
  return meshRemovedSolid(rho).mesh.triangles.empty() ? 0 : sweptVolume(phi0, rho);
}

}  // namespace kerf
