#include "preprocess/volume/slot_grid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>

namespace kerf::internal {
namespace {

// Voxels of one slot that follow each other along z.
struct Run {
  int begin, end;
  Slot slot;
};

// The runs of one line along z; run r has the number first + r.
struct Row {
  std::vector<Run> runs;
  std::uint32_t first = 0;
};

// Union-find over runs.
class Pieces {
 public:
  std::uint32_t count() const { return static_cast<std::uint32_t>(parent_.size()); }
  void add(Slot slot) {
    parent_.push_back(count());
    slot_of_.push_back(slot);
  }

  // Joins the runs of two neighbouring lines that touch.
  void join(const Row& row, const Row& other) {
    std::size_t a = 0, b = 0;
    while (a < row.runs.size() && b < other.runs.size()) {
      const Run &x = row.runs[a], &y = other.runs[b];
      if (x.slot == y.slot && x.begin < y.end && y.begin < x.end) {
        const std::uint32_t p = root(row.first + static_cast<std::uint32_t>(a));
        const std::uint32_t q = root(other.first + static_cast<std::uint32_t>(b));
        parent_[std::max(p, q)] = std::min(p, q);
      }
      if (x.end < y.end)
        ++a;
      else
        ++b;
    }
  }

  std::vector<std::uint32_t> perSlot(std::size_t slots) const {
    std::vector<std::uint32_t> count(slots, 0);
    for (std::uint32_t r = 0; r < parent_.size(); ++r)
      if (parent_[r] == r) ++count[slot_of_[r]];
    return count;
  }

 private:
  std::uint32_t root(std::uint32_t r) {
    while (parent_[r] != r) r = parent_[r] = parent_[parent_[r]];
    return r;
  }

  std::vector<std::uint32_t> parent_;
  std::vector<Slot> slot_of_;
};

// The runs of tissue in `n` voxels.
void readRow(const Slot* s, int n, Row& row, Pieces& pieces) {
  row.runs.clear();
  row.first = pieces.count();
  for (int k = 0; k < n;) {
    int end = k + 1;
    while (end < n && s[end] == s[k]) ++end;
    if (s[k]) {
      row.runs.push_back({k, end, s[k]});
      pieces.add(s[k]);
    }
    k = end;
  }
}

}  // namespace

SlotSurvey surveySlots(const LabelVolume& volume, std::span<const Slot> slot_of, std::size_t slots) {
  SlotSurvey survey{std::vector<std::uint64_t>(slots, 0), Vec3i::Constant(std::numeric_limits<int>::max()),
                    Vec3i::Constant(-1)};
  for (std::size_t k = 0; k < volume.slices.size(); ++k) {
    const LabelVolume::Slice& slice = volume.slices[k];
    for (std::size_t j = 0; j < slice.rows.size(); ++j) {
      const LabelVolume::Row& row = slice.rows[j];
      int first = -1, last = -1;
      for (int i = row.begin; i < row.end; ++i)
        if (const Slot s = slot_of[slice.labels[row.first + static_cast<std::uint64_t>(i - row.begin)]]) {
          ++survey.voxels[s];
          if (first < 0) first = i;
          last = i;
        }
      if (first >= 0) {
        survey.low = survey.low.cwiseMin(Vec3i{first, static_cast<int>(j), static_cast<int>(k)});
        survey.high = survey.high.cwiseMax(Vec3i{last, static_cast<int>(j), static_cast<int>(k)});
      }
    }
  }
  return survey;
}

void fillSlots(const LabelVolume& volume, std::span<const Slot> slot_of, SlotGrid& grid) {
  const Vec3i n = grid.nodes();
  const Vec3i low = grid.corner.cwiseMax(0);
  const Vec3i high = (grid.corner + n).cwiseMin(Vec3i{volume.size[0], volume.size[1], volume.size[2]});
  grid.slot.assign(static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]), 0);
  tbb::parallel_for(low[0], high[0], [&](int i) {
    for (int j = low[1]; j < high[1]; ++j)
      for (int k = low[2]; k < high[2]; ++k)
        grid.slot[grid.offset(i - grid.corner[0], j - grid.corner[1], k - grid.corner[2])] =
            slot_of[volume.at(i, j, k)];
  });
}

std::vector<std::uint32_t> countPieces(const SlotGrid& grid, std::size_t slots) {
  const Vec3i n = grid.nodes();
  Pieces pieces;
  std::vector<Row> before(static_cast<std::size_t>(n[1])), now(static_cast<std::size_t>(n[1]));
  for (int i = 0; i < n[0]; ++i) {
    for (int j = 0; j < n[1]; ++j) {
      const auto y = static_cast<std::size_t>(j);
      readRow(grid.slot.data() + grid.offset(i, j, 0), n[2], now[y], pieces);
      if (j > 0) pieces.join(now[y], now[y - 1]);
      if (i > 0) pieces.join(now[y], before[y]);
    }
    std::swap(before, now);
  }
  return pieces.perSlot(slots);
}

}  // namespace kerf::internal
