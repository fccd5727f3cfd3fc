#include "sim/pieces/brick_parts.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace kerf::internal {
namespace {

// A brick is eight words, one for each x: bit 8 y + z of word x is node (x, y, z).
constexpr std::uint64_t kZ0 = 0x0101010101010101;  // nodes of a word with z = 0
constexpr std::uint64_t kY0 = 0xff;                // with y = 0

// The eight bits of a word with z = 0, in one byte.
constexpr std::uint64_t columnOfZ0(std::uint64_t word) { return ((word & kZ0) * 0x0102040810204080) >> 56; }

// And back: bit y of a byte to bit 8 y.
constexpr std::uint64_t spread(std::uint64_t byte) {
  std::uint64_t word = 0;
  for (int y = 0; y < 8; ++y) word |= (byte >> y & 1) << 8 * y;
  return word;
}

// The nodes of a word after a step along y or z, without those that leave the brick.
constexpr std::uint64_t upY(std::uint64_t word) { return word << 8; }
constexpr std::uint64_t downY(std::uint64_t word) { return word >> 8; }
constexpr std::uint64_t upZ(std::uint64_t word) { return (word << 1) & ~kZ0; }
constexpr std::uint64_t downZ(std::uint64_t word) { return (word >> 1) & ~(kZ0 << 7); }

template <class Visit>
void forEachBit(std::uint64_t word, const Visit& visit) {
  for (; word; word &= word - 1) visit(static_cast<std::size_t>(std::countr_zero(word)));
}

NodeBits insideOf(const BrickValues& phi) {
  NodeBits out;
  for (std::size_t x = 0; x < 8; ++x) {
    std::uint64_t word = 0;
    for (std::size_t n = 0; n < 64; ++n) word |= std::uint64_t{phi[64 * x + n] < 0} << n;
    out[x] = word;
  }
  return out;
}

FaceBits facesOf(const NodeBits& bits) {
  FaceBits f{bits[0], bits[7], 0, 0, 0, 0};
  for (std::size_t x = 0; x < 8; ++x) {
    f[2] |= (bits[x] & kY0) << 8 * x;
    f[3] |= (bits[x] >> 56) << 8 * x;
    f[4] |= columnOfZ0(bits[x]) << 8 * x;
    f[5] |= columnOfZ0(bits[x] >> 7) << 8 * x;
  }
  return f;
}

// The nodes connected to the first one of a nonempty word. Grows word by word until nothing is added.
NodeBits connectedToFirst(const NodeBits& nodes, std::size_t word) {
  NodeBits grown{};
  grown[word] = nodes[word] & (~nodes[word] + 1);
  for (bool is_growing = true; is_growing;) {
    is_growing = false;
    for (std::size_t x = 0; x < 8; ++x) {
      const std::uint64_t here = grown[x];
      const std::uint64_t beside_x = (x > 0 ? grown[x - 1] : 0) | (x < 7 ? grown[x + 1] : 0);
      const std::uint64_t next = (here | upZ(here) | downZ(here) | upY(here) | downY(here) | beside_x) & nodes[x];
      if (next != here) {
        grown[x] = next;
        is_growing = true;
      }
    }
  }
  return grown;
}

// Count, box and first node of a part. @param word  the first nonempty one.
BrickPart describe(const NodeBits& nodes, std::size_t word) {
  BrickPart part;
  part.first = static_cast<std::uint16_t>(64 * word + static_cast<std::size_t>(std::countr_zero(nodes[word])));
  part.low[0] = static_cast<std::uint8_t>(word);

  std::uint64_t any = 0;  // seen along x
  for (std::size_t x = 0; x < 8; ++x) {
    if (!nodes[x]) continue;
    part.high[0] = static_cast<std::uint8_t>(x);
    part.measure.nodes += static_cast<std::uint64_t>(std::popcount(nodes[x]));
    any |= nodes[x];
  }
  part.low[1] = static_cast<std::uint8_t>(std::countr_zero(any) / 8);
  part.high[1] = static_cast<std::uint8_t>((63 - std::countl_zero(any)) / 8);

  std::uint64_t column = 0;  // and seen along y
  for (int y = 0; y < 8; ++y) column |= any >> 8 * y & 0xff;
  part.low[2] = static_cast<std::uint8_t>(std::countr_zero(column));
  part.high[2] = static_cast<std::uint8_t>(63 - std::countl_zero(column));
  return part;
}

}  // namespace

