#include "preprocess/volume/label_memberships.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kerf::internal {
namespace {

constexpr double kReach = 3;       // of the kernel, in standard deviations
constexpr float kOwnLead = 0.02f;  // of a voxel's own label at its centre, before the weights
// Where a label is one voxel thick, the lead at its voxel against that of the others at the voxels on both sides: 1
// puts the walls half-way, but then a voxel that stands out by chance makes a bump as large as itself.
constexpr float kThinLead = 0.6f;

// A brick with as many nodes around it as the kernels reach.
struct Surrounding {
  Vec3i reach, span;
  explicit Surrounding(const std::array<Kernel, 3>& kernel)
      : reach(kernel[0].reach, kernel[1].reach, kernel[2].reach), span(Vec3i::Constant(kBrickSide) + 2 * reach) {}
  Vec3i first(const Vec3i& brick) const { return brick * kBrickSide - reach; }
};

// Whether slots other than that of the brick's first node are in reach of it.
bool isMixed(const SlotGrid& grid, const Surrounding& around, const Vec3i& brick, Slot slot) {
  const Vec3i first = around.first(brick);
  for (int i = 0; i < around.span[0]; ++i)
    for (int j = 0; j < around.span[1]; ++j)
      for (int k = 0; k < around.span[2]; ++k)
        if (grid.at(first[0] + i, first[1] + j, first[2] + k) != slot) return true;
  return false;
}

// Fills index and place; makes the mixed bricks, empty.
void sortBricks(const SlotGrid& grid, const Surrounding& around, Memberships& out) {
  std::vector<std::uint8_t> is_mixed(out.index.size(), 0);
  tbb::parallel_for(std::size_t{0}, out.index.size(), [&](std::size_t b) {
    const Vec3i at = brickPlace(b, out.bricks);
    const Slot slot = grid.at(at[0] * kBrickSide, at[1] * kBrickSide, at[2] * kBrickSide);
    if (isMixed(grid, around, at, slot))
      is_mixed[b] = 1;
    else
      out.index[b] = -1 - slot;
  });
  for (std::size_t b = 0; b < out.index.size(); ++b)
    if (is_mixed[b]) {
      out.index[b] = static_cast<std::int32_t>(out.place.size());
      out.place.push_back(brickPlace(b, out.bricks));
    }
  out.mixed.resize(out.place.size());
}

// The blurred indicator of one slot in a brick, one axis after the other.
// @param around  slots of the brick and its surrounding.   @param out  kBrickNodes values.
void blurSlot(const std::vector<Slot>& around, const Vec3i& span, Slot wanted, const std::array<Kernel, 3>& kernel,
              std::vector<float>& along_k, std::vector<float>& along_j, float* out) {
  constexpr std::size_t kSide = kBrickSide;
  const auto ni = static_cast<std::size_t>(span[0]), nj = static_cast<std::size_t>(span[1]),
             nk = static_cast<std::size_t>(span[2]);
  for (std::size_t row = 0; row < ni * nj; ++row)
    for (std::size_t k = 0; k < kSide; ++k) {
      float sum = 0;
      for (std::size_t t = 0; t < kernel[2].weight.size(); ++t)
        sum += around[row * nk + k + t] == wanted ? kernel[2].weight[t] : 0.0f;
      along_k[row * kSide + k] = sum;
    }

  for (std::size_t i = 0; i < ni; ++i)
    for (std::size_t j = 0; j < kSide; ++j)
      for (std::size_t k = 0; k < kSide; ++k) {
        float sum = 0;
        for (std::size_t t = 0; t < kernel[1].weight.size(); ++t)
          sum += along_k[(i * nj + j + t) * kSide + k] * kernel[1].weight[t];
        along_j[(i * kSide + j) * kSide + k] = sum;
      }

  for (std::size_t i = 0; i < kSide; ++i)
    for (std::size_t jk = 0; jk < kSide * kSide; ++jk) {
      float sum = 0;
      for (std::size_t t = 0; t < kernel[0].weight.size(); ++t)
        sum += along_j[(i + t) * kSide * kSide + jk] * kernel[0].weight[t];
      out[i * kSide * kSide + jk] = sum;
    }
}

Memberships::Brick blurBrick(const SlotGrid& grid, const Surrounding& surrounding, const Vec3i& place,
                             const std::array<Kernel, 3>& kernel) {
  const Vec3i first = surrounding.first(place), span = surrounding.span;
  std::vector<Slot> around;
  std::vector<char> seen(kMostSlots, 0);
  for (int i = 0; i < span[0]; ++i)
    for (int j = 0; j < span[1]; ++j)
      for (int k = 0; k < span[2]; ++k) {
        around.push_back(grid.at(first[0] + i, first[1] + j, first[2] + k));
        seen[around.back()] = 1;
      }

  Memberships::Brick brick;
  for (std::size_t s = 0; s < seen.size(); ++s)
    if (seen[s]) brick.slots.push_back(static_cast<Slot>(s));
  brick.value.resize(brick.slots.size() * kBrickNodes);

  constexpr std::size_t kSide = kBrickSide;
  const auto ni = static_cast<std::size_t>(span[0]), nj = static_cast<std::size_t>(span[1]);
  std::vector<float> along_k(ni * nj * kSide), along_j(ni * kSide * kSide);
  for (std::size_t s = 0; s < brick.slots.size(); ++s)
    blurSlot(around, span, brick.slots[s], kernel, along_k, along_j, &brick.value[s * kBrickNodes]);
  return brick;
}

}  // namespace

