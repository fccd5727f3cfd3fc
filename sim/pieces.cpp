#include "sim/pieces.h"

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
  std::sort(keys_.begin(), keys_.end());
  sorted_ = keys_.size();
  const std::size_t count = keys_.size();

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
    if (detail_of_[s] == kFull && touchesOutside(slot)) detailOf(slot), measureFringe(slot);
  }
}

std::int32_t PieceFinder::slotOf(const Vec3i& brick) const {
  const std::uint64_t key = coordKey(brick);
  const auto end = keys_.begin() + static_cast<std::ptrdiff_t>(sorted_);
  const auto it = std::lower_bound(keys_.begin(), end, key);
  if (it != end && *it == key) return static_cast<std::int32_t>(it - keys_.begin());
  const auto later = later_.find(key);
  return later == later_.end() ? kNoSlot : later->second;
}

std::int32_t PieceFinder::addSlot(const Vec3i& brick) {
  const auto slot = static_cast<std::int32_t>(keys_.size());
  keys_.push_back(coordKey(brick));
  later_.emplace(coordKey(brick), slot);
  detail_of_.push_back(kOutside);
  std::array<std::int32_t, 6>& mine = neighbours_.emplace_back();
  for (std::size_t side = 0; side < 6; ++side) {
    mine[side] = slotOf(brick + kSteps[side]);
    if (mine[side] != kNoSlot) neighbours_[static_cast<std::size_t>(mine[side])][side ^ 1] = slot;
  }
  return slot;
}

