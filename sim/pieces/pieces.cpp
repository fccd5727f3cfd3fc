#include "sim/pieces/pieces.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace kerf {
namespace {

constexpr std::uint64_t kAll = ~std::uint64_t{0};
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

// Node n (in the order of a face's mask) of the face on a side of the brick.
constexpr int faceNode(std::size_t side, int n) {
  const int a = n >> 3, b = n & 7, at = side & 1 ? kBrickSide - 1 : 0;
  return side / 2 == 0 ? nodeOffset(at, a, b) : side / 2 == 1 ? nodeOffset(a, at, b) : nodeOffset(a, b, at);
}

std::array<std::uint64_t, 6> facesOf(const std::array<std::uint64_t, 8>& bits) {
  std::array<std::uint64_t, 6> f{bits[0], bits[7], 0, 0, 0, 0};
  for (std::size_t i = 0; i < 8; ++i) {
    f[2] |= (bits[i] & kY0) << 8 * i;
    f[3] |= (bits[i] >> 56) << 8 * i;
    f[4] |= columnOfZ0(bits[i]) << 8 * i;
    f[5] |= columnOfZ0(bits[i] >> 7) << 8 * i;
  }
  return f;
}

template <class Visit>
void forEachBit(std::uint64_t word, const Visit& visit) {
  for (; word; word &= word - 1) visit(std::countr_zero(word));
}

const Vec3i kSteps[6] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};

Vec3i coordOf(std::uint64_t key) {
  const auto c = coordOfKey(key);
  return {c[0], c[1], c[2]};
}

}  // namespace

PieceFinder::PieceFinder(const BrickField& phi0, const PieceOptions& options) : field_(phi0), options_(options) {
  const std::vector<Vec3i> interior = phi0.interiorBricks();
  keys_.reserve(phi0.brickCount() + interior.size());
  for (std::size_t b = 0; b < phi0.brickCount(); ++b) keys_.push_back(coordKey(phi0.brickCoord(b)));
  for (const Vec3i& c : interior) keys_.push_back(coordKey(c));
  scanAll();
}

PieceFinder::PieceFinder(const BrickField& phi0, std::span<const Vec3i> bricks, const PieceOptions& options)
    : field_(phi0), options_(options) {
  for (const Vec3i& c : bricks)
    if (field_.valuesAt(c) || field_.constantAt(c) < 0) keys_.push_back(coordKey(c));
  scanAll();
}

void PieceFinder::scanAll() {
  std::sort(keys_.begin(), keys_.end());
  const std::size_t count = first_count_ = keys_.size();
  layDirectory();
  is_baked_.resize(count);
  for (std::size_t s = 0; s < count; ++s) is_baked_[s] = field_.baked().valuesAt(coordOf(keys_[s])) != nullptr;

  // Neighbours above come in the order of the bricks themselves: one pointer per axis walks along.
  neighbours_.assign(count, {kNoSlot, kNoSlot, kNoSlot, kNoSlot, kNoSlot, kNoSlot});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::size_t above = 0;
    for (std::size_t s = 0; s < count; ++s) {
      const std::uint64_t wanted = coordKey(Vec3i(coordOf(keys_[s]) + kSteps[2 * axis + 1]));
      while (above < count && keys_[above] < wanted) ++above;
      if (above == count) break;
      if (keys_[above] != wanted) continue;
      neighbours_[s][2 * axis + 1] = static_cast<std::int32_t>(above);
      neighbours_[above][2 * axis] = static_cast<std::int32_t>(s);
    }
  }

  detail_of_.assign(count, kFull);
  std::vector<std::int32_t> stored;
  for (std::size_t s = 0; s < count; ++s) {
    if (!field_.valuesAt(coordOf(keys_[s]))) continue;
    detail_of_[s] = static_cast<std::int32_t>(stored.size());
    stored.push_back(static_cast<std::int32_t>(s));
  }
  details_.resize(stored.size());
  tbb::parallel_for(std::size_t{0}, stored.size(), [&](std::size_t n) {
    labelParts(*field_.valuesAt(coordOf(keys_[static_cast<std::size_t>(stored[n])])), details_[n]);
  });
  tbb::parallel_for(std::size_t{0}, stored.size(), [&](std::size_t n) { measureFringe(stored[n]); });
  // Bricks stored as a constant have a fringe where they end against something that is not inside: rarely.
  for (std::size_t s = 0; s < count; ++s) {
    const auto slot = static_cast<std::int32_t>(s);
    if (detail_of_[s] == kFull && touchesOutside(slot)) {
      detailOf(slot);
      measureFringe(slot);
    }
  }
  block_of_.reserve(count);
  group_of_full_.reserve(count);
  for (std::size_t s = 0; s < count; ++s) addToBlock(static_cast<std::int32_t>(s));
}

