#include "sim/object/node_volumes.h"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/object/node_volumes.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 8>;
using I = hn::RebindToSigned<F>;
using V = hn::Vec<F>;

void insideNodesHere(const float* values, NodeBits& out) {
  const F f;
  const int lanes = static_cast<int>(hn::Lanes(f));
  for (int slab = 0; slab < kBrickSide; ++slab) {
    std::uint64_t bits = 0;
    for (int n = 0; n < 64; n += lanes) {
      std::uint8_t part[8] = {};
      hn::StoreMaskBits(f, hn::Lt(hn::LoadU(f, values + 64 * slab + n), hn::Zero(f)), part);
      bits |= std::uint64_t{part[0]} << n;
    }
    out[static_cast<std::size_t>(slab)] = bits;
  }
}

void nodesOfHere(const std::uint8_t* numbers, std::uint8_t number, NodeBits& out) {
  const hn::CappedTag<std::uint8_t, 64> u;
  const int lanes = static_cast<int>(hn::Lanes(u));
  const auto wanted = hn::Set(u, number);
  for (int slab = 0; slab < kBrickSide; ++slab) {
    std::uint64_t bits = 0;
    for (int n = 0; n < 64; n += lanes) {
      std::uint8_t part[8] = {};
      hn::StoreMaskBits(u, hn::Eq(hn::LoadU(u, numbers + 64 * slab + n), wanted), part);
      std::uint64_t word;
      std::memcpy(&word, part, sizeof word);
      bits |= word << n;
    }
    out[static_cast<std::size_t>(slab)] = bits;
  }
}

// Bits of a row of eight values that are negative.
HWY_INLINE std::uint64_t insideRow(const float* row) {
  const F f;
  const int lanes = static_cast<int>(hn::Lanes(f));
  std::uint64_t bits = 0;
  for (int n = 0; n < 8; n += lanes) {
    std::uint8_t part[8] = {};
    hn::StoreMaskBits(f, hn::Lt(hn::LoadU(f, row + n), hn::Zero(f)), part);
    bits |= std::uint64_t{part[0]} << n;
  }
  return bits;
}

void insideBeyondHere(const float* const face[6], std::uint64_t out[6]) {
  for (int side = 0; side < 2; ++side) {
    const int end = 7 * (1 - side);  // of the other brick
    std::uint64_t x = 0, y = 0, z = 0;
    for (int a = 0; a < 8; ++a) {
      x |= insideRow(face[side] + 64 * end + 8 * a) << 8 * a;
      y |= insideRow(face[2 + side] + 64 * a + 8 * end) << 8 * a;
      for (int b = 0; b < 8; ++b) z |= std::uint64_t{face[4 + side][64 * a + 8 * b + end] < 0} << (8 * a + b);
    }
    out[side] = x;
    out[2 + side] = y;
    out[4 + side] = z;
  }
}

void nodeVolumesHere(const float* value, const float* const beside[6], int count, float band, std::int32_t* out) {
  const F f;
  const I i;
  const int lanes = static_cast<int>(hn::Lanes(f));
  const V zero = hn::Zero(f), half = hn::Set(f, 0.5f), all = hn::Set(f, static_cast<float>(kCellParts));
  const V most = hn::Set(f, band);
  for (int n = 0; n < count; n += lanes) {
    const V v = hn::LoadU(f, value + n), size = hn::Min(hn::Abs(v), most);
    const auto is_inside = hn::Lt(v, zero);
    // Distance of an edge's crossing, at most a half.
    const auto reach = [&](const float* other) {
      const V w = hn::LoadU(f, other + n);
      const auto crosses = hn::Xor(hn::Lt(w, zero), is_inside);
      return hn::IfThenElse(crosses, hn::Min(hn::Div(size, hn::Add(size, hn::Min(hn::Abs(w), most))), half), half);
    };
    V least = half;
    for (int side = 0; side < 6; ++side) least = hn::Min(least, reach(beside[side]));

    // Half of the cell, plus or minus the distance from its middle to the nearest crossing.
    const auto parts = hn::ConvertTo(i, hn::Add(hn::Mul(least, all), half));
    const auto mask = hn::RebindMask(i, is_inside);
    const auto middle = hn::Set(i, kCellParts / 2);
    hn::StoreU(hn::IfThenElse(mask, hn::Add(middle, parts), hn::Sub(middle, parts)), i, out + n);
  }
}

}  // namespace kerf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf {
namespace {

// The neighbours of every node: 512 times the brick (0 itself, 1 + face the others) plus the node there.
using Neighbours = std::array<std::array<std::uint16_t, 6>, kBrickNodes>;
constexpr Neighbours makeNeighbours() {
  Neighbours out{};
  for (std::size_t n = 0; n < kBrickNodes; ++n)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t step = std::size_t{64} >> 3 * axis, at = n / step % 8;
      out[n][2 * axis] = static_cast<std::uint16_t>(at > 0 ? n - step : 512 * (1 + 2 * axis) + n + 7 * step);
      out[n][2 * axis + 1] = static_cast<std::uint16_t>(at < 7 ? n + step : 512 * (2 + 2 * axis) + n - 7 * step);
    }
  return out;
}
constexpr Neighbours kNeighbours = makeNeighbours();

}  // namespace

