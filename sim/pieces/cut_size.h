// Upper estimate of the bricks that a cut through an object changes: memory for them is reserved before.
#pragma once

#include <cmath>
#include <cstddef>

namespace kerf::internal {

/// A plane across a cube of so many bricks: 2800 for a mandible of 148 000, whose kerf changed 700 to 1400.
inline std::size_t bricksOfACut(std::size_t bricks) {
  const double side = std::cbrt(static_cast<double>(bricks));
  return static_cast<std::size_t>(side * side);
}

}  // namespace kerf::internal
