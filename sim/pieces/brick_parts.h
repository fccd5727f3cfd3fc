// What one brick has inside: its connected parts, found with bits, 64 nodes at a time.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/field/brick_field.h"
#include "sim/object/shell_nodes.h"
#include "sim/pieces/solid_measure.h"

namespace kerf::internal {

/// Inside nodes of the faces -x, +x, -y, +y, -z, +z of a brick: bit 8 a + b, with a and b the node's places along the
/// two other axes, in order.
using FaceBits = std::array<std::uint64_t, 6>;
inline constexpr std::uint64_t kAllNodes = ~std::uint64_t{0};  ///< of a face, or of a slice of a brick

/// The coordinate of a key: coordKey().
inline Vec3i coordOf(std::uint64_t key) {
  const auto c = coordOfKey(key);
  return {c[0], c[1], c[2]};
}
/// The brick, or block, on a side of one: 0 to 5, in the order of the faces.
inline Vec3i beside(Vec3i brick, std::size_t side) {
  brick[static_cast<int>(side / 2)] += side & 1 ? 1 : -1;
  return brick;
}

/// Inside nodes connected within one brick.
struct BrickPart {
  SolidMeasure measure;
  std::array<std::uint8_t, 3> low{}, high{};  ///< box of its nodes
  std::uint16_t first = 0;                    ///< offset of its first node
  std::uint32_t group = 0;                    ///< of its block: PieceFinder's
};

/// Of a brick that is not all inside or all outside.
struct BrickParts {
  NodeBits inside{};
  NodeBits outermost{};  ///< of them, those next to an outside node
  FaceBits faces{};
  std::vector<BrickPart> parts;
  std::vector<std::uint16_t> label;  ///< part of each node (anything outside) when there are two parts or more

  bool isInside(std::size_t offset) const { return inside[offset >> 6] >> (offset & 63) & 1; }
  /// The part of an inside node.
  std::size_t partAt(std::size_t offset) const { return label.empty() ? 0 : label[offset]; }
};

/// Makes it a brick that is all inside: one part, without outermost nodes.
void makeFull(BrickParts& out);

/// Finds the inside nodes, the faces and the connected parts. Measures and outermost nodes are left to measureFringe();
/// both together take 2 us.
void findParts(const BrickValues& phi, BrickParts& out);

/// The values of a brick, or the constant that stands for it.
struct BrickSource {
  const BrickValues* values;
  float constant;
  double at(int offset) const { return values ? (*values)[static_cast<std::size_t>(offset)] : constant; }
};

/// What measureFringe() reads of a brick and the six beside it, in the order of the faces.
struct FringeInput {
  BrickSource own;
  std::array<BrickSource, 6> beside;
  FaceBits faces_beside;  ///< the face of each that touches this brick
};

/// Finds the outermost nodes, and books the gap between the surface and the cubes around inside nodes on them: the
/// fringe of SolidMeasure. To be done again when a neighbour changes.
void measureFringe(const FringeInput& in, BrickParts& parts);

/// The offset of node n (in the order of a face's bits) of the face on a side of the brick.
constexpr int faceNode(std::size_t side, int n) {
  const int a = n >> 3, b = n & 7, at = side & 1 ? kBrickSide - 1 : 0;
  return side / 2 == 0 ? nodeOffset(at, a, b) : side / 2 == 1 ? nodeOffset(a, at, b) : nodeOffset(a, b, at);
}

}  // namespace kerf::internal
