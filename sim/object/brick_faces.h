// The faces of a brick that a change reaches: a neighbour's shell depends on the values there.
#pragma once

#include <cstdint>

#include "sim/object/shell_nodes.h"

namespace kerf {

/// Bits of -x, +x, -y, +y, -z, +z.
inline constexpr std::uint8_t kAllFaces = 63;

/// The faces that hold one of these nodes. @rt
constexpr std::uint8_t facesOf(const internal::NodeBits& nodes) noexcept {
  std::uint64_t any = 0;
  for (const std::uint64_t slab : nodes) any |= slab;

  constexpr std::uint64_t kRow = 0xff, kLow = 0x0101010101010101;
  return static_cast<std::uint8_t>((nodes.front() != 0) | (nodes.back() != 0) << 1 | ((any & kRow) != 0) << 2 |
                                   ((any & kRow << 56) != 0) << 3 | ((any & kLow) != 0) << 4 |
                                   ((any & kLow << 7) != 0) << 5);
}

/// The faces on which two bricks of 512 values differ. @rt
inline std::uint8_t facesThatDiffer(const float* a, const float* b) noexcept {
  return facesOf(internal::differingNodes(a, b));
}

}  // namespace kerf