namespace internal {

HWY_EXPORT(insideNodesHere);
HWY_EXPORT(nodesOfHere);
HWY_EXPORT(insideBeyondHere);
HWY_EXPORT(nodeVolumesHere);

NodeBits insideNodes(const float* values) noexcept {
  NodeBits out;
  HWY_DYNAMIC_DISPATCH(insideNodesHere)(values, out);
  return out;
}

// The nodes of a brick that have this number.
static NodeBits nodesOf(const std::uint8_t* numbers, std::uint8_t number) noexcept {
  NodeBits out;
  HWY_DYNAMIC_DISPATCH(nodesOfHere)(numbers, number, out);
  return out;
}

// The negative nodes of the other bricks at their face to this one: 8 a + b, a and b the other axes.
static std::array<std::uint64_t, 6> insideBeyond(const float* const face[6]) noexcept {
  std::array<std::uint64_t, 6> out;
  HWY_DYNAMIC_DISPATCH(insideBeyondHere)(face, out.data());
  return out;
}

void nodeVolumes(const float* value, const float* const beside[6], int count, float band, std::int32_t* out) noexcept {
  HWY_DYNAMIC_DISPATCH(nodeVolumesHere)(value, beside, count, band, out);
}

// The same node before and after the change of its brick's values. Nodes beyond a face are the same in both.
static void setBoth(int at, int node, const BrickNeighborhood& bricks, const float* after, SurfaceNodes& was,
                    SurfaceNodes& is) noexcept {
  was.value[at] = bricks.self[node];
  is.value[at] = after[node];
  const auto& neighbours = kNeighbours[static_cast<std::size_t>(node)];
  for (std::size_t k = 0; k < 6; ++k) {
    const std::size_t neighbour = neighbours[k];
    const bool is_here = neighbour < kBrickNodes;
    was.beside[k][at] = is_here ? bricks.self[neighbour] : bricks.face[k][neighbour & 511];
    is.beside[k][at] = is_here ? after[neighbour] : was.beside[k][at];
  }
}

void SurfaceNodes::set(int at, int node, const BrickNeighborhood& bricks) noexcept {
  const float* const from[7] = {bricks.self,    bricks.face[0], bricks.face[1], bricks.face[2],
                                bricks.face[3], bricks.face[4], bricks.face[5]};
  value[at] = bricks.self[node];
  const auto& neighbours = kNeighbours[static_cast<std::size_t>(node)];
  for (std::size_t k = 0; k < 6; ++k) beside[k][at] = from[neighbours[k] >> 9][neighbours[k] & 511];
}

// The node's own material, outside too. With a neighbour's material, a cut that takes the neighbour away would move a
// part of the node's volume from one tissue to another.
void SurfaceNodes::label(int at, int node, const MaterialNeighborhood& materials) noexcept {
  material[at] = materials.self[node];
}

void SurfaceNodes::measure(int count, float band) noexcept {
  for (int n = count; n % 8 != 0; ++n) {  // padding: none of them counts
    value[n] = 1;
    for (auto& axis : beside) axis[n] = 1;
  }
  const float* const others[6] = {beside[0], beside[1], beside[2], beside[3], beside[4], beside[5]};
  nodeVolumes(value, others, count, band, parts);
}

}  // namespace internal

