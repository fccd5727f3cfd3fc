// The inside of one brick: its connected parts, found with bits, 64 nodes at a time.
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
/// The neighbouring brick, or block, on a side: 0 to 5, in the order of the faces.
inline Vec3i beside(Vec3i brick, std::size_t side) {
  brick[static_cast<int>(side / 2)] += side & 1 ? 1 : -1;
  return brick;
}

/// Inside nodes connected within one brick.
struct BrickPart {
  SolidMeasure measure;
  std::array<std::uint8_t, 3> low{}, high{};  ///< box of its nodes
  std::uint16_t first = 0;                    ///< offset of its first node
  std::uint32_t group = 0;                    ///< in its block: PieceFinder's
};

/// Parts of a brick that is neither all inside nor all outside.
struct BrickParts {
  NodeBits inside{};
  NodeBits outermost{};  ///< inside nodes next to an outside node
  FaceBits faces{};
  std::vector<BrickPart> parts;
  std::vector<std::uint16_t> label;  ///< part of each inside node, for two parts or more; outside nodes hold any value

  bool isInside(std::size_t offset) const { return inside[offset >> 6] >> (offset & 63) & 1; }
  /// The part of an inside node.
  std::size_t partAt(std::size_t offset) const { return label.empty() ? 0 : label[offset]; }
};

/// Describes a brick that is all inside: one part, without outermost nodes.
void makeFull(BrickParts& out);

/// Finds the inside nodes, the faces and the connected parts. measureFringe() adds measures and outermost nodes; both
/// together take 2 us.
void findParts(const BrickValues& phi, BrickParts& out);

/// The values of a brick, or its constant.
struct BrickSource {
  const BrickValues* values;
  float constant;
  double at(int offset) const { return values ? (*values)[static_cast<std::size_t>(offset)] : constant; }
};

/// Input of measureFringe(): a brick and its six neighbours, in the order of the faces.
struct FringeInput {
  BrickSource own;
  std::array<BrickSource, 6> beside;
  FaceBits faces_beside;  ///< each neighbour's face that touches this brick
};

/// Finds the outermost nodes, and books the gap between the surface and the cubes around inside nodes on them: the
/// fringe of SolidMeasure. Repeat after a change of a neighbour.
void measureFringe(const FringeInput& in, BrickParts& parts);

/// The offset of node n (in the order of a face's bits) of the face on a side of the brick.
constexpr int faceNode(std::size_t side, int n) {
  const int a = n >> 3, b = n & 7, at = side & 1 ? kBrickSide - 1 : 0;
  return side / 2 == 0 ? nodeOffset(at, a, b) : side / 2 == 1 ? nodeOffset(a, at, b) : nodeOffset(a, b, at);
}

}  // namespace kerf::internal
