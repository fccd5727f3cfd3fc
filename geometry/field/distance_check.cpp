#include "geometry/field/distance_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kMostStep = 1.5;    // voxels from node to node; exact distances: 1
constexpr double kMostShare = 0.01;  // of pairs, of nodes: a larger share is more than a defect at an edge
constexpr double kMostShareOfCut = 0.2;

tl::unexpected<Error> refuseDistances(const std::string& grid, std::string found, std::string expected) {
  return fail({.code = Error::Code::kBadValue,
               .place = "grid " + grid,
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = "take the case from where it was made, or bake it again"});
}

std::string placeOf(const BrickField& phi, std::size_t b, int node) {
  const Vec3d p = phi.position(8 * phi.brickCoord(b) + Vec3i{node >> 6, node >> 3 & 7, node & 7});
  return fmt::format("({:.2f}, {:.2f}, {:.2f}) mm", p.x(), p.y(), p.z());
}

// How many did not hold, out of how many, and the first of them.
struct Tally {
  std::size_t wrong = 0, all = 0, brick = 0;
  int node = 0;

  void add(bool is_wrong, std::size_t b, int at) {
    ++all;
    if (!is_wrong) return;
    if (wrong++ > 0) return;
    brick = b;
    node = at;
  }
  bool isTooMany(double most_share = kMostShare) const {
    return static_cast<double>(wrong) > most_share * static_cast<double>(all);
  }
  double percent() const { return 100 * static_cast<double>(wrong) / static_cast<double>(all); }
};

// Pairs of neighbours along each axis in a brick, and how many of them are too far apart.
constexpr std::size_t kPairs = 3 * 7 * 64;
std::size_t wrongSteps(const BrickValues& v, float most) {
  const auto isWrong = [&v, most](int n, int axis) {
    return static_cast<int>(
        !(std::abs(v[static_cast<std::size_t>(n + axis)] - v[static_cast<std::size_t>(n)]) <= most));
  };
  int wrong = 0;
  for (int n = 0; n < 7 * 64; ++n) wrong += isWrong(n, 64);
  for (int slab = 0; slab < kBrickNodes; slab += 64)
    for (int n = slab; n < slab + 7 * 8; ++n) wrong += isWrong(n, 8);
  for (int n = 0; n + 1 < kBrickNodes; ++n) wrong += isWrong(n, 1) & static_cast<int>((n & 7) != 7);
  return static_cast<std::size_t>(wrong);
}

void countSteps(const BrickField& phi, std::size_t b, Tally& steps) {
  const auto most = static_cast<float>(kMostStep * phi.voxel());
  const BrickValues& v = phi.brick(b);
  const std::size_t wrong = wrongSteps(v, most);
  if (wrong == 0 || steps.wrong > 0) {
    steps.wrong += wrong;
    steps.all += kPairs;
    return;
  }

  // One by one, to find the first.
  for (int n = 0; n < kBrickNodes; ++n)
    for (const int axis : {64, 8, 1})
      if ((n / axis & 7) < 7)
        steps.add(!(std::abs(v[static_cast<std::size_t>(n + axis)] - v[static_cast<std::size_t>(n)]) <= most), b, n);
}

// Counts nodes at faces without a neighbour: they must lie outside.
void countOutside(const BrickField& phi, std::size_t b, Tally& outside) {
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1}) {
      const Vec3i beside = phi.brickCoord(b) + side * Vec3i::Unit(axis);
      if (phi.find(beside) >= 0 || phi.constantAt(beside) < 0) continue;
      for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
          Vec3i at{i, i, i};
          at[(axis + 1) % 3] = j;
          at[axis] = side < 0 ? 0 : 7;
          const int node = nodeOffset(at[0], at[1], at[2]);
          outside.add(phi.brick(b)[static_cast<std::size_t>(node)] < 0, b, node);
        }
    }
}

// @param most_share  of pairs whose values are too far apart.
Expected<void> requireSteps(const BrickField& phi, const std::string& grid, double most_share) {
  Tally steps;
  for (std::size_t b = 0; b < phi.brickCount(); ++b) countSteps(phi, b, steps);
  if (!steps.isTooMany(most_share)) return {};
  return refuseDistances(
      grid,
      fmt::format("noise: {:.0f} % of neighbouring values differ by more than {:.3g} mm, the first at {}",
                  steps.percent(), kMostStep * phi.voxel(), placeOf(phi, steps.brick, steps.node)),
      fmt::format("distances, which change by {:.3g} mm from voxel to voxel at most", phi.voxel()));
}

}  // namespace

Expected<void> requireDistances(const BrickField& phi) {
  KERF_CHECK(requireSteps(phi, "phi", kMostShare));
  Tally outside;
  for (std::size_t b = 0; b < phi.brickCount(); ++b) countOutside(phi, b, outside);
  if (outside.isTooMany())
    return refuseDistances("phi",
                           fmt::format("a turned sign: {:.0f} % of the outermost values are inside, the first at {}",
                                       outside.percent(), placeOf(phi, outside.brick, outside.node)),
                           "distances that are negative inside");
  return {};
}

Expected<void> requireDistancesInPart(const BrickField& part, const std::string& grid) {
  return requireSteps(part, grid, kMostShare);
}

Expected<void> requireDistancesOfCut(const BrickField& cut, const std::string& grid) {
  return requireSteps(cut, grid, kMostShareOfCut);
}

Expected<void> requireOnlyTaken(const BrickField& cut, const BrickField& before, const BrickField* begin,
                                const std::string& grid) {
  constexpr double kRounding = 0.01;  // voxels
  const double least = kRounding * cut.voxel();
  Tally deeper;
  double deepest = 0;
  for (std::size_t b = 0; b < cut.brickCount(); ++b) {
    const Vec3i at = cut.brickCoord(b);
    const BrickValues* const known = before.valuesAt(at);
    const BrickValues* const filled = begin ? begin->valuesAt(at) : nullptr;
    const float constant = before.constantAt(at);
    for (int node = 0; node < kBrickNodes; ++node) {
      const auto n = static_cast<std::size_t>(node);
      float was = known ? (*known)[n] : constant;
      if (filled) was = std::min(was, (*filled)[n]);
      const double by = static_cast<double>(was) - cut.brick(b)[n];
      deeper.add(by > least, b, node);
      deepest = std::max(deepest, by);
    }
  }
  if (deeper.wrong == 0) return {};
  return refuseDistances(
      grid,
      fmt::format("material where there was none: {} values lie deeper than in the case, by {:.3g} mm at "
                  "most, the first at {}",
                  deeper.wrong, deepest, placeOf(cut, deeper.brick, deeper.node)),
      "a cut, which only takes away");
}

Expected<void> requireSameSides(const BrickField& part, const BrickField& whole, const std::string& grid) {
  Tally sides;
  for (std::size_t b = 0; b < part.brickCount(); ++b)
    for (const int i : {1, 5})
      for (const int j : {1, 5})
        for (const int k : {1, 5}) {
          const double known = whole.sample(part.position(8 * part.brickCoord(b) + Vec3i{i, j, k}));
          const int node = nodeOffset(i, j, k);
          const bool is_inside = part.brick(b)[static_cast<std::size_t>(node)] < 0;
          sides.add(std::abs(known) > whole.voxel() && is_inside != (known < 0), b, node);
        }
  if (!sides.isTooMany()) return {};
  return refuseDistances(
      grid,
      fmt::format("another object: {:.0f} % of its values lie on the other side of the surface than those "
                  "of the whole, the first at {}",
                  sides.percent(), placeOf(part, sides.brick, sides.node)),
      "the same object on smaller voxels");
}

}  // namespace kerf