namespace {

using internal::NodeBits;

constexpr std::uint64_t kLowRow = 0xff, kHighRow = kLowRow << 56;                        // y = 0 and 7 of a slab
constexpr std::uint64_t kLowColumn = 0x0101010101010101, kHighColumn = kLowColumn << 7;  // z = 0 and 7

// The nodes of one face as bits: 8 a + b, a and b the other axes in their order.
std::uint64_t faceOf(const NodeBits& nodes, int face) {
  if (face < 2) return face == 0 ? nodes.front() : nodes.back();
  std::uint64_t out = 0;
  for (int slab = 0; slab < kBrickSide; ++slab) {
    const std::uint64_t bits = nodes[static_cast<std::size_t>(slab)];
    std::uint64_t row = 0;
    if (face < 4)
      row = bits >> (face == 2 ? 0 : 56) & kLowRow;
    else  // eight bits, eight apart, side by side
      row = (bits >> (face == 4 ? 0 : 7) & kLowColumn) * 0x0102040810204080 >> 56;
    out |= row << 8 * slab;
  }
  return out;
}

// The node of a face that has this bit.
constexpr int nodeOfFace(int face, int bit) {
  const int end = face & 1 ? 7 : 0, a = bit >> 3, b = bit & 7;
  return face < 2 ? 64 * end + 8 * a + b : face < 4 ? 64 * a + 8 * end + b : 64 * a + 8 * b + end;
}

// Inside nodes of a brick and beyond its faces.
struct Signs {
  NodeBits self;
  std::array<std::uint64_t, 6> beyond;

  explicit Signs(const BrickNeighborhood& bricks)
      : self(internal::insideNodes(bricks.self)), beyond(internal::insideBeyond(bricks.face)) {}
};

// Eight bits, each to the lowest bit of a byte.
constexpr std::uint64_t spread(std::uint64_t bits) {
  return ((bits * kLowColumn & 0x8040201008040201) + 0x7f7f7f7f7f7f7f7f) >> 7 & kLowColumn;
}

// Combines each node's bit with those of its neighbours: any(bits of a node, bits of a neighbour).
template <class Join>
NodeBits joinNeighbours(const NodeBits& nodes, const std::array<std::uint64_t, 6>& beyond, const Join& join) {
  NodeBits out;
  for (std::size_t x = 0; x < kBrickSide; ++x) {
    const std::uint64_t here = nodes[x];
    const std::uint64_t low_z = spread(beyond[4] >> 8 * x & kLowRow), high_z = spread(beyond[5] >> 8 * x & kLowRow)
                                                                               << 7;
    const std::uint64_t row_below = beyond[2] >> 8 * x & kLowRow, row_above = beyond[3] >> 8 * x & kLowRow;
    out[x] = join(here, x > 0 ? nodes[x - 1] : beyond[0]) | join(here, x < 7 ? nodes[x + 1] : beyond[1]) |
             join(here, here << 8 | row_below) | join(here, here >> 8 | row_above << 56) |
             join(here, (here << 1 & ~kLowColumn) | low_z) | join(here, (here >> 1 & ~kHighColumn) | high_z);
  }
  return out;
}

// The nodes that have a neighbour of the other sign.
NodeBits atSurface(const NodeBits& inside, const std::array<std::uint64_t, 6>& beyond) {
  return joinNeighbours(inside, beyond, [](std::uint64_t here, std::uint64_t there) { return here ^ there; });
}

template <class Visit>
void forEachNode(const NodeBits& nodes, const Visit& visit) {
  for (int slab = 0; slab < kBrickSide; ++slab)
    for (std::uint64_t bits = nodes[static_cast<std::size_t>(slab)]; bits != 0; bits &= bits - 1)
      visit(64 * slab + std::countr_zero(bits));
}

// Adds whole cells, material by material: a brick has few.
void addWhole(NodeBits whole, const MaterialNeighborhood& materials, PartsByNumber& sum) {
  for (std::size_t x = 0; x < kBrickSide; ++x)
    while (whole[x] != 0) {
      const int first = 64 * static_cast<int>(x) + std::countr_zero(whole[x]);
      const std::uint8_t number = materials.self[first];
      const NodeBits same = internal::nodesOf(materials.self, number);
      std::int64_t cells = 0;
      for (std::size_t slab = x; slab < kBrickSide; ++slab) {
        cells += std::popcount(whole[slab] & same[slab]);
        whole[slab] &= ~same[slab];
      }
      sum[number] += std::int64_t{kCellParts} * cells;
    }
}

}  // namespace