void PieceFinder::addToBlock(std::int32_t slot) {
  const Vec3i at =
      brickOf(coordOf(keys_[static_cast<std::size_t>(slot)]));  // bricks are to a block as nodes to a brick
  const auto [known, is_new] = block_at_.try_emplace(coordKey(at), static_cast<std::int32_t>(blocks_.size()));
  const std::int32_t b = known->second;
  if (is_new) {
    blocks_.emplace_back();
    for (int axis = 0; axis < 3; ++axis) {
      const auto above = block_at_.find(coordKey(at + kSteps[2 * axis + 1]));
      if (above != block_at_.end()) blocks_.back().above[static_cast<std::size_t>(axis)] = above->second;
      const auto below = block_at_.find(coordKey(at + kSteps[2 * axis]));
      if (below != block_at_.end())
        blocks_[static_cast<std::size_t>(below->second)].above[static_cast<std::size_t>(axis)] = b;
    }
  }
  blocks_[static_cast<std::size_t>(b)].slots.push_back(slot);
  blocks_[static_cast<std::size_t>(b)].is_changed = true;
  block_of_.push_back(static_cast<std::uint32_t>(b));
  group_of_full_.push_back(0);
}

// The box of all slots, with as much air around it as can be filled before it must be laid anew.
void PieceFinder::layDirectory() {
  Vec3i low = Vec3i::Constant(std::numeric_limits<int>::max()), high = -low;
  for (const std::uint64_t key : keys_) {
    low = low.cwiseMin(coordOf(key));
    high = high.cwiseMax(coordOf(key));
  }
  if (keys_.empty()) low = high = Vec3i::Zero();
  constexpr int kAir = 4;
  low_ = low - Vec3i::Constant(kAir);
  size_ = high - low + Vec3i::Constant(1 + 2 * kAir);
  directory_.assign(static_cast<std::size_t>(size_.cast<std::ptrdiff_t>().prod()), kNoSlot);
  for (std::size_t s = 0; s < keys_.size(); ++s) {
    const Vec3i at = coordOf(keys_[s]) - low_;
    directory_[static_cast<std::size_t>((at[0] * size_[1] + at[1]) * size_[2] + at[2])] = static_cast<std::int32_t>(s);
  }
}

std::int32_t PieceFinder::addSlot(const Vec3i& brick) {
  const auto slot = static_cast<std::int32_t>(keys_.size());
  keys_.push_back(coordKey(brick));
  is_baked_.push_back(0);
  const Vec3i at = brick - low_;
  if ((at.array() < 0).any() || (at.array() >= size_.array()).any())
    layDirectory();
  else
    directory_[static_cast<std::size_t>((at[0] * size_[1] + at[1]) * size_[2] + at[2])] = slot;
  detail_of_.push_back(kOutside);
  std::array<std::int32_t, 6>& mine = neighbours_.emplace_back();
  for (std::size_t side = 0; side < 6; ++side) {
    mine[side] = slotOf(brick + kSteps[side]);
    if (mine[side] != kNoSlot) neighbours_[static_cast<std::size_t>(mine[side])][side ^ 1] = slot;
  }
  addToBlock(slot);
  return slot;
}

