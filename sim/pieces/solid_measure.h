// Inside volume, in whole numbers.
#pragma once

#include <cstdint>

namespace kerf {

/// Volume of inside nodes, in whole numbers: sums over pieces do not depend on their order, and the ledger balances to
/// the last bit.
///
/// The cubes of h^3 around the inside nodes are a staircase that follows the surface. Between both lies a gap of either
/// sign. Seen along an axis it is (t - 1/2) h deep at every edge that leaves the solid, t the place of the surface on
/// the edge by linear interpolation. Each axis sees the whole gap as far as the surface faces it, so the edges of one
/// inside node are weighted by the squares of the normal's components there (central differences): exact for planes
/// along the axes, second order for others. The gap is booked on inside nodes, and computed from them and their six
/// neighbours alone. So every bit of volume belongs to exactly one piece, independently of the other pieces.
struct SolidMeasure {
  std::uint64_t nodes = 0;  ///< inside nodes
  std::int64_t fringe = 0;  ///< sum of weight * (t - 1/2) over all crossed edges, in units of 2^-32, each rounded once

  void add(const SolidMeasure& o) {
    nodes += o.nodes;
    fringe += o.fringe;
  }
  bool operator==(const SolidMeasure&) const = default;
  /// mm^3. @param voxel mm. For a ball with a radius of n voxels the result is too small by 0.5 / n^2 at most.
  double volume(double voxel) const {
    return voxel * voxel * voxel * (static_cast<double>(nodes) + static_cast<double>(fringe) * 0x1p-32);
  }
};

}  // namespace kerf
