// The loops that follow a change of a brick: its point shell, and where two states of it differ.
#pragma once

#include <array>

#include "sim/object/baked_object.h"

namespace kerf::internal {

/// One bit per node of a brick: word i, byte j, bit k of the node (i, j, k).
using NodeBits = std::array<std::uint64_t, kBrickSide>;

/// Fills `out` with the nodes |phi| < half_width of a brick, by offset: areas scale (1 - (phi / half_width)^2)^2 times
/// the differences of the neighbours. The last chunk is filled up with copies of its first node, without area and
/// material. The same bits with any instruction set. @return how many nodes. @cost about 2 ns a node of the shell.
int shellNodes(const BrickNeighborhood& bricks, const std::uint8_t* materials, float half_width, float scale,
               ShellChunk* out) noexcept;

/// The nodes at which a and b, 512 values each, differ.
NodeBits differingNodes(const float* a, const float* b) noexcept;

}  // namespace kerf::internal