PieceFinder::Detail& PieceFinder::detailOf(std::int32_t slot) {
  std::int32_t& index = detail_of_[static_cast<std::size_t>(slot)];
  if (index < 0) {
    const bool is_full = index == kFull;
    index = static_cast<std::int32_t>(details_.size());
    Detail& made = details_.emplace_back();
    if (is_full) {
      made.bits.fill(kAll);
      made.faces.fill(kAll);
      made.parts.push_back({{kBrickNodes, 0}, {0, 0, 0}, {7, 7, 7}, 0});
    }
  }
  return details_[static_cast<std::size_t>(index)];
}

std::uint32_t PieceFinder::partCount(std::int32_t slot) const {
  const std::int32_t index = detail_of_[static_cast<std::size_t>(slot)];
  if (index < 0) return index == kFull ? 1 : 0;
  return static_cast<std::uint32_t>(details_[static_cast<std::size_t>(index)].parts.size());
}

std::uint64_t PieceFinder::face(std::int32_t slot, std::size_t side) const {
  if (slot == kNoSlot) return 0;
  const std::int32_t index = detail_of_[static_cast<std::size_t>(slot)];
  if (index < 0) return index == kFull ? kAll : 0;
  return details_[static_cast<std::size_t>(index)].faces[side];
}

// @pre the node is inside.
std::uint32_t PieceFinder::partAt(std::int32_t slot, int offset) const {
  const std::int32_t index = detail_of_[static_cast<std::size_t>(slot)];
  if (index < 0) return 0;
  const Detail& d = details_[static_cast<std::size_t>(index)];
  return d.label.empty() ? 0 : d.label[static_cast<std::size_t>(offset)];
}

// Finds the connected parts of one brick by growing each from its first node, a word of 64 nodes at a time.
void PieceFinder::labelParts(const BrickValues& phi, Detail& out) {
  for (std::size_t i = 0; i < 8; ++i) {
    std::uint64_t word = 0;
    for (std::size_t n = 0; n < 64; ++n) word |= std::uint64_t{phi[64 * i + n] < 0} << n;
    out.bits[i] = word;
  }
  out.faces = facesOf(out.bits);
  out.parts.clear();
  out.label.clear();
  Bits left = out.bits;
  for (std::size_t first = 0; first < 8; ++first)
    while (left[first]) {
      Bits grown{};
      grown[first] = left[first] & (~left[first] + 1);
      for (bool is_growing = true; is_growing;) {
        is_growing = false;
        for (std::size_t i = 0; i < 8; ++i) {
          const std::uint64_t c = grown[i];
          const std::uint64_t next = (c | ((c << 1) & ~kZ0) | ((c >> 1) & ~(kZ0 << 7)) | c << 8 | c >> 8 |
                                      (i > 0 ? grown[i - 1] : 0) | (i < 7 ? grown[i + 1] : 0)) &
                                     left[i];
          if (next != c) {
            grown[i] = next;
            is_growing = true;
          }
        }
      }
      Part part;
      part.first = static_cast<std::uint16_t>(64 * first + static_cast<std::size_t>(std::countr_zero(left[first])));
      std::uint64_t seen = 0;
      part.low[0] = static_cast<std::uint8_t>(first);
      for (std::size_t i = 0; i < 8; ++i) {
        if (!grown[i]) continue;
        part.high[0] = static_cast<std::uint8_t>(i);
        part.measure.nodes += static_cast<std::uint64_t>(std::popcount(grown[i]));
        seen |= grown[i];
        left[i] &= ~grown[i];
      }
      part.low[1] = static_cast<std::uint8_t>(std::countr_zero(seen) / 8);
      part.high[1] = static_cast<std::uint8_t>((63 - std::countl_zero(seen)) / 8);
      std::uint64_t column = 0;
      for (int j = 0; j < 8; ++j) column |= seen >> 8 * j & 0xff;
      part.low[2] = static_cast<std::uint8_t>(std::countr_zero(column));
      part.high[2] = static_cast<std::uint8_t>(63 - std::countl_zero(column));
      const bool is_last = std::all_of(left.begin(), left.end(), [](std::uint64_t w) { return w == 0; });
      if (!is_last || !out.parts.empty()) {
        out.label.resize(kBrickNodes);
        for (std::size_t i = 0; i < 8; ++i)
          forEachBit(grown[i], [&](int n) {
            out.label[64 * i + static_cast<std::size_t>(n)] = static_cast<std::uint16_t>(out.parts.size());
          });
      }
      out.parts.push_back(part);
    }
}