Kernel gaussian(double sigma) {
  Kernel k;
  k.reach = std::max(1, static_cast<int>(std::ceil(kReach * sigma)));
  std::vector<double> w;
  for (int i = -k.reach; i <= k.reach; ++i) w.push_back(sigma > 0 ? std::exp(-0.5 * i * i / (sigma * sigma)) : i == 0);
  const double sum = std::accumulate(w.begin(), w.end(), 0.0);
  for (const double v : w) k.weight.push_back(static_cast<float>(v / sum));
  return k;
}

float Memberships::leadOfOthers(const Vec3i& node, Slot own) const {
  const std::int32_t b = find(brickOf(node));
  if (b < 0) return -1 - b == own ? -1.0f : 1.0f;
  const Brick& brick = mixed[static_cast<std::size_t>(b)];
  const auto at = static_cast<std::size_t>(nodeOffset(node[0], node[1], node[2]));
  float mine = 0, best = 0;
  for (std::size_t s = 0; s < brick.slots.size(); ++s) {
    const float v = brick.value[s * kBrickNodes + at];
    if (brick.slots[s] == own)
      mine = v;
    else
      best = std::max(best, v);
  }
  return best - mine;
}

Slot Memberships::winner(const Brick& brick, std::size_t node) const {
  Slot best = 0;
  float most = -1;
  for (std::size_t s = 0; s < brick.slots.size(); ++s) {
    const float v = brick.value[s * kBrickNodes + node];
    if (v * weight[brick.slots[s]] > most) {
      most = v * weight[brick.slots[s]];
      best = brick.slots[s];
    }
  }
  return best;
}

Memberships blurSlots(const SlotGrid& grid, std::size_t slots, const std::array<Kernel, 3>& kernel) {
  Memberships out;
  out.bricks = grid.bricks;
  out.index.resize(static_cast<std::size_t>(grid.bricks[0]) * static_cast<std::size_t>(grid.bricks[1]) *
                   static_cast<std::size_t>(grid.bricks[2]));
  out.weight.assign(slots, 1.0f);

  const Surrounding around(kernel);
  sortBricks(grid, around, out);
  tbb::parallel_for(std::size_t{0}, out.mixed.size(),
                    [&](std::size_t m) { out.mixed[m] = blurBrick(grid, around, out.place[m], kernel); });
  return out;
}

void keepThin(const SlotGrid& grid, Memberships& memberships) {
  std::vector<std::array<float, kBrickNodes>> lift(memberships.mixed.size());
  tbb::parallel_for(std::size_t{0}, memberships.mixed.size(), [&](std::size_t m) {
    for (int i = 0; i < kBrickSide; ++i)
      for (int j = 0; j < kBrickSide; ++j)
        for (int k = 0; k < kBrickSide; ++k) {
          const Vec3i node = memberships.place[m] * kBrickSide + Vec3i{i, j, k};
          const Slot own = grid.at(node[0], node[1], node[2]);
          const float lead = -memberships.leadOfOthers(node, own);

          float wanted = kOwnLead;
          for (int a = 0; a < 3; ++a) {
            const Vec3i low = node - Vec3i::Unit(a), high = node + Vec3i::Unit(a);
            if (grid.at(low[0], low[1], low[2]) == own || grid.at(high[0], high[1], high[2]) == own) continue;
            wanted = std::max(
                wanted, kThinLead * std::min(memberships.leadOfOthers(low, own), memberships.leadOfOthers(high, own)));
          }

          lift[m][static_cast<std::size_t>(nodeOffset(i, j, k))] = std::max(0.0f, wanted - lead);
        }
  });

  // Only now, because the lifts depend on the original memberships.
  tbb::parallel_for(std::size_t{0}, memberships.mixed.size(), [&](std::size_t m) {
    Memberships::Brick& brick = memberships.mixed[m];
    for (int n = 0; n < kBrickNodes; ++n) {
      const Vec3i node = memberships.place[m] * kBrickSide + Vec3i{n >> 6, n >> 3 & 7, n & 7};
      const Slot own = grid.at(node[0], node[1], node[2]);
      for (std::size_t s = 0; s < brick.slots.size(); ++s)
        if (brick.slots[s] == own)
          brick.value[s * kBrickNodes + static_cast<std::size_t>(n)] += lift[m][static_cast<std::size_t>(n)];
    }
  });
}

}  // namespace kerf::internal
