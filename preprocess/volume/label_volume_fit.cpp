// fitVolumes(): weights such that smoothed labels keep their volumes.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "preprocess/volume/label_memberships.h"

namespace kerf::internal {
namespace {

constexpr int kMostRounds = 12;
constexpr double kLeastWeight = 0.2, kMostWeight = 5;
constexpr int kSpan = kBrickSide + 1;  // nodes along the cells of a brick
constexpr auto kSpanNodes = static_cast<std::size_t>(kSpan * kSpan * kSpan);

// Content of the cells of one brick.
struct Share {
  std::vector<Slot> slots;
  std::vector<std::uint32_t> samples, shared;  // per slot: volume; cells it shares with others
};

// The brick and its neighbours on the upper sides, in which its last cells end.
struct Neighbours {
  std::array<std::int32_t, 8> found{};  // as in Memberships::index
  bool is_uniform = true;               // one slot fills them all
};

Neighbours neighboursOf(const Memberships& memberships, const Vec3i& at, std::vector<Slot>& slots) {
  Neighbours out;
  std::array<char, kMostSlots> seen{};
  for (int c = 0; c < 8; ++c) {
    const std::int32_t f = memberships.find(at + Vec3i{c >> 2, c >> 1 & 1, c & 1});
    out.found[static_cast<std::size_t>(c)] = f;
    out.is_uniform = out.is_uniform && f < 0 && f == out.found[0];
    if (f < 0)
      seen[static_cast<std::size_t>(-1 - f)] = 1;
    else
      for (const Slot s : memberships.mixed[static_cast<std::size_t>(f)].slots) seen[s] = 1;
  }
  for (std::size_t s = 0; s < seen.size(); ++s)
    if (seen[s]) slots.push_back(static_cast<Slot>(s));
  return out;
}

// Weighted memberships at the nodes of a brick's cells, and which slot wins each.
struct Scores {
  std::vector<float> score;        // per node and slot
  std::vector<std::uint8_t> wins;  // per node: index into the slots
};

Scores scoresOf(const Memberships& memberships, const Neighbours& around, const std::vector<Slot>& slots) {
  const std::size_t n = slots.size();
  Scores scores{std::vector<float>(kSpanNodes * n, 0.0f), std::vector<std::uint8_t>(kSpanNodes)};
  std::size_t out = 0;
  for (int i = 0; i < kSpan; ++i)
    for (int j = 0; j < kSpan; ++j)
      for (int k = 0; k < kSpan; ++k, ++out) {
        const std::int32_t f = around.found[static_cast<std::size_t>((i >> 3) * 4 + (j >> 3) * 2 + (k >> 3))];
        float* v = &scores.score[out * n];
        if (f < 0) {
          for (std::size_t s = 0; s < n; ++s) v[s] = slots[s] == -1 - f ? 1.0f : 0.0f;
        } else {
          const Memberships::Brick& brick = memberships.mixed[static_cast<std::size_t>(f)];
          std::size_t s = 0;
          for (std::size_t q = 0; q < brick.slots.size(); ++q) {
            while (slots[s] != brick.slots[q]) ++s;
            v[s] = brick.value[q * kBrickNodes + static_cast<std::size_t>(nodeOffset(i, j, k))];
          }
        }

        std::size_t best = 0;
        for (std::size_t s = 0; s < n; ++s) {
          v[s] *= memberships.weight[slots[s]];
          if (v[s] > v[best]) best = s;
        }
        scores.wins[out] = static_cast<std::uint8_t>(best);
      }
  return scores;
}

// Start of a cell's samples, as a share of their distance. It varies from cell to cell: otherwise a wall along the grid
// would hit or miss a whole layer of samples at once. Plastic-number offsets spread evenly over neighbouring cells.
float sampleStart(int u, int v, int w) {
  const double s = 0.8191725134 * u + 0.6710436067 * v + 0.5497004779 * w;
  return static_cast<float>(s - std::floor(s));
}

// Counts the samples of a cell that several slots share. @param node  its corners.   @param lead  one per slot,
// scratch.
void sampleCell(const Vec3i& cell, const std::array<std::size_t, 8>& node, const Scores& scores,
                std::vector<float>& lead, Share& share) {
  const std::size_t n = share.slots.size();
  for (std::size_t s = 0; s < n; ++s)
    share.shared[s] += std::any_of(node.begin(), node.end(), [&](std::size_t c) { return scores.wins[c] == s; });

  const float first_x = sampleStart(cell[0], cell[1], cell[2]), first_y = sampleStart(cell[1], cell[2], cell[0]),
              first_z = sampleStart(cell[2], cell[0], cell[1]);
  for (int sub = 0; sub < static_cast<int>(kCellSamples); ++sub) {
    const float x = (static_cast<float>(sub / 9) + first_x) / kSubSamples,
                y = (static_cast<float>(sub / 3 % 3) + first_y) / kSubSamples,
                z = (static_cast<float>(sub % 3) + first_z) / kSubSamples;
    std::fill(lead.begin(), lead.end(), 0.0f);
    for (std::size_t c = 0; c < 8; ++c) {
      const float w = (c & 4 ? x : 1 - x) * (c & 2 ? y : 1 - y) * (c & 1 ? z : 1 - z);
      const float* v = &scores.score[node[c] * n];
      for (std::size_t s = 0; s < n; ++s) lead[s] += w * v[s];
    }
    ++share.samples[static_cast<std::size_t>(std::max_element(lead.begin(), lead.end()) - lead.begin())];
  }
}

// If one slot wins all nodes of a cell, the cell belongs to it wholly (a weighted mean of eight leads is a lead).
// Samples the other cells.
Share measureBrick(const Memberships& memberships, const Vec3i& at) {
  Share share;
  const Neighbours around = neighboursOf(memberships, at, share.slots);
  const std::size_t n = share.slots.size();
  share.samples.assign(n, 0);
  share.shared.assign(n, 0);
  if (around.is_uniform) {
    share.samples[0] = static_cast<std::uint32_t>(kBrickNodes * kCellSamples);
    return share;
  }

  const Scores scores = scoresOf(memberships, around, share.slots);
  std::vector<float> lead(n);
  for (int i = 0; i < kBrickSide; ++i)
    for (int j = 0; j < kBrickSide; ++j)
      for (int k = 0; k < kBrickSide; ++k) {
        std::array<std::size_t, 8> node{};
        bool is_uniform = true;
        for (std::size_t c = 0; c < 8; ++c) {
          node[c] = static_cast<std::size_t>(
              ((i + static_cast<int>(c >> 2)) * kSpan + j + static_cast<int>(c >> 1 & 1)) * kSpan + k +
              static_cast<int>(c & 1));
          is_uniform = is_uniform && scores.wins[node[c]] == scores.wins[node[0]];
        }

        if (is_uniform)
          share.samples[scores.wins[node[0]]] += static_cast<std::uint32_t>(kCellSamples);
        else
          sampleCell(at * kBrickSide + Vec3i{i, j, k}, node, scores, lead, share);
      }
  return share;
}

// Volume of every slot's region, in samples, and in how many cells it meets others.
struct Tally {
  std::vector<std::uint64_t> samples, shared_cells;
  double cells(std::size_t s) const { return static_cast<double>(samples[s]) / static_cast<double>(kCellSamples); }
};

Tally measure(const Memberships& memberships) {
  // Bricks at -1 too: their last cells end in the first bricks.
  const Vec3i all = memberships.bricks + Vec3i::Ones();
  const auto count =
      static_cast<std::size_t>(all[0]) * static_cast<std::size_t>(all[1]) * static_cast<std::size_t>(all[2]);
  std::vector<Share> shares(count);
  tbb::parallel_for(std::size_t{0}, count,
                    [&](std::size_t b) { shares[b] = measureBrick(memberships, brickPlace(b, all) - Vec3i::Ones()); });

  const std::size_t slots = memberships.slots();
  Tally tally{std::vector<std::uint64_t>(slots, 0), std::vector<std::uint64_t>(slots, 0)};
  for (const Share& share : shares)
    for (std::size_t s = 0; s < share.slots.size(); ++s) {
      tally.samples[share.slots[s]] += share.samples[s];
      tally.shared_cells[share.slots[s]] += share.shared[s];
    }
  return tally;
}

bool isWithin(const Tally& tally, const std::vector<std::uint64_t>& voxels, double tolerance) {
  for (std::size_t s = 1; s < voxels.size(); ++s) {
    const auto wanted = static_cast<double>(voxels[s]);
    if (!(std::abs(tally.cells(s) - wanted) <= tolerance * wanted)) return false;
  }
  return true;
}

}  // namespace

bool fitVolumes(Memberships& memberships, double sigma, const std::vector<std::uint64_t>& voxels, double tolerance,
                const Progress& progress, std::vector<std::uint64_t>& samples) {
  const std::size_t n = memberships.slots();
  std::vector<double> slope(n, 0), last_weight(n, 1), last_volume(n, 0);
  for (int round = 0;; ++round) {
    if (!report(progress, 0.5 + 0.45 * round / kMostRounds, "keeping volumes")) return false;
    const Tally tally = measure(memberships);
    samples = tally.samples;
    if (isWithin(tally, voxels, tolerance) || round == kMostRounds) return true;

    for (std::size_t s = 1; s < n; ++s) {
      float& weight = memberships.weight[s];
      const double now = tally.cells(s);
      const double missing = static_cast<double>(voxels[s]) - now;
      const double moved = weight - last_weight[s];

      // How fast the volume grows with the weight. On a wall memberships are a half, and a lead of one is a distance of
      // sigma sqrt(pi / 2) voxels; one cell in two or so along the wall counts as area.
      const double guess =
          0.5 * 0.6 * std::max(1.0, static_cast<double>(tally.shared_cells[s])) * std::max(0.4, sigma) * 1.25;
      slope[s] = guess;
      if (round > 0 && std::abs(moved) > 1e-6) {
        const double secant = (now - last_volume[s]) / moved;
        slope[s] = std::clamp(secant, 0.3 * guess, 3 * guess);  // neighbours move as well: do not trust it blindly
      }

      last_weight[s] = weight;
      last_volume[s] = now;
      const double step = std::clamp(missing / slope[s], -0.25, 0.25);
      weight = static_cast<float>(std::clamp(weight + step, kLeastWeight, kMostWeight));
    }
  }
}

}  // namespace kerf::internal
