// The loops after a change of a brick: its point shell, and the nodes at which two states differ.
#pragma once

#include <array>

#include "sim/object/baked_object.h"

namespace kerf::internal {

/// One bit per node of a brick: word i, byte j, bit k of the node (i, j, k).
using NodeBits = std::array<std::uint64_t, kBrickSide>;

/// Fills `out` with the nodes |phi| < half_width of a brick, by offset: areas scale (1 - (phi / half_width)^2)^2 times
/// the differences of the neighbours. Copies of the first node, without area and material, fill up the last chunk. The
/// same bits with any instruction set. @return number of nodes. @cost about 2 ns a node of the shell.
int shellNodes(const BrickNeighborhood& bricks, const std::uint8_t* materials, float half_width, float scale,
               ShellChunk* out) noexcept;

/// The nodes at which a and b, 512 values each, differ.
NodeBits differingNodes(const float* a, const float* b) noexcept;

}  // namespace kerf::internal
