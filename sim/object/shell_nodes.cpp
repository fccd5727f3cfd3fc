#include "sim/object/shell_nodes.h"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/object/shell_nodes.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 8>;
using I = hn::RebindToSigned<F>;
using V = hn::Vec<F>;

// Bits of a row of eight nodes; lane k of the part that begins at `from` is node from + k.
template <class Mask>
HWY_INLINE unsigned rowBits(F f, Mask mask, int from) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(f, mask, bits);
  return static_cast<unsigned>(bits[0]) << from;
}

int shellNodesHere(const BrickNeighborhood& bricks, const std::uint8_t* materials, float half_width, float scale,
                   ShellChunk* out) {
  constexpr int kRows = kBrickNodes / 8, kReserve = kBrickNodes + 8;
  const F f;
  const I i;
  const hn::Rebind<std::uint8_t, F> u8;
  const hn::Rebind<std::uint16_t, F> u16;
  const int lanes = static_cast<int>(hn::Lanes(f));
  const V e = hn::Set(f, half_width), one = hn::Set(f, 1.0f);

  // Most rows have no node. The first pass finds the others, and writes them down between their neighbours along z,
  // which lie in other bricks at both ends.
  alignas(64) float line[kRows][16];
  int rows[kRows], row_count = 0;
  for (int row = 0; row < kRows; ++row) {
    const int n = 8 * row;
    bool is_empty = true;
    for (int k = 0; k < 8; k += lanes)
      is_empty &= hn::AllFalse(f, hn::Lt(hn::Abs(hn::LoadU(f, bricks.self + n + k)), e));
    if (is_empty) continue;
    float* const at = line[rows[row_count++] = row];
    for (int k = 0; k < 8; k += lanes) hn::StoreU(hn::LoadU(f, bricks.self + n + k), f, at + 4 + k);
    at[3] = bricks.face[4][n + 7];
    at[12] = bricks.face[5][n];
  }

  // Second pass: the nodes of these rows, one after the other.
  float area[3][kReserve], values[kReserve];
  std::int32_t label[kReserve];  // offset, and the material 16 bits above
  int count = 0;
  for (int r = 0; r < row_count; ++r) {
    const int row = rows[r], n = 8 * row, u = row >> 3, v = row & 7;
    const float* const self = bricks.self + n;
    const float* const below[3] = {u > 0 ? self - 64 : bricks.face[0] + n + 7 * 64,
                                   v > 0 ? self - 8 : bricks.face[2] + n + 7 * 8, line[row] + 3};
    const float* const above[3] = {u < 7 ? self + 64 : bricks.face[1] + n - 7 * 64,
                                   v < 7 ? self + 8 : bricks.face[3] + n - 7 * 8, line[row] + 5};

    for (int k = 0; k < 8; k += lanes) {
      const V phi = hn::LoadU(f, self + k);
      const auto is_node = hn::Lt(hn::Abs(phi), e);
      const V part = hn::Div(phi, e), fade = hn::Sub(one, hn::Mul(part, part));
      const V weight = hn::Mul(hn::Mul(hn::Set(f, scale), fade), fade);
      for (int axis = 0; axis < 3; ++axis) {
        const V difference = hn::Sub(hn::LoadU(f, above[axis] + k), hn::LoadU(f, below[axis] + k));
        hn::StoreU(hn::Compress(hn::Mul(weight, difference), is_node), f, area[axis] + count);
      }
      hn::StoreU(hn::Compress(phi, is_node), f, values + count);
      const auto material = hn::PromoteTo(i, hn::LoadU(u8, materials + n + k));
      const auto both = hn::Add(hn::ShiftLeft<16>(material), hn::Iota(i, n + k));
      hn::StoreU(hn::Compress(both, hn::RebindMask(i, is_node)), i, label + count);
      count += static_cast<int>(hn::CountTrue(f, is_node));
    }
  }

  // Third pass: chunk by chunk.
  for (int begin = 0; begin < count; begin += ShellChunk::kNodes) {
    ShellChunk& chunk = out[begin / ShellChunk::kNodes];
    const int nodes = std::min(ShellChunk::kNodes, count - begin);
    for (int n = nodes; n < ShellChunk::kNodes; ++n) {
      for (auto& axis : area) axis[begin + n] = 0;
      values[begin + n] = values[begin];
      label[begin + n] = label[begin] & 0xffff;
    }

    float* const to[3] = {chunk.x.data(), chunk.y.data(), chunk.z.data()};
    for (int axis = 0; axis < 3; ++axis) std::memcpy(to[axis], area[axis] + begin, sizeof chunk.x);
    std::memcpy(chunk.phi.data(), values + begin, sizeof chunk.phi);
    for (int n = 0; n < ShellChunk::kNodes; n += lanes) {
      const auto both = hn::LoadU(i, label + begin + n);
      hn::StoreU(hn::DemoteTo(u16, hn::And(both, hn::Set(i, 0xffff))), u16, chunk.offset.data() + n);
      hn::StoreU(hn::DemoteTo(u8, hn::ShiftRight<16>(both)), u8, chunk.material.data() + n);
    }
  }
  return count;
}

void differingNodesHere(const float* a, const float* b, NodeBits& out) {
  const F f;
  const int lanes = static_cast<int>(hn::Lanes(f));
  for (int word = 0; word < kBrickSide; ++word) {
    std::uint64_t bits = 0;
    for (int row = 0; row < 8; ++row)
      for (int k = 0; k < 8; k += lanes) {
        const int n = 64 * word + 8 * row + k;
        bits |= std::uint64_t{rowBits(f, hn::Ne(hn::LoadU(f, a + n), hn::LoadU(f, b + n)), k)} << 8 * row;
      }
    out[static_cast<std::size_t>(word)] = bits;
  }
}

}  // namespace kerf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::internal {

HWY_EXPORT(shellNodesHere);
HWY_EXPORT(differingNodesHere);

int shellNodes(const BrickNeighborhood& bricks, const std::uint8_t* materials, float half_width, float scale,
               ShellChunk* out) noexcept {
  return HWY_DYNAMIC_DISPATCH(shellNodesHere)(bricks, materials, half_width, scale, out);
}

NodeBits differingNodes(const float* a, const float* b) noexcept {
  NodeBits out;
  HWY_DYNAMIC_DISPATCH(differingNodesHere)(a, b, out);
  return out;
}

}  // namespace kerf::internal
#endif
