#include "preprocess/print/pockets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <span>

#include "preprocess/print/columns.h"
#include "preprocess/voxelize/voxelize.h"

namespace kerf {
namespace {

using internal::ColumnGrid;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kNone = ~0u;

struct Run {
  double low, high;  // along the direction, frame coordinates
  std::uint32_t line;
};

// The runs of air of all lines, from line 0 up; those of a line from low to high.
struct Air {
  std::vector<Run> runs;
  std::vector<std::uint32_t> first;  // runs of line c: first[c] .. first[c + 1]
};

struct Crossing {
  double z;
  std::uint32_t line;
  bool enters;
};

Expected<Air> airOf(const Mesh& solid, const ColumnGrid& grid, double floor, const Progress& progress) {
  std::vector<Crossing> met;
  if (!grid.eachCrossing(solid, progress, [&](std::size_t line, double z, bool enters) {
        met.push_back({z, static_cast<std::uint32_t>(line), enters});
      }))
    return cancelled();
  // Solids that touch leave no air between them: entering comes first.
  std::sort(met.begin(), met.end(), [](const Crossing& a, const Crossing& b) {
    return a.line != b.line ? a.line < b.line : a.z != b.z ? a.z < b.z : a.enters && !b.enters;
  });
  Air out;
  out.first.reserve(grid.count() + 1);
  std::size_t at = 0;
  for (std::uint32_t line = 0; line < grid.count(); ++line) {
    out.first.push_back(static_cast<std::uint32_t>(out.runs.size()));
    double begin = floor;
    int depth = 0;
    for (; at < met.size() && met[at].line == line; ++at) {
      const int before = depth;
      depth += met[at].enters ? 1 : -1;
      if (before <= 0 && depth > 0 && met[at].z > begin) out.runs.push_back({begin, met[at].z, line});
      if (before > 0 && depth <= 0) begin = std::max(floor, met[at].z);
    }
    if (depth != 0) return internal::openAt(grid, line, met[at - 1].z);
    out.runs.push_back({begin, kInfinity, line});
  }
  out.first.push_back(static_cast<std::uint32_t>(out.runs.size()));
  return out;
}

// Calls with(run) for the runs of the four neighbouring lines that share at least `overlap` of height with run `r`.
template <class With>
void eachNeighbour(const ColumnGrid& grid, const Air& air, std::uint32_t r, double overlap, const With& with) {
  const Run& run = air.runs[r];
  const auto nx = static_cast<std::uint32_t>(grid.nx());
  const std::uint32_t i = run.line % nx, j = run.line / nx;
  const auto visit = [&](std::uint32_t line) {
    const auto end = air.runs.begin() + air.first[line + 1];
    auto other = std::lower_bound(air.runs.begin() + air.first[line], end, run.low,
                                  [](const Run& a, double low) { return a.high <= low; });
    for (; other != end && other->low < run.high; ++other)
      if (std::min(run.high, other->high) - std::max(run.low, other->low) >= overlap)
        with(static_cast<std::uint32_t>(other - air.runs.begin()));
  };
  if (i > 0) visit(run.line - 1);
  if (i + 1 < nx) visit(run.line + 1);
  if (j > 0) visit(run.line - nx);
  if (j + 1 < static_cast<std::uint32_t>(grid.ny())) visit(run.line + nx);
}

// Level up to which the air of each run is filled, and the run of the rim that it spills over. Heights are measured
// against gravity: `up` is 1 for gravity against the direction, -1 for gravity along it.
struct Flood {
  double up;
  std::vector<double> level;
  std::vector<std::uint32_t> rim;

