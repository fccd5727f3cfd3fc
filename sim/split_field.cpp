#include "sim/split_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace kerf {
namespace {

// What the bricks of the object hold: nodes of the wanted piece, of others, or both; and what lies around.
enum Holds : unsigned char { kOwn = 1, kForeign = 2, kStored = 4, kNearOwn = 8 };

constexpr int kPad = 1;  // a node's neighbours

// Rewrites one brick near foreign nodes; `out` holds its values of now.
void separate(const PieceFinder& pieces, std::uint32_t id, const Vec3i& brick, int reach, BrickValues& out) {
  const OverlayField& field = pieces.field();
  const float h = static_cast<float>(field.voxel()), background = field.background();
  constexpr float kFar = std::numeric_limits<float>::infinity();
  const Vec3i base = brick * kBrickSide;
  // The nodes within reach of the brick, with a rim: values, and whose they are (0 outside, 1 own, 2 foreign).
  const int span = kBrickSide + 2 * (reach + kPad), margin = reach + kPad;
  const auto indexOf = [&](int i, int j, int k) {
    return static_cast<std::size_t>(((i + margin) * span + j + margin) * span + k + margin);
  };
  std::vector<float> value(static_cast<std::size_t>(span) * static_cast<std::size_t>(span) *
                           static_cast<std::size_t>(span));
  std::vector<unsigned char> whose(value.size(), 0);
  const Vec3i first = brickOf(Vec3i(base - Vec3i::Constant(margin)));
  const Vec3i last = brickOf(Vec3i(base + Vec3i::Constant(kBrickSide - 1 + margin)));
  std::array<std::uint32_t, kBrickNodes> piece_of;
  for (int x = first[0]; x <= last[0]; ++x)
    for (int y = first[1]; y <= last[1]; ++y)
      for (int z = first[2]; z <= last[2]; ++z) {
        const Vec3i c{x, y, z}, shift = (c - brick) * kBrickSide;
        const BrickValues* const values = field.valuesAt(c);
        const float constant = field.constantAt(c);
        pieces.piecesIn(c, piece_of);
        const Vec3i low = (-shift - Vec3i::Constant(margin)).cwiseMax(0);
        const Vec3i high = (-shift + Vec3i::Constant(kBrickSide - 1 + margin)).cwiseMin(kBrickSide - 1);
        for (int i = low[0]; i <= high[0]; ++i)
          for (int j = low[1]; j <= high[1]; ++j)
            for (int k = low[2]; k <= high[2]; ++k) {
              const std::size_t at = indexOf(i + shift[0], j + shift[1], k + shift[2]);
              const auto n = static_cast<std::size_t>(nodeOffset(i, j, k));
              value[at] = values ? (*values)[n] : constant;
              if (value[at] < 0) whose[at] = piece_of[n] == id ? 1 : 2;
            }
      }

  // Distance to each side as the union of balls of radius |phi| about its outermost nodes: |p - a| + phi(a).
  std::array<std::vector<float>, 2> distance{std::vector<float>(kBrickNodes, kFar),
                                             std::vector<float>(kBrickNodes, kFar)};
  // Lengths of steps, a row along z for every (dx, dy): rows are added and compared several nodes at a time.
  const int row = 2 * reach + 1;
  std::vector<float> length(static_cast<std::size_t>(row * row * row));
  for (int x = -reach, n = 0; x <= reach; ++x)
    for (int y = -reach; y <= reach; ++y)
      for (int z = -reach; z <= reach; ++z, ++n)
        length[static_cast<std::size_t>(n)] = h * std::sqrt(static_cast<float>(x * x + y * y + z * z));
  const std::array<std::size_t, 3> stride{static_cast<std::size_t>(span) * static_cast<std::size_t>(span),
                                          static_cast<std::size_t>(span), 1};
  const auto hasNeighbour = [&](std::size_t at, unsigned char wanted) {
    for (const std::size_t s : stride)
      if (whose[at - s] == wanted || whose[at + s] == wanted) return true;
    return false;
  };
  for (int i = -reach; i < kBrickSide + reach; ++i)
    for (int j = -reach; j < kBrickSide + reach; ++j)
      for (int k = -reach; k < kBrickSide + reach; ++k) {
        const std::size_t at = indexOf(i, j, k);
        if (whose[at] == 0 || !hasNeighbour(at, 0)) continue;
        std::vector<float>& to = distance[whose[at] - 1];
        const int z0 = std::max(0, k - reach), z1 = std::min(kBrickSide - 1, k + reach);
        const float v = value[at];
        for (int x = std::max(0, i - reach); x <= std::min(kBrickSide - 1, i + reach); ++x)
          for (int y = std::max(0, j - reach); y <= std::min(kBrickSide - 1, j + reach); ++y) {
            if ((x - i) * (x - i) + (y - j) * (y - j) > reach * reach) continue;  // beyond the band
            float* const d = to.data() + nodeOffset(x, y, 0);
            const float* const step = length.data() + ((x - i + reach) * row + y - j + reach) * row + reach - k;
            for (int z = z0; z <= z1; ++z) d[z] = std::min(d[z], step[z] + v);
          }
      }

  std::size_t n = 0;
  for (int i = 0; i < kBrickSide; ++i)
    for (int j = 0; j < kBrickSide; ++j)
      for (int k = 0; k < kBrickSide; ++k, ++n) {
        const std::size_t at = indexOf(i, j, k);
        const float own = distance[0][n], foreign = distance[1][n];
        if (whose[at] == 1) continue;
        if (whose[at] == 0 && (hasNeighbour(at, 1) || foreign == kFar)) continue;
        // Nearer to this piece: the value stays, unless it must be another's after all (balls miss sharp corners).
        const float distance_to_own = whose[at] == 0 && own <= foreign ? own - 0.5f * h : own;
        out[n] = std::min(background, std::max(std::abs(value[at]), distance_to_own));
      }
}

}  // namespace