bool PieceFinder::touchesOutside(std::int32_t slot) const {
  for (std::size_t side = 0; side < 6; ++side)
    if (face(neighbours_[static_cast<std::size_t>(slot)][side], side ^ 1) != kAll) return true;
  return false;
}

// Finds the outermost nodes, and books the gap between the surface and the cubes around inside nodes on them. Reads the
// values and masks of the neighbours.
// @pre the slot has a detail.
void PieceFinder::measureFringe(std::int32_t slot) {
  const auto s = static_cast<std::size_t>(slot);
  Detail& d = details_[static_cast<std::size_t>(detail_of_[s])];
  for (Part& part : d.parts) part.measure.fringe = 0;
  d.outermost = {};
  if (d.parts.empty()) return;
  struct Source {
    const BrickValues* values;
    float constant;
    double at(int offset) const { return values ? (*values)[static_cast<std::size_t>(offset)] : constant; }
  };
  const Vec3i brick = coordOf(keys_[s]);
  const Source own{field_.valuesAt(brick), field_.constantAt(brick)};
  std::array<Source, 6> beyond;
  for (std::size_t side = 0; side < 6; ++side) {
    const Vec3i next = brick + kSteps[side];
    beyond[side] = {field_.valuesAt(next), field_.constantAt(next)};
  }
  constexpr std::array<int, 6> kStride{-64, 64, -8, 8, -1, 1}, kAcross{448, -448, 56, -56, 7, -7};
  const auto bookNode = [&](int n) {
    const double a = own.at(n);
    const std::array<int, 3> c{n >> 6, n >> 3 & 7, n & 7};
    std::array<double, 6> around;
    for (std::size_t side = 0; side < 6; ++side) {
      const bool is_beyond = c[side / 2] == (side & 1 ? kBrickSide - 1 : 0);
      around[side] = is_beyond ? beyond[side].at(n + kAcross[side]) : own.at(n + kStride[side]);
    }
    std::array<double, 3> weight;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double slope = around[2 * axis + 1] - around[2 * axis];
      weight[axis] = slope * slope;
    }
    const double sum = weight[0] + weight[1] + weight[2];
    std::int64_t& fringe = d.parts[d.label.empty() ? 0 : d.label[static_cast<std::size_t>(n)]].measure.fringe;
    for (std::size_t side = 0; side < 6; ++side) {
      if (around[side] < 0) continue;
      const double t = a / (a - around[side]), w = sum > 0 ? weight[side / 2] / sum : 1.0 / 3;
      fringe += std::llround(w * (t - 0.5) * 0x1p32);
    }
  };
  for (std::size_t i = 0; i < 8; ++i) {  // inside nodes with one of the six around them that is not
    const std::uint64_t c = d.bits[i];
    const auto edge = [&](std::size_t side) { return face(neighbours_[s][side], side ^ 1); };
    // The rows of the neighbours' faces that lie beside this word.
    const std::uint64_t below_y = edge(2) >> 8 * i & 0xff, above_y = edge(3) >> 8 * i & 0xff;
    const std::uint64_t below_z = edge(4) >> 8 * i & 0xff, above_z = edge(5) >> 8 * i & 0xff;
    const std::uint64_t kept = (i > 0 ? d.bits[i - 1] : edge(0)) & (i < 7 ? d.bits[i + 1] : edge(1)) &
                               (c << 8 | below_y) & (c >> 8 | above_y << 56) & (((c << 1) & ~kZ0) | spread(below_z)) &
                               (((c >> 1) & ~(kZ0 << 7)) | spread(above_z) << 7);
    d.outermost[i] = c & ~kept;
    forEachBit(d.outermost[i], [&](int n) { bookNode(static_cast<int>(64 * i) + n); });
  }
}