  double bottom(const Run& run) const { return up > 0 ? run.low : -run.high; }
  double top(const Run& run) const { return up > 0 ? run.high : -run.low; }
  // Height of the filled part of a run.
  double filled(const Air& air, std::uint32_t r) const {
    const Run& run = air.runs[r];
    const double to = std::min(level[r], top(run));
    return to > bottom(run) ? to - bottom(run) : 0;
  }
};

std::optional<Flood> flood(const ColumnGrid& grid, const Air& air, double up, double overlap,
                           const Progress& progress) {
  Flood out{up, std::vector<double>(air.runs.size(), kInfinity), std::vector<std::uint32_t>(air.runs.size(), kNone)};
  using Item = std::pair<double, std::uint32_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
  const auto reach = [&](std::uint32_t r, double level, std::uint32_t rim) {
    out.level[r] = level;
    out.rim[r] = rim;
    open.push({level, r});
  };
  const auto nx = static_cast<std::uint32_t>(grid.nx());
  for (std::uint32_t r = 0; r < air.runs.size(); ++r) {
    const std::uint32_t i = air.runs[r].line % nx, j = air.runs[r].line / nx;
    if (i == 0 || j == 0 || i + 1 == nx || j + 1 == static_cast<std::uint32_t>(grid.ny()))
      reach(r, out.bottom(air.runs[r]), r);
  }
  for (std::size_t done = 0; !open.empty(); ++done) {
    if (done % 65536 == 0 &&
        !report(progress, static_cast<double>(done) / static_cast<double>(air.runs.size()), "flooding"))
      return {};
    const auto [level, r] = open.top();
    open.pop();
    eachNeighbour(grid, air, r, overlap, [&](std::uint32_t other) {
      if (out.rim[other] != kNone) return;
      const double bottom = out.bottom(air.runs[other]);
      reach(other, std::max(bottom, level), bottom > level ? other : out.rim[r]);
    });
  }
  return out;
}

// Groups of runs, for a union-find with the smallest member as root.
struct Groups {
  std::vector<std::uint32_t> parent;
  explicit Groups(std::size_t n) : parent(n) { std::iota(parent.begin(), parent.end(), 0u); }
  std::uint32_t root(std::uint32_t r) {
    while (parent[r] != r) r = parent[r] = parent[parent[r]];
    return r;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    if (a != b) parent[std::max(a, b)] = std::min(a, b);
  }
};

// The filled parts of the runs in `of`, a connected group, as one pocket.
Pocket pocketOf(const ColumnGrid& grid, const Air& air, const Flood& flood, std::span<const std::uint32_t> of,
                PocketKind kind, const PocketOptions& options, double floor) {
  Pocket out;
  out.kind = kind;
  const double cell = grid.voxel() * grid.voxel();
  double deepest = kInfinity, highest = -kInfinity;
  std::uint32_t line = kNone;
  for (const std::uint32_t r : of) {
    const Run& run = air.runs[r];
    const double height = flood.filled(air, r), bottom = flood.bottom(run);
    out.volume_mm3 += cell * height;
    if (run.line != line) out.area_mm2 += cell;
    line = run.line;
    for (const double h : {bottom, bottom + height}) out.box.add(grid.place(run.line, flood.up * h));
    deepest = std::min(deepest, bottom);
    highest = std::max(highest, bottom + height);
    out.is_closed_by_plate |= kind == PocketKind::kSealed && options.on_plate && run.low == floor;
  }
  out.box.grow(grid.voxel() / 2);
  out.depth_mm = highest - deepest;
  if (kind != PocketKind::kSealed) {
    const std::uint32_t rim = flood.rim[of.front()];
    out.spill = grid.place(air.runs[rim].line, flood.up * flood.level[of.front()]);
  }

  Vec3d sum = Vec3d::Zero();
  double count = 0;
  const auto isDeep = [&](std::uint32_t r) { return flood.bottom(air.runs[r]) <= deepest + options.layer_mm; };
  for (const std::uint32_t r : of)
    if (isDeep(r)) sum += grid.place(air.runs[r].line, flood.up * flood.bottom(air.runs[r])), ++count;
  double nearest = kInfinity;
  for (const std::uint32_t r : of) {
    if (!isDeep(r)) continue;
    const Vec3d p = grid.place(air.runs[r].line, flood.up * flood.bottom(air.runs[r]));
    if (const double d = (p - sum / count).squaredNorm(); d < nearest) nearest = d, out.deepest = p;
  }
  return out;
}

// The pockets of a flood: `kind`, or the sealed ones alone.
void collect(const ColumnGrid& grid, const Air& air, const Flood& flood, PocketKind kind, const PocketOptions& options,
             double floor, Pockets& out) {
  const bool sealed = kind == PocketKind::kSealed;
  const auto isOf = [&](std::uint32_t r) {
    return (flood.level[r] == kInfinity) == sealed && flood.filled(air, r) > 0;
  };
  Groups groups(air.runs.size());
  for (std::uint32_t r = 0; r < air.runs.size(); ++r) {
    if (!isOf(r)) continue;
    eachNeighbour(grid, air, r, options.layer_mm, [&](std::uint32_t other) {
      const double meet = std::max(flood.bottom(air.runs[r]), flood.bottom(air.runs[other]));
      if (isOf(other) && meet < flood.level[r] && meet < flood.level[other]) groups.join(r, other);
    });
  }
  std::vector<std::uint32_t> members;
  for (std::uint32_t r = 0; r < air.runs.size(); ++r)
    if (isOf(r)) members.push_back(r), groups.parent[r] = groups.root(r);
  std::stable_sort(members.begin(), members.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return groups.parent[a] < groups.parent[b]; });
  std::vector<Pocket> found;
  for (std::size_t begin = 0, end = 0; begin < members.size(); begin = end) {
    while (end < members.size() && groups.parent[members[end]] == groups.parent[members[begin]]) ++end;
    Pocket pocket = pocketOf(grid, air, flood, std::span(members).subspan(begin, end - begin), kind, options, floor);
    if (pocket.volume_mm3 >= options.least_mm3) {
      found.push_back(std::move(pocket));
    } else {
      ++out.small;
      out.small_mm3 += pocket.volume_mm3;
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Pocket& a, const Pocket& b) { return a.volume_mm3 > b.volume_mm3; });
  out.pockets.insert(out.pockets.end(), found.begin(), found.end());
}

Expected<double> passageOf(const PocketOptions& options) {
  KERF_CHECK(internal::checkAxis(options.direction, "print direction"));
  KERF_CHECK(checkVoxelSize(options.voxel_mm));
  if (!(options.layer_mm > 0 && options.layer_mm <= 1))
    return fail({.place = "layer", .found = fmt::format("{:g} mm", options.layer_mm), .expected = "0 to 1 mm"});
  if (!(options.least_mm3 >= 0))
    return fail(
        {.place = "least pocket", .found = fmt::format("{:g} mm3", options.least_mm3), .expected = "0 or more"});
  const double passage = std::hypot(std::sqrt(2.0) * options.voxel_mm, options.layer_mm);
  if (!(passage <= options.narrowest_mm))
    return fail({.place = "voxel size",
                 .found = fmt::format("{:g} mm: could close a hole of {:.2f} mm", options.voxel_mm, passage),
                 .expected = fmt::format("holes of {:g} mm stay open", options.narrowest_mm),
                 .hint = fmt::format("{:.2g} mm", 0.65 * options.narrowest_mm)});
  return passage;
}

}  // namespace

