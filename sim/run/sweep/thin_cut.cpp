#include "sim/run/sweep/thin_cut.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "geometry/boolean/removed_solid.h"

namespace kerf {
namespace {

// The values at the corners of a cell: z fastest.
using Cell = std::array<double, 8>;

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

  Cell at(int i, int j, int k) const {
    Cell out;
    for (int n = 0; n < 8; ++n)
      out[static_cast<std::size_t>(n)] =
          values_[static_cast<std::size_t>(((i + (n >> 2)) * kSide + j + (n >> 1 & 1)) * kSide + k + (n & 1))];
    return out;
  }

 private:
  static constexpr int kSide = kBrickSide + 1;
  std::array<float, kSide * kSide * kSide> values_;
};

// The bit of an axis in the number of a corner.
constexpr std::size_t bitOf(std::size_t axis) { return std::size_t{4} >> axis; }

// The negative stretch of a cell along a line, 0 to 1: one interval, since the field is linear there.
struct Part {
  double begin = 0, end = 0;
  double length() const { return std::max(0.0, end - begin); }
};
Part both(const Part& a, const Part& b) { return {std::max(a.begin, b.begin), std::min(a.end, b.end)}; }

// @param u, v  place on the two other axes, in their order.
Part negativeAlong(const Cell& cell, std::size_t axis, double u, double v) {
  const std::size_t of_u = bitOf(axis == 0 ? 1 : 0), of_v = bitOf(axis == 2 ? 1 : 2), along = bitOf(axis);
  const auto end = [&](std::size_t at) {
    return (1 - u) * ((1 - v) * cell[at] + v * cell[at | of_v]) +
           u * ((1 - v) * cell[at | of_u] + v * cell[at | of_u | of_v]);
  };
  const double low = end(0), high = end(along);
  if (low < 0 && high < 0) return {0, 1};
  if (low >= 0 && high >= 0) return {};
  const double zero = low / (low - high);
  return low < 0 ? Part{0, zero} : Part{zero, 1};
}

// The axis along which the two fields change most: such lines cross a thin layer between them.
std::size_t steepestAxis(const Cell& a, const Cell& b) {
  std::array<double, 3> steepness{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double of_a = 0, of_b = 0;
    for (std::size_t n = 0; n < 8; ++n) {
      of_a += n & bitOf(axis) ? a[n] : -a[n];
      of_b += n & bitOf(axis) ? b[n] : -b[n];
    }
    steepness[axis] = std::abs(of_a) + std::abs(of_b);
  }
  return static_cast<std::size_t>(std::max_element(steepness.begin(), steepness.end()) - steepness.begin());
}

// The part of a cell in which both fields are negative.
double partInside(const Cell& a, const Cell& b) {
  const auto inside = [](const Cell& cell) {
    return std::count_if(cell.begin(), cell.end(), [](double value) { return value < 0; });
  };
  const auto in_a = inside(a), in_b = inside(b);
  if (in_a == 0 || in_b == 0) return 0;
  if (in_a == 8 && in_b == 8) return 1;

  constexpr int kLines = 16;
  const auto place = [](int n) { return (n + 0.5) / kLines; };
  const std::size_t axis = steepestAxis(a, b);
  double sum = 0;
  for (int i = 0; i < kLines; ++i)
    for (int j = 0; j < kLines; ++j) {
      const auto along = [&](const Cell& cell) { return negativeAlong(cell, axis, place(i), place(j)); };
      sum += both(along(a), along(b)).length();
    }
  return sum / (kLines * kLines);
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

// The bricks of a field in, or beside, a brick of another one.
BrickField nearBricksOf(const BrickField& field, const BrickField& other) {
  BrickField out(field.voxel(), field.background());
  for (std::size_t b = 0; b < field.brickCount(); ++b) {
    bool is_near = false;
    for (int n = 0; n < 27 && !is_near; ++n)
      is_near = other.find(field.brickCoord(b) + Vec3i{n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1}) >= 0;
    if (is_near) out.add(field.brickCoord(b), field.brick(b));
  }
  return out;
}

BrickField unionOf(const BrickField& a, const BrickField& b) {
  BrickField out = a;
  for (std::size_t n = 0; n < b.brickCount(); ++n) {
    const int at = out.find(b.brickCoord(n));
    if (at < 0) {
      out.add(b.brickCoord(n), b.brick(n));
      continue;
    }
    BrickValues& values = out.brick(static_cast<std::size_t>(at));
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = std::min(values[k], b.brick(n)[k]);
  }
  return out;
}

}  // namespace

double sweptVolume(const BrickField& phi0, const BrickField& psi) {
  std::vector<double> cells(psi.brickCount());
  tbb::parallel_for(std::size_t{0}, cells.size(),
                    [&](std::size_t b) { cells[b] = partInBrick(phi0, psi, psi.brickCoord(b)); });
  return std::accumulate(cells.begin(), cells.end(), 0.0) * std::pow(psi.voxel(), 3);
}

double strokeVolume(const BrickField& phi0, const BrickField& before, const BrickField& stroke) {
  const BrickField near = nearBricksOf(before, stroke);
  const auto removed = [&](const BrickField& sweep) { return sweptVolume(phi0, removedFieldFromSweep(phi0, sweep)); };
  return removed(unionOf(near, stroke)) - removed(near);
}

double thinCutVolume(const BrickField& phi0, const BrickField& sweep) {
  const BrickField rho = removedFieldFromSweep(phi0, sweep);
  return meshRemovedSolid(rho).mesh.triangles.empty() ? 0 : sweptVolume(phi0, rho);
}

}  // namespace kerf