void addVolumes(const BrickNeighborhood& bricks, const MaterialNeighborhood& materials, float band,
                PartsByNumber& sum) noexcept {
  const Signs signs(bricks);
  const NodeBits surface = atSurface(signs.self, signs.beyond);
  NodeBits whole;
  for (std::size_t x = 0; x < kBrickSide; ++x) whole[x] = signs.self[x] & ~surface[x];

  if (materials.is_one)
    for (const std::uint64_t slab : whole) sum[materials.self[0]] += std::int64_t{kCellParts} * std::popcount(slab);
  else
    addWhole(whole, materials, sum);

  internal::SurfaceNodes nodes;
  int count = 0;
  forEachNode(surface, [&](int n) {
    nodes.set(count, n, bricks);
    nodes.label(count, n, materials);
    ++count;
  });
  nodes.measure(count, band);
  for (int n = 0; n < count; ++n) sum[nodes.material[n]] += nodes.parts[n];
}

// A volume changes where the sign does, and beside a crossing edge that changed at one end.
VolumeChange::VolumeChange(const BrickNeighborhood& before, const float* after, const NodeBits& changed,
                           const MaterialNeighborhood& materials, const std::uint8_t* materials_after,
                           float band) noexcept
    : before_values_(before.self),
      after_values_(after),
      materials_before_(materials.self),
      materials_after_(materials_after),
      band_(band),
      is_one_(materials.is_one && materials_after == materials.self) {
  const Signs was(before);
  const NodeBits inside = internal::insideNodes(after);
  const NodeBits surface_was = atSurface(was.self, was.beyond), surface = atSurface(inside, was.beyond);
  const NodeBits near =
      joinNeighbours(changed, {}, [](std::uint64_t here, std::uint64_t there) { return here | there; });

  MaterialNeighborhood labels = materials;
  labels.self = materials_after;
  NodeBits nodes;
  for (std::size_t x = 0; x < kBrickSide; ++x)
    nodes[x] = ((surface_was[x] | surface[x]) & near[x]) | (was.self[x] ^ inside[x]);
  forEachNode(nodes, [&](int n) {
    internal::setBoth(count_, n, before, after, before_, after_);
    if (!is_one_) {
      before_.label(count_, n, materials);
      after_.label(count_, n, labels);
    }
    ++count_;
  });

  for (int face = 0; face < 6; ++face) {
    const std::uint64_t other = was.beyond[static_cast<std::size_t>(face)];
    const std::uint64_t crosses = (faceOf(was.self, face) ^ other) | (faceOf(inside, face) ^ other);
    const std::uint64_t beyond = crosses & faceOf(changed, face);
    beyond_[static_cast<std::size_t>(face)] = beyond;
    faces_ |= static_cast<std::uint8_t>((beyond != 0) << face);
  }
}

void VolumeChange::addBeyond(int face, const BrickNeighborhood& brick, const MaterialNeighborhood& materials) noexcept {
  const int back = face ^ 1;
  BrickNeighborhood now = brick;
  now.face[back] = after_values_;
  MaterialNeighborhood labels = materials;
  labels.face[back] = materials_after_;

  const bool is_same = materials.is_one && materials.self[0] == materials_before_[0];
  if (is_one_ && !is_same) {
    std::memset(before_.material, materials_before_[0], static_cast<std::size_t>(count_));
    std::memset(after_.material, materials_before_[0], static_cast<std::size_t>(count_));
    is_one_ = false;
  }

  for (std::uint64_t bits = beyond_[static_cast<std::size_t>(face)]; bits != 0; bits &= bits - 1) {
    const int n = nodeOfFace(back, std::countr_zero(bits));
    before_.set(count_, n, brick);
    after_.set(count_, n, now);
    if (!is_one_) {
      before_.label(count_, n, materials);
      after_.label(count_, n, labels);
    }
    ++count_;
  }
}

std::int64_t VolumeChange::lost() noexcept {
  before_.measure(count_, band_);
  after_.measure(count_, band_);
  std::int64_t out = 0;
  for (int n = 0; n < count_; ++n) out += before_.parts[n] - after_.parts[n];
  return out;
}

void VolumeChange::addLost(PartsByNumber& sum) const noexcept {
  for (int n = 0; n < count_; ++n) {
    sum[before_.material[n]] += before_.parts[n];
    sum[after_.material[n]] -= after_.parts[n];
  }
}

}  // namespace kerf
#endif