Expected<Pockets> findPockets(const Mesh& solid, const PocketOptions& options, const Progress& progress) {
  KERF_TRY(passage, passageOf(options));
  KERF_TRY(grid, ColumnGrid::around(solid, options.direction, options.voxel_mm));
  if (!(signedVolume(solid) > 0))
    return fail({.code = Error::Code::kGeometry,
                 .found = fmt::format("a volume of {:.3g} mm3", signedVolume(solid)),
                 .expected = "a closed solid, turned outwards"});
  const double floor = options.on_plate ? grid.box().min[2] + options.layer_mm : -kInfinity;
  KERF_TRY(air, airOf(solid, grid, floor, partOf(progress, 0, 0.4)));
  const auto pools = flood(grid, air, -1, options.layer_mm, partOf(progress, 0.4, 0.65));
  if (!pools) return cancelled();
  const auto cups = flood(grid, air, 1, options.layer_mm, partOf(progress, 0.65, 0.9));
  if (!cups || !report(progress, 0.9, "pockets")) return cancelled();
  Pockets out;
  out.passage_mm = passage;
  collect(grid, air, *pools, PocketKind::kSealed, options, floor, out);
  collect(grid, air, *pools, PocketKind::kPool, options, floor, out);
  collect(grid, air, *cups, PocketKind::kCup, options, floor, out);
  return out;
}

std::string describe(const Pocket& pocket) {
  constexpr const char* kNames[] = {"sealed cavity", "pool", "cup"};
  return fmt::format("{} of {:.1f} mm3, {:.1f} mm deep, deepest at ({:.1f}, {:.1f}, {:.1f}){}",
                     kNames[static_cast<int>(pocket.kind)], pocket.volume_mm3, pocket.depth_mm, pocket.deepest[0],
                     pocket.deepest[1], pocket.deepest[2], pocket.is_closed_by_plate ? ", closed by the plate" : "");
}

}  // namespace kerf