void PieceFinder::apply(std::span<const BrickEdit> edits) {
  if (edits.empty()) return;
  is_current_ = false;
  std::vector<std::int32_t> changed;
  for (const BrickEdit& edit : edits) {
    field_.set(edit);
    std::int32_t slot = slotOf(edit.brick);
    if (slot == kNoSlot) slot = addSlot(edit.brick);
    changed.push_back(slot);
  }
  std::sort(changed.begin(), changed.end());
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  std::vector<std::int32_t> measured = changed;
  for (const std::int32_t slot : changed) {
    labelParts(*field_.valuesAt(coordOf(keys_[static_cast<std::size_t>(slot)])), detailOf(slot));
    blocks_[block_of_[static_cast<std::size_t>(slot)]].is_changed = true;
    for (const std::int32_t next : neighbours_[static_cast<std::size_t>(slot)])
      if (next != kNoSlot) measured.push_back(next);
  }
  std::sort(measured.begin(), measured.end());
  measured.erase(std::unique(measured.begin(), measured.end()), measured.end());
  for (const std::int32_t slot : measured) {
    const std::int32_t index = detail_of_[static_cast<std::size_t>(slot)];
    if (index == kOutside || (index == kFull && !touchesOutside(slot))) continue;
    detailOf(slot);
    measureFringe(slot);
    blocks_[block_of_[static_cast<std::size_t>(slot)]].is_changed = true;
  }
}

// Calls unite(part of a, part of b) for parts that meet in the face of a towards b, its upper neighbour along the axis.
template <class Unite>
void PieceFinder::joinBricks(std::int32_t a, std::int32_t b, int axis, const Unite& unite) const {
  const auto side = static_cast<std::size_t>(2 * axis + 1);
  const std::uint64_t both = face(a, side) & face(b, side ^ 1);
  if (!both) return;
  if (partCount(a) == 1 && partCount(b) == 1) {
    unite(0u, 0u);
    return;
  }
  forEachBit(both, [&](int n) { unite(partAt(a, faceNode(side, n)), partAt(b, faceNode(side ^ 1, n))); });
}

namespace {

// Union-find; a tree's root is its smallest member, so that roots do not depend on the order of unions.
std::uint32_t rootOf(std::vector<std::uint32_t>& parent, std::uint32_t p) {
  while (parent[p] != p) p = parent[p] = parent[parent[p]];
  return p;
}
void unite(std::vector<std::uint32_t>& parent, std::uint32_t a, std::uint32_t b) {
  if (parent[a] == parent[b]) return;  // joined already, as most are
  const std::uint32_t ra = rootOf(parent, a), rb = rootOf(parent, b);
  if (ra != rb) parent[std::max(ra, rb)] = std::min(ra, rb);
}

}  // namespace

std::uint32_t PieceFinder::groupOf(std::int32_t slot, std::uint32_t part) const {
  const std::int32_t index = detail_of_[static_cast<std::size_t>(slot)];
  return index < 0 ? group_of_full_[static_cast<std::size_t>(slot)]
                   : details_[static_cast<std::size_t>(index)].parts[part].group;
}