PieceBricks bricksOfPiece(const PieceFinder& pieces, std::uint32_t id) {
  const OverlayField& field = pieces.field();
  const std::vector<PieceFinder::InsideBrick> inside = pieces.insideBricks();
  PieceBricks out;
  // One byte for each brick of the object's box and a layer around: a piece has tens of thousands of bricks, and every
  // one asks for its 26 neighbours.
  Vec3i low = Vec3i::Constant(std::numeric_limits<int>::max()), high = -low;
  for (const PieceFinder::InsideBrick& b : inside) low = low.cwiseMin(b.brick), high = high.cwiseMax(b.brick);
  if (inside.empty()) return out;
  low -= Vec3i::Constant(2), high += Vec3i::Constant(2);
  const Vec3i size = high - low + Vec3i::Ones();
  const std::array<std::ptrdiff_t, 3> stride{std::ptrdiff_t{size[1]} * size[2], size[2], 1};
  std::vector<unsigned char> cells(static_cast<std::size_t>(stride[0] * size[0]), 0);
  const auto cellOf = [&](const Vec3i& c) {
    const Vec3i at = c - low;
    return at[0] * stride[0] + at[1] * stride[1] + at[2];
  };
  const auto cell = [&](std::ptrdiff_t at) -> unsigned char& { return cells[static_cast<std::size_t>(at)]; };
  std::array<std::ptrdiff_t, 27> around;
  for (int x = -1, n = 0; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z, ++n)
        around[static_cast<std::size_t>(n)] = x * stride[0] + y * stride[1] + z * stride[2];
  const auto markStored = [&](const BrickField& bricks) {
    for (std::size_t b = 0; b < bricks.brickCount(); ++b) {
      const Vec3i& c = bricks.brickCoord(b);
      if ((c.array() >= low.array()).all() && (c.array() <= high.array()).all()) cell(cellOf(c)) |= kStored;
    }
  };
  markStored(field.baked()), markStored(field.changed());
  for (const PieceFinder::InsideBrick& b : inside) {
    unsigned char what = b.piece == id ? kOwn : kForeign;
    if (b.piece == PieceFinder::kSeveralPieces) {
      what = 0;
      std::array<std::uint32_t, kBrickNodes> piece_of;
      pieces.piecesIn(b.brick, piece_of);
      for (const std::uint32_t piece : piece_of)
        if (piece != PieceFinder::kNoPiece) what = static_cast<unsigned char>(what | (piece == id ? kOwn : kForeign));
    }
    cell(cellOf(b.brick)) |= what;
  }
  for (const PieceFinder::InsideBrick& b : inside) {
    const std::ptrdiff_t at = cellOf(b.brick);
    if (!(cell(at) & kOwn)) continue;
    if (!(cell(at) & kStored)) {
      out.interior.push_back(b.brick);
      // Deep inside. What a constant brick meets at an edge or corner only is met by one of these six as well.
      const auto isDeep = [&](std::ptrdiff_t next) { return (cell(next) & (kOwn | kForeign | kStored)) == kOwn; };
      if (isDeep(at - stride[0]) && isDeep(at + stride[0]) && isDeep(at - stride[1]) && isDeep(at + stride[1]) &&
          isDeep(at - stride[2]) && isDeep(at + stride[2]))
        continue;
    }
    for (const std::ptrdiff_t step : around) cell(at + step) |= kNearOwn;
  }
  // No farther than the bricks around: what lies beyond eight nodes is beyond any band in use.
  const int reach =
      std::clamp(static_cast<int>(std::ceil(double{field.background()} / field.voxel())), 1, kBrickSide - kPad);
  // The piece's own bricks and those around them; of the bricks that are stored as constants only foreign ones change.
  for (int x = low[0]; x <= high[0]; ++x)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int z = low[2]; z <= high[2]; ++z) {
        const Vec3i c{x, y, z};
        const unsigned char what = cell(cellOf(c));
        if (!(what & kNearOwn) || (!(what & kStored) && (what & (kOwn | kForeign)) != kForeign)) continue;
        out.bricks.push_back(c);
        const std::ptrdiff_t at = cellOf(c);
        const bool is_near_foreign =
            std::any_of(around.begin(), around.end(), [&](std::ptrdiff_t step) { return cell(at + step) & kForeign; });
        if (!is_near_foreign || !pieces.hasOthersWithin(c, reach, id)) continue;
        BrickEdit& edit = out.changed.emplace_back();
        edit.brick = c;
        if (const BrickValues* values = field.valuesAt(c))
          edit.phi = *values;
        else
          edit.phi.fill(field.constantAt(c));
      }
  tbb::parallel_for(std::size_t{0}, out.changed.size(),
                    [&](std::size_t n) { separate(pieces, id, out.changed[n].brick, reach, out.changed[n].phi); });
  return out;
}

BrickField splitField(const PieceFinder& pieces, std::uint32_t id) {
  const OverlayField& field = pieces.field();
  const PieceBricks piece = bricksOfPiece(pieces, id);
  BrickField out(field.voxel(), field.background(), field.interior());
  for (const Vec3i& c : piece.interior) out.markInterior(c);
  out.reserve(piece.bricks.size());
  std::size_t next = 0;
  for (const Vec3i& c : piece.bricks) {
    const bool is_changed = next < piece.changed.size() && piece.changed[next].brick == c;
    out.add(c, is_changed ? piece.changed[next++].phi : *field.valuesAt(c));
  }
  return out;
}

}  // namespace kerf