PieceFinder::Detail& PieceFinder::detailOf(std::int32_t slot) {
  std::int32_t& index = detail_of_[static_cast<std::size_t>(slot)];
  if (index < 0) {
    const bool is_full = index == kFull;
    index = static_cast<std::int32_t>(details_.size());
    Detail& made = details_.emplace_back();
    if (is_full) {
      made.bits.fill(kAll), made.faces.fill(kAll);
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
  out.parts.clear(), out.label.clear();
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
          if (next != c) grown[i] = next, is_growing = true;
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
        seen |= grown[i], left[i] &= ~grown[i];
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

// Books the gap between the surface and the cubes around inside nodes. Reads the values and masks of the neighbours.
// @pre the slot has a detail.
void PieceFinder::measureFringe(std::int32_t slot) {
  const auto s = static_cast<std::size_t>(slot);
  Detail& d = details_[static_cast<std::size_t>(detail_of_[s])];
  for (Part& part : d.parts) part.measure.fringe = 0;
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
    forEachBit(c & ~kept, [&](int n) { bookNode(static_cast<int>(64 * i) + n); });
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

const PieceList& PieceFinder::find() {
  if (is_current_) return list_;
  const std::size_t slots = keys_.size();
  first_part_.resize(slots + 1);
  first_part_[0] = 0;
  for (std::size_t s = 0; s < slots; ++s) first_part_[s + 1] = first_part_[s] + partCount(static_cast<std::int32_t>(s));

  // Union-find; a tree's root is its smallest part, so that roots do not depend on the order of unions.
  std::vector<std::uint32_t> parent(first_part_[slots]);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto rootOf = [&](std::uint32_t p) {
    while (parent[p] != p) p = parent[p] = parent[parent[p]];
    return p;
  };
  for (std::size_t s = 0; s < slots; ++s) {
    if (first_part_[s] == first_part_[s + 1]) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int32_t next = neighbours_[s][static_cast<std::size_t>(2 * axis + 1)];
      if (next == kNoSlot) continue;
      joinBricks(static_cast<std::int32_t>(s), next, axis, [&](std::uint32_t a, std::uint32_t b) {
        const std::uint32_t pa = first_part_[s] + a, pb = first_part_[static_cast<std::size_t>(next)] + b;
        if (parent[pa] == parent[pb]) return;  // joined already, as most are
        const std::uint32_t ra = rootOf(pa), rb = rootOf(pb);
        if (ra != rb) parent[std::max(ra, rb)] = std::min(ra, rb);
      });
    }
  }

  struct Found {
    SolidMeasure measure;
    Vec3i low = Vec3i::Constant(std::numeric_limits<int>::max()),
          high = Vec3i::Constant(std::numeric_limits<int>::min());
    std::uint64_t first = kAll;
  };
  std::vector<Found> found;
  piece_of_part_.resize(parent.size());
  list_ = {};
  for (std::size_t s = 0; s < slots; ++s) {
    if (first_part_[s] == first_part_[s + 1]) continue;
    const Vec3i base = coordOf(keys_[s]) * kBrickSide;
    const std::int32_t index = detail_of_[s];
    for (std::uint32_t p = first_part_[s]; p < first_part_[s + 1]; ++p) {
      const std::uint32_t root = rootOf(p);
      if (root == p)
        piece_of_part_[p] = static_cast<std::uint32_t>(found.size()), found.emplace_back();
      else
        piece_of_part_[p] = piece_of_part_[root];
      Found& f = found[piece_of_part_[p]];
      if (index == kFull) {
        f.measure.nodes += kBrickNodes;
        f.low = f.low.cwiseMin(base), f.high = f.high.cwiseMax(base + Vec3i::Constant(kBrickSide - 1));
        f.first = std::min(f.first, coordKey(base));
        continue;
      }
      const Part& part = details_[static_cast<std::size_t>(index)].parts[p - first_part_[s]];
      f.measure.add(part.measure);
      f.low = f.low.cwiseMin(base + Vec3i{part.low[0], part.low[1], part.low[2]});
      f.high = f.high.cwiseMax(base + Vec3i{part.high[0], part.high[1], part.high[2]});
      f.first = std::min(f.first, coordKey(Vec3i(base + Vec3i{part.first >> 6, part.first >> 3 & 7, part.first & 7})));
    }
  }

  const double h = field_.voxel();
  std::vector<Piece> all(found.size());
  for (std::size_t n = 0; n < found.size(); ++n) {
    all[n].id = static_cast<std::uint32_t>(n);  // numbered anew once they are sorted
    all[n].measure = found[n].measure, all[n].volume = found[n].measure.volume(h);
    all[n].bounds.add(h * found[n].low.cast<double>()), all[n].bounds.add(h * found[n].high.cast<double>());
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
  for (std::uint32_t& p : piece_of_part_) p = renamed[p];
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
  return piece_of_part_[first_part_[static_cast<std::size_t>(slot)] + partAt(slot, offset)];
}

void PieceFinder::piecesIn(const Vec3i& brick, std::span<std::uint32_t, kBrickNodes> out) const {
  assert(is_current_);
  const std::int32_t slot = slotOf(brick);
  if (slot == kNoSlot || partCount(slot) == 0) return std::fill(out.begin(), out.end(), kNoPiece);
  const std::uint32_t* const piece = piece_of_part_.data() + first_part_[static_cast<std::size_t>(slot)];
  const std::int32_t index = detail_of_[static_cast<std::size_t>(slot)];
  if (index < 0) return std::fill(out.begin(), out.end(), *piece);
  const Detail& d = details_[static_cast<std::size_t>(index)];
  for (std::size_t n = 0; n < out.size(); ++n)
    out[n] = d.bits[n >> 6] >> (n & 63) & 1 ? piece[d.label.empty() ? 0 : d.label[n]] : kNoPiece;
}

std::uint32_t PieceFinder::pieceOfSlot(std::size_t s) const {
  std::uint32_t piece = kNoPiece;
  for (std::uint32_t p = first_part_[s]; p < first_part_[s + 1]; ++p) {
    if (piece != kNoPiece && piece != piece_of_part_[p]) return kSeveralPieces;
    piece = piece_of_part_[p];
  }
  return piece;
}

std::uint32_t PieceFinder::pieceOfBrick(const Vec3i& brick) const {
  assert(is_current_);
  const std::int32_t slot = slotOf(brick);
  return slot == kNoSlot ? kNoPiece : pieceOfSlot(static_cast<std::size_t>(slot));
}

bool PieceFinder::hasOthersWithin(const Vec3i& brick, int reach, std::uint32_t piece) const {
  assert(is_current_ && reach <= kBrickSide);
  const Vec3i low = brick * kBrickSide - Vec3i::Constant(reach);
  const Vec3i high = brick * kBrickSide + Vec3i::Constant(kBrickSide - 1 + reach);
  for (int n = 0; n < 27; ++n) {
    const Vec3i c = brick + Vec3i{n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1};
    const std::int32_t slot = slotOf(c);
    if (slot == kNoSlot) continue;
    const auto s = static_cast<std::size_t>(slot);
    const std::int32_t index = detail_of_[s];
    for (std::uint32_t p = first_part_[s]; p < first_part_[s + 1]; ++p) {
      if (piece_of_part_[p] == piece) continue;
      if (index < 0) return true;
      const Part& part = details_[static_cast<std::size_t>(index)].parts[p - first_part_[s]];
      const Vec3i base = c * kBrickSide;
      const Vec3i part_low = base + Vec3i{part.low[0], part.low[1], part.low[2]};
      const Vec3i part_high = base + Vec3i{part.high[0], part.high[1], part.high[2]};
      if ((part_low.array() <= high.array()).all() && (part_high.array() >= low.array()).all()) return true;
    }
  }
  return false;
}

std::vector<PieceFinder::InsideBrick> PieceFinder::insideBricks() const {
  assert(is_current_);
  std::vector<InsideBrick> out;
  for (std::size_t s = 0; s < keys_.size(); ++s)
    if (partCount(static_cast<std::int32_t>(s)) > 0) out.push_back({coordOf(keys_[s]), pieceOfSlot(s)});
  return out;
}

}  // namespace kerf
