#include "preprocess/volume/label_surface.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "geometry/field/marching_cubes.h"

namespace kerf {
namespace {

constexpr double kMostSigma = 4;  // voxels
constexpr double kReach = 3;      // of the kernel, in standard deviations
constexpr int kSubSamples = 3;    // per axis of a cell that several labels share
constexpr std::uint64_t kCellSamples = kSubSamples * kSubSamples * kSubSamples;
constexpr int kMostRounds = 12;
constexpr float kOwnLead = 0.02f;  // of a voxel's own label at its centre, before the weights
// Where a label is one voxel thick, the lead at its voxel against that of the others at the voxels on both sides: 1
// puts the walls half-way, but then a voxel that stands out by chance makes a bump as large as itself.
constexpr float kThinLead = 0.6f;
constexpr double kLeastWeight = 0.2, kMostWeight = 5;

using Slot = std::uint8_t;  // 0: the rest; 1 + index: a tissue label
constexpr std::size_t kMostTissues = 250;

struct Brick {
  std::vector<Slot> slots;   // that have membership in it, rising
  std::vector<float> value;  // kBrickNodes per slot, order of nodeOffset()

  float at(Slot slot, int node) const {
    for (std::size_t s = 0; s < slots.size(); ++s)
      if (slots[s] == slot) return value[s * kBrickNodes + static_cast<std::size_t>(node)];
    return 0;
  }
};

// One kernel per axis: 2 reach + 1 weights that sum to 1.
struct Kernel {
  int reach = 1;
  std::vector<float> weight;
};

Kernel gaussian(double sigma) {
  Kernel k;
  k.reach = std::max(1, static_cast<int>(std::ceil(kReach * sigma)));
  std::vector<double> w;
  for (int i = -k.reach; i <= k.reach; ++i) w.push_back(sigma > 0 ? std::exp(-0.5 * i * i / (sigma * sigma)) : i == 0);
  const double sum = std::accumulate(w.begin(), w.end(), 0.0);
  for (const double v : w) k.weight.push_back(static_cast<float>(v / sum));
  return k;
}

// The slots of all voxels in the box of the asked labels, with a margin of rest around; z fastest, whole bricks.
struct SlotGrid {
  Vec3i bricks = Vec3i::Zero();
  Vec3i corner = Vec3i::Zero();  // node 0 in voxels of the volume
  std::vector<Slot> slot;

  Vec3i nodes() const { return bricks * kBrickSide; }
  Slot at(int i, int j, int k) const {
    const Vec3i n = nodes();
    if (i < 0 || j < 0 || k < 0 || i >= n[0] || j >= n[1] || k >= n[2]) return 0;
    return slot[(static_cast<std::size_t>(i) * static_cast<std::size_t>(n[1]) + static_cast<std::size_t>(j)) *
                    static_cast<std::size_t>(n[2]) +
                static_cast<std::size_t>(k)];
  }
};

// Pieces of every slot, joined through faces: union-find over runs along z.
std::vector<std::uint32_t> countPieces(const SlotGrid& grid, std::size_t slots) {
  struct Run {
    int begin, end;
    Slot slot;
  };
  const Vec3i n = grid.nodes();
  std::vector<std::uint32_t> parent;
  std::vector<Slot> slot_of;
  const auto root = [&](std::uint32_t r) {
    while (parent[r] != r) r = parent[r] = parent[parent[r]];
    return r;
  };
  struct Row {
    std::vector<Run> runs;
    std::uint32_t first = 0;
  };
  std::vector<Row> before(static_cast<std::size_t>(n[1])), now(static_cast<std::size_t>(n[1]));
  for (int i = 0; i < n[0]; ++i) {
    for (int j = 0; j < n[1]; ++j) {
      Row& row = now[static_cast<std::size_t>(j)];
      row.runs.clear();
      row.first = static_cast<std::uint32_t>(parent.size());
      const Slot* s = grid.slot.data() +
                      (static_cast<std::size_t>(i) * static_cast<std::size_t>(n[1]) + static_cast<std::size_t>(j)) *
                          static_cast<std::size_t>(n[2]);
      for (int k = 0; k < n[2];) {
        int end = k + 1;
        while (end < n[2] && s[end] == s[k]) ++end;
        if (s[k]) {
          row.runs.push_back({k, end, s[k]});
          parent.push_back(static_cast<std::uint32_t>(parent.size()));
          slot_of.push_back(s[k]);
        }
        k = end;
      }
      const auto join = [&](const Row& other) {
        std::size_t a = 0, b = 0;
        while (a < row.runs.size() && b < other.runs.size()) {
          const Run &x = row.runs[a], &y = other.runs[b];
          if (x.slot == y.slot && x.begin < y.end && y.begin < x.end) {
            const std::uint32_t p = root(row.first + static_cast<std::uint32_t>(a)),
                                q = root(other.first + static_cast<std::uint32_t>(b));
            parent[std::max(p, q)] = std::min(p, q);
          }
          if (x.end < y.end)
            ++a;
          else
            ++b;
        }
      };
      if (j > 0) join(now[static_cast<std::size_t>(j) - 1]);
      if (i > 0) join(before[static_cast<std::size_t>(j)]);
    }
    std::swap(before, now);
  }
  std::vector<std::uint32_t> count(slots, 0);
  for (std::uint32_t r = 0; r < parent.size(); ++r)
    if (parent[r] == r) ++count[slot_of[r]];
  return count;
}

}  // namespace

struct SmoothLabels::Data {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // mm per node
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Identity();
  Vec3d origin = Vec3d::Zero();  // of node 0, mm
  double sigma = 0;              // voxels, the smallest of the axes: for the scale of surface()
  Vec3i bricks = Vec3i::Zero();
  std::vector<std::int32_t> index;  // per brick place: into `mixed`, or -1 - slot where one slot fills the brick
  std::vector<Brick> mixed;
  std::vector<Vec3i> place;  // of the mixed bricks
  std::vector<std::uint16_t> label;
  std::vector<float> weight;  // per slot, 1 for the rest
  std::vector<LabelVolumeReport> reports;