// Joins the parts of one block.
void PieceFinder::group(Block& block) {
  const std::uint32_t mine = block_of_[static_cast<std::size_t>(block.slots.front())];
  first_part_.resize(keys_.size());  // of the slots of this block only
  parent_.clear();
  for (const std::int32_t slot : block.slots) {
    first_part_[static_cast<std::size_t>(slot)] = static_cast<std::uint32_t>(parent_.size());
    for (std::uint32_t p = partCount(slot); p > 0; --p) parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
  }
  for (const std::int32_t slot : block.slots) {
    const auto s = static_cast<std::size_t>(slot);
    if (partCount(slot) == 0) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int32_t next = neighbours_[s][static_cast<std::size_t>(2 * axis + 1)];
      if (next == kNoSlot || block_of_[static_cast<std::size_t>(next)] != mine) continue;
      joinBricks(slot, next, axis, [&](std::uint32_t a, std::uint32_t b) {
        unite(parent_, first_part_[s] + a, first_part_[static_cast<std::size_t>(next)] + b);
      });
    }
  }
  block.groups.clear();
  std::vector<std::uint32_t> group_of(parent_.size());
  for (const std::int32_t slot : block.slots) {
    const auto s = static_cast<std::size_t>(slot);
    const Vec3i base = coordOf(keys_[s]) * kBrickSide;
    const std::int32_t index = detail_of_[s];
    const std::uint32_t parts = partCount(slot);
    for (std::uint32_t n = 0; n < parts; ++n) {
      const std::uint32_t p = first_part_[s] + n, root = rootOf(parent_, p);
      if (root == p) {
        group_of[p] = static_cast<std::uint32_t>(block.groups.size());
        block.groups.push_back({{},
                                Vec3i::Constant(std::numeric_limits<int>::max()),
                                Vec3i::Constant(std::numeric_limits<int>::min()),
                                kAll});
      }
      group_of[p] = group_of[root];
      Group& g = block.groups[group_of[p]];
      if (index == kFull) {
        group_of_full_[s] = group_of[p];
        g.measure.nodes += kBrickNodes;
        g.low = g.low.cwiseMin(base);
        g.high = g.high.cwiseMax(base + Vec3i::Constant(kBrickSide - 1));
        g.first = std::min(g.first, coordKey(base));
        continue;
      }
      Part& part = details_[static_cast<std::size_t>(index)].parts[n];
      part.group = group_of[p];
      g.measure.add(part.measure);
      g.low = g.low.cwiseMin(base + Vec3i{part.low[0], part.low[1], part.low[2]});
      g.high = g.high.cwiseMax(base + Vec3i{part.high[0], part.high[1], part.high[2]});
      g.first = std::min(g.first, coordKey(Vec3i(base + Vec3i{part.first >> 6, part.first >> 3 & 7, part.first & 7})));
    }
  }
}

// Which of its groups meet which of the block above.
void PieceFinder::joinAbove(Block& block, int axis) const {
  auto& joins = block.joins[static_cast<std::size_t>(axis)];
  joins.clear();
  const std::int32_t above = block.above[static_cast<std::size_t>(axis)];
  if (above == kNoSlot) return;
  for (const std::int32_t slot : block.slots) {
    const std::int32_t next = neighbours_[static_cast<std::size_t>(slot)][static_cast<std::size_t>(2 * axis + 1)];
    if (next == kNoSlot || block_of_[static_cast<std::size_t>(next)] != static_cast<std::uint32_t>(above)) continue;
    joinBricks(slot, next, axis, [&](std::uint32_t a, std::uint32_t b) {
      const std::pair pair(groupOf(slot, a), groupOf(next, b));
      if (std::find(joins.rbegin(), joins.rend(), pair) == joins.rend()) joins.push_back(pair);
    });
  }
}

