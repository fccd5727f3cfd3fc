#include "sim/split_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <vector>

namespace kerf {
namespace {

// What the bricks of the object hold: nodes of the wanted piece, of others, or both.
enum Holds : unsigned char { kOwn = 1, kForeign = 2 };

constexpr int kPad = 1;  // a node's neighbours

template <class Visit>
void forEachAround(const Vec3i& brick, const Visit& visit) {
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) visit(Vec3i(brick + Vec3i{x, y, z}));
}

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
  for (int x = first[0]; x <= last[0]; ++x)
    for (int y = first[1]; y <= last[1]; ++y)
      for (int z = first[2]; z <= last[2]; ++z) {
        const Vec3i c{x, y, z}, shift = (c - brick) * kBrickSide;
        const BrickValues* const values = field.valuesAt(c);
        const float constant = field.constantAt(c);
        const std::uint32_t all = pieces.pieceOfBrick(c);
        const Vec3i low = (-shift - Vec3i::Constant(margin)).cwiseMax(0);
        const Vec3i high = (-shift + Vec3i::Constant(kBrickSide - 1 + margin)).cwiseMin(kBrickSide - 1);
        for (int i = low[0]; i <= high[0]; ++i)
          for (int j = low[1]; j <= high[1]; ++j)
            for (int k = low[2]; k <= high[2]; ++k) {
              const std::size_t at = indexOf(i + shift[0], j + shift[1], k + shift[2]);
              value[at] = values ? (*values)[static_cast<std::size_t>(nodeOffset(i, j, k))] : constant;
              if (!(value[at] < 0)) continue;
              const std::uint32_t piece =
                  all == PieceFinder::kSeveralPieces ? pieces.pieceAt(c * kBrickSide + Vec3i{i, j, k}) : all;
              whose[at] = piece == id ? 1 : 2;
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

BrickField splitField(const PieceFinder& pieces, std::uint32_t id) {
  const OverlayField& field = pieces.field();
  const std::vector<Vec3i> inside = pieces.insideBricks();
  std::unordered_map<std::uint64_t, unsigned char> several;  // the few bricks that hold more than one piece
  for (const Vec3i& c : inside) {
    if (pieces.pieceOfBrick(c) != PieceFinder::kSeveralPieces) continue;
    unsigned char& what = several[coordKey(c)];
    for (int n = 0; n < kBrickNodes && what != (kOwn | kForeign); ++n) {
      const std::uint32_t at = pieces.pieceAt(c * kBrickSide + Vec3i{n >> 6, n >> 3 & 7, n & 7});
      if (at != PieceFinder::kNoPiece) what = static_cast<unsigned char>(what | (at == id ? kOwn : kForeign));
    }
  }
  const auto holdsAt = [&](const Vec3i& c) -> unsigned char {
    const std::uint32_t piece = pieces.pieceOfBrick(c);
    if (piece == PieceFinder::kNoPiece) return 0;
    if (piece != PieceFinder::kSeveralPieces) return piece == id ? kOwn : kForeign;
    return several.find(coordKey(c))->second;
  };

  // The piece's own bricks and those around them; of the bricks that are stored as constants only foreign ones change.
  std::vector<std::uint64_t> keys;
  BrickField out(field.voxel(), field.background(), field.interior());
  for (const Vec3i& c : inside) {
    if (!(holdsAt(c) & kOwn)) continue;
    const bool is_constant = !field.valuesAt(c);
    if (is_constant) {
      out.markInterior(c);
      // Deep inside. What a constant brick meets at an edge or corner only is met by one of these six as well.
      bool is_deep = true;
      for (int axis = 0; axis < 3 && is_deep; ++axis)
        for (const int step : {-1, 1}) {
          const Vec3i next = c + step * Vec3i(Vec3i::Unit(axis));
          is_deep = is_deep && pieces.pieceOfBrick(next) == id && !field.valuesAt(next);
        }
      if (is_deep) continue;
    }
    forEachAround(c, [&](const Vec3i& near) {
      if (field.valuesAt(near) || holdsAt(near) == kForeign) keys.push_back(coordKey(near));
    });
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());

  out.reserve(keys.size());
  for (const std::uint64_t key : keys) {
    const auto k = coordOfKey(key);
    const Vec3i c{k[0], k[1], k[2]};
    if (const BrickValues* values = field.valuesAt(c))
      out.add(c, *values);
    else
      out.brick(out.touch(c)).fill(field.constantAt(c));
  }
  // No farther than the bricks around: what lies beyond eight nodes is beyond any band in use.
  const int reach =
      std::clamp(static_cast<int>(std::ceil(double{field.background()} / field.voxel())), 1, kBrickSide - kPad);
  tbb::parallel_for(std::size_t{0}, out.brickCount(), [&](std::size_t b) {
    bool is_near_foreign = false;
    forEachAround(out.brickCoord(b),
                  [&](const Vec3i& near) { is_near_foreign = is_near_foreign || (holdsAt(near) & kForeign) != 0; });
    if (is_near_foreign) separate(pieces, id, out.brickCoord(b), reach, out.brick(b));
  });
  return out;
}

}  // namespace kerf