  // What stands at a brick place; beyond the grid: the rest.
  std::int32_t find(const Vec3i& b) const {
    if ((b.array() < 0).any() || (b.array() >= bricks.array()).any()) return -1;
    return index[(static_cast<std::size_t>(b[0]) * static_cast<std::size_t>(bricks[1]) +
                  static_cast<std::size_t>(b[1])) *
                     static_cast<std::size_t>(bricks[2]) +
                 static_cast<std::size_t>(b[2])];
  }
  float membership(const Vec3i& node, Slot slot) const {
    const std::int32_t b = find(brickOf(node));
    if (b < 0) return -1 - b == slot ? 1.0f : 0.0f;
    return mixed[static_cast<std::size_t>(b)].at(slot, nodeOffset(node[0], node[1], node[2]));
  }
  // Largest membership of the slots other than `own`, minus that of `own`.
  float leadOfOthers(const Vec3i& node, Slot own) const {
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
  // Slot with the largest weighted membership in a mixed brick's node.
  Slot winner(const Brick& brick, std::size_t node) const {
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

  void blur(const SlotGrid& grid, const std::array<Kernel, 3>& kernel);
  void keepThin(const SlotGrid& grid);
  struct Tally {
    std::vector<std::uint64_t> samples, shared_cells;
  };
  Tally measure() const;
  bool fit(const std::vector<std::uint64_t>& voxels, double tolerance, const Progress& progress,
           std::vector<std::uint64_t>& samples);
};

void SmoothLabels::Data::blur(const SlotGrid& grid, const std::array<Kernel, 3>& kernel) {
  const Vec3i reach{kernel[0].reach, kernel[1].reach, kernel[2].reach};
  const Vec3i span = Vec3i::Constant(kBrickSide) + 2 * reach;
  std::vector<std::uint8_t> is_mixed(index.size(), 0);
  const auto placeOf = [&](std::size_t b) {
    const auto y = static_cast<std::size_t>(bricks[1]), z = static_cast<std::size_t>(bricks[2]);
    return Vec3i{static_cast<int>(b / z / y), static_cast<int>(b / z % y), static_cast<int>(b % z)};
  };
  const auto gather = [&](const Vec3i& at, std::vector<Slot>& out) {
    out.clear();
    const Vec3i first = at * kBrickSide - reach;
    for (int i = 0; i < span[0]; ++i)
      for (int j = 0; j < span[1]; ++j)
        for (int k = 0; k < span[2]; ++k) out.push_back(grid.at(first[0] + i, first[1] + j, first[2] + k));
  };
  tbb::parallel_for(std::size_t{0}, index.size(), [&](std::size_t b) {
    const Vec3i at = placeOf(b), first = at * kBrickSide - reach;
    const Slot slot = grid.at(at[0] * kBrickSide, at[1] * kBrickSide, at[2] * kBrickSide);
    for (int i = 0; i < span[0]; ++i)
      for (int j = 0; j < span[1]; ++j)
        for (int k = 0; k < span[2]; ++k)
          if (grid.at(first[0] + i, first[1] + j, first[2] + k) != slot) {
            is_mixed[b] = 1;
            return;
          }
    index[b] = -1 - slot;
  });
  for (std::size_t b = 0; b < index.size(); ++b)
    if (is_mixed[b]) {
      index[b] = static_cast<std::int32_t>(place.size());
      place.push_back(placeOf(b));
    }
  mixed.resize(place.size());
  tbb::parallel_for(std::size_t{0}, mixed.size(), [&](std::size_t m) {
    std::vector<Slot> around;
    gather(place[m], around);
    std::vector<char> seen(256, 0);
    for (const Slot s : around) seen[s] = 1;
    Brick& brick = mixed[m];
    for (std::size_t s = 0; s < seen.size(); ++s)
      if (seen[s]) brick.slots.push_back(static_cast<Slot>(s));
    brick.value.resize(brick.slots.size() * kBrickNodes);
    const auto ni = static_cast<std::size_t>(span[0]), nj = static_cast<std::size_t>(span[1]),
               nk = static_cast<std::size_t>(span[2]);
    constexpr std::size_t kSide = kBrickSide;
    std::vector<float> along_k(ni * nj * kSide), along_j(ni * kSide * kSide);
    for (std::size_t s = 0; s < brick.slots.size(); ++s) {
      const Slot wanted = brick.slots[s];
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
          brick.value[s * kBrickNodes + i * kSide * kSide + jk] = sum;
        }
    }
  });
}

// Every voxel keeps its label at its centre, and one-voxel walls and canals keep most of their thickness.
void SmoothLabels::Data::keepThin(const SlotGrid& grid) {
  std::vector<std::array<float, kBrickNodes>> lift(mixed.size());
  tbb::parallel_for(std::size_t{0}, mixed.size(), [&](std::size_t m) {
    for (int i = 0; i < kBrickSide; ++i)
      for (int j = 0; j < kBrickSide; ++j)
        for (int k = 0; k < kBrickSide; ++k) {
          const Vec3i node = place[m] * kBrickSide + Vec3i{i, j, k};
          const Slot own = grid.at(node[0], node[1], node[2]);
          const float lead = -leadOfOthers(node, own);
          float wanted = kOwnLead;
          for (int a = 0; a < 3; ++a) {
            const Vec3i low = node - Vec3i::Unit(a), high = node + Vec3i::Unit(a);
            if (grid.at(low[0], low[1], low[2]) == own || grid.at(high[0], high[1], high[2]) == own) continue;
            wanted = std::max(wanted, kThinLead * std::min(leadOfOthers(low, own), leadOfOthers(high, own)));
          }
          lift[m][static_cast<std::size_t>(nodeOffset(i, j, k))] = std::max(0.0f, wanted - lead);
        }
  });
  tbb::parallel_for(std::size_t{0}, mixed.size(), [&](std::size_t m) {
    Brick& brick = mixed[m];
    for (int n = 0; n < kBrickNodes; ++n) {
      const Vec3i node = place[m] * kBrickSide + Vec3i{n >> 6, n >> 3 & 7, n & 7};
      const Slot own = grid.at(node[0], node[1], node[2]);
      for (std::size_t s = 0; s < brick.slots.size(); ++s)
        if (brick.slots[s] == own)
          brick.value[s * kBrickNodes + static_cast<std::size_t>(n)] += lift[m][static_cast<std::size_t>(n)];
    }
  });
}

// Volume of every slot's region, in samples: kCellSamples to a cell between eight nodes. Cells all of whose nodes one
// slot wins belong to it wholly (a weighted mean of eight leads is a lead); the others are sampled.
SmoothLabels::Data::Tally SmoothLabels::Data::measure() const {
  constexpr int kSpan = kBrickSide + 1;
  struct Part {
    std::vector<Slot> slots;
    std::vector<std::uint32_t> samples, shared;
  };
  // Bricks at -1 too: their last cells end in the first bricks.
  const Vec3i all = bricks + Vec3i::Ones();
  const auto count =
      static_cast<std::size_t>(all[0]) * static_cast<std::size_t>(all[1]) * static_cast<std::size_t>(all[2]);
  std::vector<Part> parts(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t b) {
    const auto y = static_cast<std::size_t>(all[1]), z = static_cast<std::size_t>(all[2]);
    const Vec3i at =
        Vec3i{static_cast<int>(b / z / y), static_cast<int>(b / z % y), static_cast<int>(b % z)} - Vec3i::Ones();
    std::array<std::int32_t, 8> found{};
    std::array<char, 256> seen{};
    bool same = true;
    for (int c = 0; c < 8; ++c) {
      const std::int32_t f = find(at + Vec3i{c >> 2, c >> 1 & 1, c & 1});
      found[static_cast<std::size_t>(c)] = f;
      same = same && f < 0 && f == found[0];
      if (f < 0)
        seen[static_cast<std::size_t>(-1 - f)] = 1;
      else
        for (const Slot s : mixed[static_cast<std::size_t>(f)].slots) seen[s] = 1;
    }
    Part& part = parts[b];
    for (std::size_t s = 0; s < seen.size(); ++s)
      if (seen[s]) part.slots.push_back(static_cast<Slot>(s));
    const std::size_t n = part.slots.size();
    part.samples.assign(n, 0);
    part.shared.assign(n, 0);
    if (same) {
      part.samples[0] = static_cast<std::uint32_t>(kBrickNodes * kCellSamples);
      return;
    }
    std::vector<float> score(static_cast<std::size_t>(kSpan * kSpan * kSpan) * n, 0.0f);
    std::vector<std::uint8_t> wins(static_cast<std::size_t>(kSpan * kSpan * kSpan));
    std::size_t out = 0;
    for (int i = 0; i < kSpan; ++i)
      for (int j = 0; j < kSpan; ++j)
        for (int k = 0; k < kSpan; ++k, ++out) {
          const std::int32_t f = found[static_cast<std::size_t>((i >> 3) * 4 + (j >> 3) * 2 + (k >> 3))];
          float* v = &score[out * n];
          if (f < 0) {
            for (std::size_t s = 0; s < n; ++s) v[s] = part.slots[s] == -1 - f ? 1.0f : 0.0f;
          } else {
            const Brick& brick = mixed[static_cast<std::size_t>(f)];
            std::size_t s = 0;
            for (std::size_t q = 0; q < brick.slots.size(); ++q) {
              while (part.slots[s] != brick.slots[q]) ++s;
              v[s] = brick.value[q * kBrickNodes + static_cast<std::size_t>(nodeOffset(i, j, k))];
            }
          }
          std::size_t best = 0;
          for (std::size_t s = 0; s < n; ++s) {
            v[s] *= weight[part.slots[s]];
            if (v[s] > v[best]) best = s;
          }
          wins[out] = static_cast<std::uint8_t>(best);
        }
    std::vector<float> lead(n);
    for (int i = 0; i < kBrickSide; ++i)
      for (int j = 0; j < kBrickSide; ++j)
        for (int k = 0; k < kBrickSide; ++k) {
          std::array<std::size_t, 8> node{};
          bool uniform = true;
          for (std::size_t c = 0; c < 8; ++c) {
            node[c] = static_cast<std::size_t>(
                ((i + static_cast<int>(c >> 2)) * kSpan + j + static_cast<int>(c >> 1 & 1)) * kSpan + k +
                static_cast<int>(c & 1));
            uniform = uniform && wins[node[c]] == wins[node[0]];
          }
          if (uniform) {
            part.samples[wins[node[0]]] += static_cast<std::uint32_t>(kCellSamples);
            continue;
          }
          for (std::size_t s = 0; s < n; ++s)
            part.shared[s] += std::any_of(node.begin(), node.end(), [&](std::size_t c) { return wins[c] == s; });
          // The samples of a cell keep their distances but start anywhere: else a wall along the grid would hit or miss
          // a whole layer of them at once. Plastic-number offsets spread evenly over neighbouring cells.
          const auto start = [](int u, int v, int w) {
            const double s = 0.8191725134 * u + 0.6710436067 * v + 0.5497004779 * w;
            return static_cast<float>(s - std::floor(s));
          };
          const Vec3i cell = at * kBrickSide + Vec3i{i, j, k};
          const float first_x = start(cell[0], cell[1], cell[2]), first_y = start(cell[1], cell[2], cell[0]),
                      first_z = start(cell[2], cell[0], cell[1]);
          for (int sub = 0; sub < static_cast<int>(kCellSamples); ++sub) {
            const float x = (static_cast<float>(sub / 9) + first_x) / kSubSamples,
                        y2 = (static_cast<float>(sub / 3 % 3) + first_y) / kSubSamples,
                        z2 = (static_cast<float>(sub % 3) + first_z) / kSubSamples;
            std::fill(lead.begin(), lead.end(), 0.0f);
            for (std::size_t c = 0; c < 8; ++c) {
              const float w = (c & 4 ? x : 1 - x) * (c & 2 ? y2 : 1 - y2) * (c & 1 ? z2 : 1 - z2);
              const float* v = &score[node[c] * n];
              for (std::size_t s = 0; s < n; ++s) lead[s] += w * v[s];
            }
            ++part.samples[static_cast<std::size_t>(std::max_element(lead.begin(), lead.end()) - lead.begin())];
          }
        }
  });
  Tally tally{std::vector<std::uint64_t>(label.size(), 0), std::vector<std::uint64_t>(label.size(), 0)};
  for (const Part& part : parts)
    for (std::size_t s = 0; s < part.slots.size(); ++s) {
      tally.samples[part.slots[s]] += part.samples[s];
      tally.shared_cells[part.slots[s]] += part.shared[s];
    }
  return tally;
}

bool SmoothLabels::Data::fit(const std::vector<std::uint64_t>& voxels, double tolerance, const Progress& progress,
                             std::vector<std::uint64_t>& samples) {
  const std::size_t n = label.size();
  std::vector<double> slope(n, 0), last_weight(n, 1), last_volume(n, 0);
  for (int round = 0;; ++round) {
    if (!report(progress, 0.5 + 0.45 * round / kMostRounds, "keeping volumes")) return false;
    const Tally tally = measure();
    samples = tally.samples;
    bool done = true;
    for (std::size_t s = 1; s < n; ++s) {
      const double now = static_cast<double>(tally.samples[s]) / static_cast<double>(kCellSamples);
      done = done && std::abs(now - static_cast<double>(voxels[s])) <= tolerance * static_cast<double>(voxels[s]);
    }
    if (done || round == kMostRounds) return true;
    for (std::size_t s = 1; s < n; ++s) {
      const double now = static_cast<double>(tally.samples[s]) / static_cast<double>(kCellSamples),
                   missing = static_cast<double>(voxels[s]) - now, moved = weight[s] - last_weight[s];
      // On a wall memberships are a half, and a lead of one is a distance of sigma sqrt(pi / 2) voxels; one cell in two
      // or so along the wall counts as area.
      const double guess =
          0.5 * 0.6 * std::max(1.0, static_cast<double>(tally.shared_cells[s])) * std::max(0.4, sigma) * 1.25;
      slope[s] = guess;
      if (round > 0 && std::abs(moved) > 1e-6) {
        const double secant = (now - last_volume[s]) / moved;
        slope[s] = std::clamp(secant, 0.3 * guess, 3 * guess);  // neighbours move as well: do not trust it blindly
      }
      last_weight[s] = weight[s];
      last_volume[s] = now;
      const double step = std::clamp(missing / slope[s], -0.25, 0.25);
      weight[s] = static_cast<float>(std::clamp(weight[s] + step, kLeastWeight, kMostWeight));
    }
  }
}

SmoothLabels::SmoothLabels(std::unique_ptr<const Data> data) : data_(std::move(data)) {}
SmoothLabels::SmoothLabels(SmoothLabels&&) noexcept = default;
SmoothLabels& SmoothLabels::operator=(SmoothLabels&&) noexcept = default;
SmoothLabels::~SmoothLabels() = default;

const std::vector<LabelVolumeReport>& SmoothLabels::reports() const { return data_->reports; }

Expected<SmoothLabels> SmoothLabels::create(const LabelVolume& volume, std::span<const std::uint16_t> tissue_labels,
                                            const SmoothLabelOptions& options, const Progress& progress) {
  const auto refuse = [](std::string place, std::string found, std::string expected) {
    return fail({Error::Code::kBadValue, "", std::move(place), std::move(found), std::move(expected), ""});
  };
  if (tissue_labels.empty() || tissue_labels.size() > kMostTissues)
    return refuse("labels", fmt::format("{} tissue labels", tissue_labels.size()),
                  fmt::format("1 to {}", kMostTissues));
  std::vector<Slot> slot_of(65536, 0);
  auto data = std::make_unique<Data>();
  data->label = {0};
  for (const std::uint16_t l : tissue_labels) {
    if (l == 0) return refuse("labels", "label 0", "labels of tissue: 0 is nothing");
    if (slot_of[l]) return refuse("labels", fmt::format("label {} twice", l), "every label once");
    slot_of[l] = static_cast<Slot>(data->label.size());
    data->label.push_back(l);
  }
  Vec3d sigma = Vec3d::Constant(options.smoothing_voxels);
  if (options.smoothing_mm) sigma = *options.smoothing_mm * volume.spacing.cwiseInverse();
  if (!((sigma.array() >= 0).all() && (sigma.array() <= kMostSigma).all()))
    return refuse("smoothing",
                  options.smoothing_mm ? fmt::format("{} mm, {:.2f} voxels", *options.smoothing_mm, sigma.maxCoeff())
                                       : fmt::format("{} voxels", options.smoothing_voxels),
                  fmt::format("0 to {} voxels", kMostSigma));
  if (!(options.volume_tolerance > 0)) return refuse("volume tolerance", "not above 0", "0.002, say");
  const std::array<Kernel, 3> kernel{gaussian(sigma[0]), gaussian(sigma[1]), gaussian(sigma[2])};

  if (!report(progress, 0.0, "finding labels")) return cancelled();
  const std::size_t slots = data->label.size();
  std::vector<std::uint64_t> voxels(slots, 0);
  Vec3i low = Vec3i::Constant(std::numeric_limits<int>::max()), high = Vec3i::Constant(-1);
  for (int k = 0; k < volume.size[2]; ++k)
    for (int j = 0; j < volume.size[1]; ++j) {
      int first = -1, last = -1;
      for (int i = 0; i < volume.size[0]; ++i)
        if (const Slot s = slot_of[volume.at(i, j, k)]) {
          ++voxels[s];
          if (first < 0) first = i;
          last = i;
        }
      if (first >= 0) {
        low = low.cwiseMin(Vec3i{first, j, k});
        high = high.cwiseMax(Vec3i{last, j, k});
      }
    }
  for (std::size_t s = 1; s < slots; ++s)
    if (voxels[s] == 0) {
      std::string there;
      for (const LabelCount& c : countLabels(volume)) there += fmt::format("{}{}", there.empty() ? "" : ", ", c.label);
      return fail({Error::Code::kEmpty, "", "labels", fmt::format("no voxel of label {}", data->label[s]),
                   "labels that are in the volume: " + there.substr(0, 200), "kerf info lists them"});
    }

  SlotGrid grid;
  const Vec3i margin = Vec3i{kernel[0].reach, kernel[1].reach, kernel[2].reach} + Vec3i::Ones();
  grid.corner = low - margin;
  for (int a = 0; a < 3; ++a) grid.bricks[a] = (high[a] + margin[a] - grid.corner[a]) / kBrickSide + 1;
  const Vec3i n = grid.nodes();
  const double nodes = static_cast<double>(n[0]) * n[1] * n[2];
  // The slots; walls fill a third of the bricks of a head, with two and a bit memberships each.
  const double bytes = nodes * (1 + 4 * 2.3 / 3);
  if (bytes > static_cast<double>(options.max_bytes))
    return fail({Error::Code::kUnsupported, "", "",
                 fmt::format("{} x {} x {} voxels around the labels, {:.1f} GB", n[0], n[1], n[2], bytes / 1e9),
                 fmt::format("at most {:.1f} GB", static_cast<double>(options.max_bytes) / 1e9),
                 "ask for fewer labels, or crop or resample the volume"});
  grid.slot.assign(static_cast<std::size_t>(nodes), 0);
  tbb::parallel_for(std::max(0, grid.corner[0]), std::min(volume.size[0], grid.corner[0] + n[0]), [&](int i) {
    for (int j = std::max(0, grid.corner[1]); j < std::min(volume.size[1], grid.corner[1] + n[1]); ++j)
      for (int k = std::max(0, grid.corner[2]); k < std::min(volume.size[2], grid.corner[2] + n[2]); ++k)
        grid.slot[(static_cast<std::size_t>(i - grid.corner[0]) * static_cast<std::size_t>(n[1]) +
                   static_cast<std::size_t>(j - grid.corner[1])) *
                      static_cast<std::size_t>(n[2]) +
                  static_cast<std::size_t>(k - grid.corner[2])] = slot_of[volume.at(i, j, k)];
  });
  const std::vector<std::uint32_t> pieces = countPieces(grid, slots);

  data->axes = volume.axes();
  data->inverse = data->axes.inverse();
  data->origin = volume.toWorld(grid.corner.cast<double>());
  data->sigma = sigma.minCoeff();
  data->bricks = grid.bricks;
  data->index.resize(static_cast<std::size_t>(n[0] / 8) * static_cast<std::size_t>(n[1] / 8) *
                     static_cast<std::size_t>(n[2] / 8));
  data->weight.assign(slots, 1.0f);
  if (!report(progress, 0.1, "smoothing labels")) return cancelled();
  data->blur(grid, kernel);
  if (!report(progress, 0.4, "keeping thin parts")) return cancelled();
  data->keepThin(grid);
  std::vector<std::uint64_t> samples;
  if (!data->fit(voxels, options.volume_tolerance, progress, samples)) return cancelled();

  if (!report(progress, 0.95, "counting pieces")) return cancelled();
  tbb::parallel_for(std::size_t{0}, data->mixed.size(), [&](std::size_t m) {
    for (int i = 0; i < kBrickNodes; ++i) {
      const Vec3i node = data->place[m] * kBrickSide + Vec3i{i >> 6, i >> 3 & 7, i & 7};
      grid.slot[(static_cast<std::size_t>(node[0]) * static_cast<std::size_t>(n[1]) +
                 static_cast<std::size_t>(node[1])) *
                    static_cast<std::size_t>(n[2]) +
                static_cast<std::size_t>(node[2])] = data->winner(data->mixed[m], static_cast<std::size_t>(i));
    }
  });
  const std::vector<std::uint32_t> pieces_now = countPieces(grid, slots);
  for (std::size_t s = 1; s < slots; ++s) {
    const double v = volume.voxelVolume();
    data->reports.push_back({data->label[s], voxels[s], static_cast<double>(voxels[s]) * v,
                             static_cast<double>(samples[s]) / static_cast<double>(kCellSamples) * v, pieces[s],
                             pieces_now[s]});
  }
  report(progress, 1.0, "labels are smooth");
  return SmoothLabels(std::move(data));
}

Expected<Mesh> SmoothLabels::surface(const Progress& progress) const {
  const Data& d = *data_;
  if (!report(progress, 0.0, "meshing labels")) return cancelled();
  // In voxels, so that marching cubes' limits mean what they say: a lead of one is sigma sqrt(pi / 2) voxels.
  const auto scale = static_cast<float>(std::max(0.4, d.sigma) * std::sqrt(std::acos(-1.0) / 2));
  const auto meshed = [&](float outwards) {
    BrickField field(1.0, 10.0f);
    field.reserve(d.mixed.size());
    for (std::size_t m = 0; m < d.mixed.size(); ++m) {
      const Brick& brick = d.mixed[m];
      BrickValues values;
      for (std::size_t i = 0; i < kBrickNodes; ++i) {
        float tissue = -1, rest = -1;
        for (std::size_t s = 0; s < brick.slots.size(); ++s) {
          const float v = brick.value[s * kBrickNodes + i];
          if (v <= 0) continue;
          float& best = brick.slots[s] == 0 ? rest : tissue;
          best = std::max(best, v * d.weight[brick.slots[s]]);
        }
        values[i] = scale * (rest - tissue) - outwards;
      }
      field.add(d.place[m], values);
    }
    for (std::size_t b = 0; b < d.index.size(); ++b)
      if (d.index[b] < -1) {
        const auto y = static_cast<std::size_t>(d.bricks[1]), z = static_cast<std::size_t>(d.bricks[2]);
        field.markInterior({static_cast<int>(b / z / y), static_cast<int>(b / z % y), static_cast<int>(b % z)});
      }
    MarchingCubesOptions options;
    options.chord_balance = 0;  // could undo the lead of thin walls; the fit keeps the volume
    return marchingCubes(field, options);
  };
  Mesh mesh = meshed(0);
  // Chords cut into sheets of a voxel or two from both sides: the surface is let out until the volume is that of the
  // labels, by some hundredths of a voxel. Never drawn in from where it was, which could break a thin wall.
  constexpr float kMostOutwards = 0.2f;
  constexpr double kTolerance = 0.002;
  double voxels = 0;
  for (const LabelVolumeReport& r : d.reports) voxels += static_cast<double>(r.voxels);
  float outwards = 0;
  for (int round = 0; round < 6 && !mesh.triangles.empty(); ++round) {
    if (!report(progress, 0.3 + 0.1 * round, "meshing labels")) return cancelled();
    const double missing = voxels - signedVolume(mesh);
    const float before = outwards;
    outwards = std::clamp(outwards + static_cast<float>(missing / surfaceArea(mesh)), 0.0f, kMostOutwards);
    if (std::abs(missing) < kTolerance * voxels || outwards == before) break;
    mesh = meshed(outwards);
  }
  if (mesh.triangles.empty())
    return fail({Error::Code::kEmpty, "", "labels", "smoothing left nothing of them", "labels of several voxels",
                 "a smaller smoothing"});
  for (Vec3d& p : mesh.vertices) p = roundedToFloat(Vec3d(d.origin + d.axes * p));
  if (d.axes.determinant() < 0)
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

std::uint16_t SmoothLabels::labelAt(const Vec3d& world_mm) const {
  const Data& d = *data_;
  const Vec3d p = d.inverse * (world_mm - d.origin);
  const Vec3d most = (d.bricks * kBrickSide).cast<double>();
  if (!(p.array() >= 0).all() || !(p.array() < most.array()).all()) return 0;  // the margin is rest; catches NaN
  const Vec3i low = p.array().floor().cast<int>();
  const Vec3d t = p - low.cast<double>();
  std::array<float, 256> score;
  std::array<Slot, 256> present;
  std::size_t count = 0;
  for (int c = 0; c < 8; ++c) {
    const Vec3i node = low + Vec3i{c >> 2, c >> 1 & 1, c & 1};
    const auto w =
        static_cast<float>((c & 4 ? t[0] : 1 - t[0]) * (c & 2 ? t[1] : 1 - t[1]) * (c & 1 ? t[2] : 1 - t[2]));
    if (w <= 0) continue;
    const auto add = [&](Slot slot, float v) {
      if (v <= 0) return;
      std::size_t s = 0;
      while (s < count && present[s] != slot) ++s;
      if (s == count) {
        present[count] = slot;
        score[count++] = 0;
      }
      score[s] += w * v;
    };
    const std::int32_t b = d.find(brickOf(node));
    if (b < 0) {
      add(static_cast<Slot>(-1 - b), 1.0f);
      continue;
    }
    const Brick& brick = d.mixed[static_cast<std::size_t>(b)];
    const auto at = static_cast<std::size_t>(nodeOffset(node[0], node[1], node[2]));
    for (std::size_t s = 0; s < brick.slots.size(); ++s) add(brick.slots[s], brick.value[s * kBrickNodes + at]);
  }
  std::uint16_t best = 0;
  float most_score = -1;
  for (std::size_t s = 0; s < count; ++s) {
    const float v = score[s] * d.weight[present[s]];
    const std::uint16_t l = present[s] == 0 ? std::uint16_t{0} : d.label[present[s]];
    if (v > most_score || (v == most_score && l < best)) {
      best = l;
      most_score = v;
    }
  }
  return best;
}

}  // namespace kerf