const PieceList& PieceFinder::find() {
  if (is_current_) return list_;
  for (Block& block : blocks_)
    if (block.is_changed) group(block);
  const auto isChangedAbove = [&](const Block& block, int axis) {
    const std::int32_t above = block.above[static_cast<std::size_t>(axis)];
    return above != kNoSlot && blocks_[static_cast<std::size_t>(above)].is_changed;
  };
  std::uint32_t groups = 0;
  for (Block& block : blocks_) {
    for (int axis = 0; axis < 3; ++axis)
      if (block.is_changed || isChangedAbove(block, axis)) joinAbove(block, axis);
    block.first_group = groups;
    groups += static_cast<std::uint32_t>(block.groups.size());
  }
  std::vector<std::uint32_t> parent(groups);
  std::iota(parent.begin(), parent.end(), 0u);
  for (Block& block : blocks_) {
    block.is_changed = false;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const auto& [a, b] : block.joins[axis])
        unite(parent, block.first_group + a, blocks_[static_cast<std::size_t>(block.above[axis])].first_group + b);
  }

  std::vector<Group> found;
  piece_of_group_.resize(groups);
  list_ = {};
  for (const Block& block : blocks_)
    for (std::uint32_t n = 0; n < block.groups.size(); ++n) {
      const std::uint32_t g = block.first_group + n, root = rootOf(parent, g);
      const Group& from = block.groups[n];
      if (root == g) {
        piece_of_group_[g] = static_cast<std::uint32_t>(found.size());
        found.push_back(from);
      } else
        piece_of_group_[g] = piece_of_group_[root];
      if (root == g) continue;
      Group& to = found[piece_of_group_[g]];
      to.measure.add(from.measure);
      to.low = to.low.cwiseMin(from.low);
      to.high = to.high.cwiseMax(from.high);
      to.first = std::min(to.first, from.first);
    }

  const double h = field_.voxel();
  std::vector<Piece> all(found.size());
  for (std::size_t n = 0; n < found.size(); ++n) {
    all[n].id = static_cast<std::uint32_t>(n);  // numbered anew once they are sorted
    all[n].measure = found[n].measure;
    all[n].volume = found[n].measure.volume(h);
    all[n].bounds.add(h * found[n].low.cast<double>());
    all[n].bounds.add(h * found[n].high.cast<double>());
    all[n].first_node = coordOf(found[n].first);
    list_.whole.add(found[n].measure);
  }
  std::sort(all.begin(), all.end(), [&](const Piece& a, const Piece& b) {
    return a.volume != b.volume ? a.volume > b.volume : found[a.id].first < found[b.id].first;
  });
  std::vector<std::uint32_t> renamed(all.size());
  for (std::size_t n = 0; n < all.size(); ++n) {
    renamed[all[n].id] = static_cast<std::uint32_t>(n);
    all[n].id = static_cast<std::uint32_t>(n);
    (all[n].volume < options_.crumb_mm3 ? list_.crumbs : list_.pieces).push_back(all[n]);
  }
  for (std::uint32_t& p : piece_of_group_) p = renamed[p];
  is_current_ = true;
  return list_;
}

std::uint32_t PieceFinder::pieceAt(const Vec3i& node) const {
  assert(is_current_);
  const std::int32_t slot = slotOf(brickOf(node));
  if (slot == kNoSlot || partCount(slot) == 0) return kNoPiece;
  const int offset = nodeOffset(node[0], node[1], node[2]);
  const std::int32_t index = detail_of_[static_cast<std::size_t>(slot)];
  if (index >= 0 &&
      !(details_[static_cast<std::size_t>(index)].bits[static_cast<std::size_t>(offset >> 6)] >> (offset & 63) & 1))
    return kNoPiece;
  return piecesOfBlock(static_cast<std::size_t>(slot))[groupOf(slot, partAt(slot, offset))];
}

