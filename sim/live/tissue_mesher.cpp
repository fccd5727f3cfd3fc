#include "sim/live/tissue_mesher.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

namespace kerf {
namespace {

constexpr std::array<float, 5> kKernel = {1.0f / 16, 4.0f / 16, 6.0f / 16, 4.0f / 16, 1.0f / 16};
constexpr int kReach = 2;                       // nodes, of the kernel
constexpr int kSide = kBrickSide + 2 * kReach;  // of a brick with the nodes read around it
constexpr float kSlope = 0.375f;                // of a share, a voxel, across a plane border
constexpr int kPlane = kSide * kSide, kCube = kSide * kPlane;

using Cube = std::array<float, kCube>;

constexpr std::size_t cubeIndex(int i, int j, int k) { return static_cast<std::size_t>((i * kSide + j) * kSide + k); }

/// Nodes inside the object as loaded: `labelled` is 1, and `wanted` is 1 for wanted tissues.
struct Shares {
  Cube labelled{}, wanted{};
};

void readShares(const BakedObject& object, const TissueSet& set, const Vec3i& brick, Shares& out) {
  const Vec3i low = brick * kBrickSide - Vec3i::Constant(kReach);
  for (int n = 0; n < 27; ++n) {
    const Vec3i at = brick + Vec3i{n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1};
    const std::int32_t number = object.directory().find(at);
    if (number < 0) continue;
    const BakedObject::Slot& slot = object.slots()[static_cast<std::size_t>(number)];
    const Vec3i first = (at * kBrickSide).cwiseMax(low);
    const Vec3i last = (at * kBrickSide + Vec3i::Constant(kBrickSide)).cwiseMin(low + Vec3i::Constant(kSide));
    for (int i = first[0]; i < last[0]; ++i)
      for (int j = first[1]; j < last[1]; ++j)
        for (int k = first[2]; k < last[2]; ++k) {
          const int offset = nodeOffset(i, j, k);
          if (slot.phi[offset] > 0) continue;
          const std::size_t place = cubeIndex(i - low[0], j - low[1], k - low[2]);
          out.labelled[place] = 1;
          if (set[slot.materials[offset]]) out.wanted[place] = 1;
        }
  }
}

// Along one axis; valid where the kernel stays within the cube.
void smoothAlong(int step, Cube& values) {
  static thread_local Cube before;
  before = values;
  for (int n = kReach * step; n < kCube - kReach * step; ++n) {
    float sum = 0;
    for (int k = -kReach; k <= kReach; ++k)
      sum += kKernel[static_cast<std::size_t>(k + kReach)] * before[static_cast<std::size_t>(n + k * step)];
    values[static_cast<std::size_t>(n)] = sum;
  }
}

void smooth(Cube& values) {
  for (const int step : {1, kSide, kPlane}) smoothAlong(step, values);
}

BrickValues constant(float value) {
  BrickValues out;
  out.fill(value);
  return out;
}

}  // namespace

TissueField::Around TissueField::around(const Vec3i& brick) const {
  if (!object_.directory().contains(brick)) return Around::kOther;
  bool has_wanted = false, has_other = false;
  object_.directory().forEachAround(brick, [&](std::int32_t number, const Vec3i&) {
    const BakedObject::Slot& slot = object_.slots()[static_cast<std::size_t>(number)];
    const bool is_one = slot.has_one_material;
    has_wanted |= !is_one || wanted_[slot.materials[0]];
    has_other |= !is_one || !wanted_[slot.materials[0]];
  });
  return has_wanted && has_other ? Around::kBoth : has_wanted ? Around::kWanted : Around::kOther;
}

BrickValues TissueField::brick(const Vec3i& at, const BrickValues& phi) const {
  const auto voxel = static_cast<float>(object_.voxel());
  const Around kind = around(at);
  if (kind == Around::kWanted) return phi;
  if (kind == Around::kOther) return constant(voxel);

  static thread_local Shares shares;
  shares = {};
  readShares(object_, wanted_, at, shares);
  smooth(shares.labelled);
  smooth(shares.wanted);

  BrickValues out;
  for (int i = 0; i < kBrickSide; ++i)
    for (int j = 0; j < kBrickSide; ++j)
      for (int k = 0; k < kBrickSide; ++k) {
        const std::size_t place = cubeIndex(i + kReach, j + kReach, k + kReach);
        const auto node = static_cast<std::size_t>(nodeOffset(i, j, k));
        out[node] = phi[node];
        if (shares.labelled[place] <= 0) continue;  // far outside
        const float share = shares.wanted[place] / shares.labelled[place];
        out[node] = std::max(phi[node], (0.5f - share) / kSlope * voxel);
      }
  return out;
}

BrickField TissueField::of(const BrickField& field) const {
  const std::vector<Vec3i> interior = field.interiorBricks();
  struct Made {
    Around kind = Around::kOther;
    BrickValues values;
  };
  std::vector<Made> made(field.brickCount() + interior.size());
  const BrickValues inside = constant(field.interior());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, made.size(), 64), [&](const auto& range) {
    for (std::size_t n = range.begin(); n != range.end(); ++n) {
      const bool is_stored = n < field.brickCount();
      const Vec3i& at = is_stored ? field.brickCoord(n) : interior[n - field.brickCount()];
      made[n].kind = around(at);
      if (made[n].kind == Around::kBoth || (is_stored && made[n].kind == Around::kWanted))
        made[n].values = brick(at, is_stored ? field.brick(n) : inside);
    }
  });

  BrickField out(field.voxel(), field.background(), field.interior());
  out.reserve(field.brickCount());
  for (std::size_t n = 0; n < made.size(); ++n) {
    const bool is_stored = n < field.brickCount();
    const Vec3i& at = is_stored ? field.brickCoord(n) : interior[n - field.brickCount()];
    if (made[n].kind == Around::kBoth || (is_stored && made[n].kind == Around::kWanted))
      out.add(at, made[n].values);
    else if (made[n].kind == Around::kWanted)
      out.markInterior(at);
  }
  return out;
}

TissueMesher::TissueMesher(const BakedObject& object, const TissueSet& wanted, const BrickField& begin,
                           const RemesherOptions& options)
    : tissues_(object, wanted),
      begin_(tissues_.of(begin)),
      remesher_(begin_, options),
      known_(begin.voxel(), begin.background(), begin.interior()) {}

std::vector<MeshChunkPtr> TissueMesher::update(const BrickField& changed) {
  std::vector<BrickEdit> edits;
  for (std::size_t b = 0; b < changed.brickCount(); ++b) {
    const Vec3i& at = changed.brickCoord(b);
    const BrickValues* const before = known_.valuesAt(at);
    if (before && *before == changed.brick(b)) continue;
    known_.brick(known_.touch(at)) = changed.brick(b);
    edits.push_back({at, tissues_.brick(at, changed.brick(b))});
  }
  remesher_.apply(edits);
  std::vector<MeshChunkPtr> out = remesher_.changedSince(told_);
  told_ = remesher_.version();
  return out;
}

}  // namespace kerf