void makeFull(BrickParts& out) {
  out.inside.fill(kAllNodes);
  out.faces.fill(kAllNodes);
  out.parts.push_back({{kBrickNodes, 0}, {0, 0, 0}, {7, 7, 7}, 0});
}

void findParts(const BrickValues& phi, BrickParts& out) {
  out.inside = insideOf(phi);
  out.faces = facesOf(out.inside);
  out.parts.clear();
  out.label.clear();

  NodeBits left = out.inside;  // of no part yet
  for (std::size_t word = 0; word < 8; ++word)
    while (left[word]) {
      const NodeBits part = connectedToFirst(left, word);
      for (std::size_t x = 0; x < 8; ++x) left[x] &= ~part[x];

      const bool is_last = std::all_of(left.begin(), left.end(), [](std::uint64_t w) { return w == 0; });
      if (!is_last || !out.parts.empty()) {
        out.label.resize(kBrickNodes);
        for (std::size_t x = 0; x < 8; ++x)
          forEachBit(part[x],
                     [&](std::size_t n) { out.label[64 * x + n] = static_cast<std::uint16_t>(out.parts.size()); });
      }
      out.parts.push_back(describe(part, word));
    }
}

namespace {

// The sum of weight * (t - 1/2) over the crossed edges of one inside node, in units of 2^-32.
std::int64_t fringeOf(const FringeInput& in, std::size_t offset) {
  const int n = static_cast<int>(offset);
  constexpr std::array<int, 6> kStride{-64, 64, -8, 8, -1, 1};      // to the next node
  constexpr std::array<int, 6> kAcross{448, -448, 56, -56, 7, -7};  // to the node of the next brick
  const std::array<int, 3> place{n >> 6, n >> 3 & 7, n & 7};
  const double here = in.own.at(n);

  std::array<double, 6> around;
  for (std::size_t side = 0; side < 6; ++side) {
    const bool is_beyond = place[side / 2] == (side & 1 ? kBrickSide - 1 : 0);
    around[side] = is_beyond ? in.beside[side].at(n + kAcross[side]) : in.own.at(n + kStride[side]);
  }

  std::array<double, 3> weight;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double slope = around[2 * axis + 1] - around[2 * axis];
    weight[axis] = slope * slope;
  }
  const double sum = weight[0] + weight[1] + weight[2];

  std::int64_t fringe = 0;
  for (std::size_t side = 0; side < 6; ++side) {
    if (around[side] < 0) continue;
    const double t = here / (here - around[side]), w = sum > 0 ? weight[side / 2] / sum : 1.0 / 3;
    fringe += std::llround(w * (t - 0.5) * 0x1p32);
  }
  return fringe;
}

}  // namespace

void measureFringe(const FringeInput& in, BrickParts& parts) {
  for (BrickPart& part : parts.parts) part.measure.fringe = 0;
  parts.outermost = {};
  if (parts.parts.empty()) return;

  for (std::size_t x = 0; x < 8; ++x) {
    const std::uint64_t here = parts.inside[x];
    // The rows of the neighbours' faces that lie beside this word.
    const auto rowOf = [&](std::size_t side) { return in.faces_beside[side] >> 8 * x & 0xff; };
    const std::uint64_t below_x = x > 0 ? parts.inside[x - 1] : in.faces_beside[0];
    const std::uint64_t above_x = x < 7 ? parts.inside[x + 1] : in.faces_beside[1];
    const std::uint64_t below_y = upY(here) | rowOf(2), above_y = downY(here) | rowOf(3) << 56;
    const std::uint64_t below_z = upZ(here) | spread(rowOf(4)), above_z = downZ(here) | spread(rowOf(5)) << 7;

    // Inside nodes with an outside node among their six neighbours.
    parts.outermost[x] = here & ~(below_x & above_x & below_y & above_y & below_z & above_z);
    forEachBit(parts.outermost[x], [&](std::size_t n) {
      const std::size_t offset = 64 * x + n;
      parts.parts[parts.partAt(offset)].measure.fringe += fringeOf(in, offset);
    });
  }
}

}  // namespace kerf::internal