void PieceFinder::piecesIn(const Vec3i& brick, std::span<std::uint32_t, kBrickNodes> out) const {
  assert(is_current_);
  const std::int32_t slot = slotOf(brick);
  if (slot == kNoSlot || partCount(slot) == 0) return std::fill(out.begin(), out.end(), kNoPiece);
  const std::uint32_t* const piece = piecesOfBlock(static_cast<std::size_t>(slot));
  const std::int32_t index = detail_of_[static_cast<std::size_t>(slot)];
  if (index < 0) return std::fill(out.begin(), out.end(), piece[groupOf(slot, 0)]);
  const Detail& d = details_[static_cast<std::size_t>(index)];
  for (std::size_t n = 0; n < out.size(); ++n)
    out[n] = d.bits[n >> 6] >> (n & 63) & 1 ? piece[d.parts[d.label.empty() ? 0 : d.label[n]].group] : kNoPiece;
}

std::uint32_t PieceFinder::pieceOfSlot(std::size_t s) const {
  std::uint32_t piece = kNoPiece;
  const std::uint32_t* const of = piecesOfBlock(s);
  const auto slot = static_cast<std::int32_t>(s);
  const std::uint32_t parts = partCount(slot);
  for (std::uint32_t p = 0; p < parts; ++p) {
    const std::uint32_t its = of[groupOf(slot, p)];
    if (piece != kNoPiece && piece != its) return kSeveralPieces;
    piece = its;
  }
  return piece;
}

std::uint32_t PieceFinder::pieceOfBrick(const Vec3i& brick) const {
  assert(is_current_);
  const std::int32_t slot = slotOf(brick);
  return slot == kNoSlot ? kNoPiece : pieceOfSlot(static_cast<std::size_t>(slot));
}

std::vector<std::uint32_t> PieceFinder::piecesInSight() const {
  assert(is_current_);
  const auto both = [](std::uint32_t a, std::uint32_t b) {
    return a == kNoPiece || a == b ? b : b == kNoPiece ? a : kSeveralPieces;
  };
  std::vector<Vec3i> at;
  Vec3i low = Vec3i::Constant(std::numeric_limits<int>::max()), high = -low;
  for (const Block& block : blocks_) {
    at.push_back(brickOf(coordOf(keys_[static_cast<std::size_t>(block.slots.front())])));
    low = low.cwiseMin(at.back());
    high = high.cwiseMax(at.back());
  }
  if (blocks_.empty()) return {};
  const Vec3i size = high - low + Vec3i::Constant(3);
  const auto cellOf = [&](const Vec3i& c) {
    const Vec3i from_low = c - low + Vec3i::Ones();
    return static_cast<std::size_t>((from_low[0] * size[1] + from_low[1]) * size[2] + from_low[2]);
  };
  std::vector<std::uint32_t> cells(static_cast<std::size_t>(size.cast<std::ptrdiff_t>().prod()), kNoPiece), from;
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    for (std::uint32_t g = 0; g < blocks_[b].groups.size(); ++g)
      cells[cellOf(at[b])] = both(cells[cellOf(at[b])], piece_of_group_[blocks_[b].first_group + g]);
  // Axis by axis. The outermost cells are of no block: what lies before the first of a row is nothing.
  const auto row = static_cast<std::size_t>(size[2]), plane = row * static_cast<std::size_t>(size[1]);
  for (const std::size_t step : {std::size_t{1}, row, plane}) {
    from = cells;
    for (std::size_t n = step; n + step < cells.size(); ++n)
      cells[n] = both(cells[n], both(from[n - step], from[n + step]));
  }
  std::vector<std::uint32_t> out(blocks_.size());
  for (std::size_t b = 0; b < out.size(); ++b) out[b] = cells[cellOf(at[b])];
  return out;
}

void PieceFinder::piecesOfSlots(std::vector<std::uint32_t>& out) const {
  assert(is_current_);
  out.assign(keys_.size(), kNoPiece);
  for (const Block& block : blocks_) {
    const bool is_one = block.groups.size() == 1;
    for (const std::int32_t slot : block.slots) {
      const auto s = static_cast<std::size_t>(slot);
      if (partCount(slot) > 0) out[s] = is_one ? piece_of_group_[block.first_group] : pieceOfSlot(s);
    }
  }
}

}  // namespace kerf
