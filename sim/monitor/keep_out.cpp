#include "sim/monitor/keep_out.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <limits>

#include "sim/monitor/distance_transform.h"

namespace kerf {
namespace {

using internal::DistanceTransform;

constexpr int kApron = kBrickSide + 1;  // nodes along the side of a stored brick
constexpr std::size_t kApronNodes = kApron * kApron * kApron;
// Nodes transformed at a time. A halo around a block is transformed with it, 100 nodes on each side for 5 mm at 0.05
// mm: 71 times the block itself for a side of 64, 17 times for 128.
constexpr int kBlockLog = 7, kBlockSide = 1 << kBlockLog;
constexpr std::int32_t kNothing = -1, kDeep = -2;

using Mask = std::bitset<kBrickNodes>;

// Index of a cell in a box of `size`, z fastest.
std::size_t indexIn(const Vec3i& size, int x, int y, int z) {
  return (static_cast<std::size_t>(x) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(y)) *
             static_cast<std::size_t>(size[2]) +
         static_cast<std::size_t>(z);
}
std::size_t indexIn(const Vec3i& size, const Vec3i& at) { return indexIn(size, at[0], at[1], at[2]); }
std::size_t cellsOf(const Vec3i& size) { return static_cast<std::size_t>(size.cast<std::int64_t>().prod()); }

// Nodes of the structure, by brick.
struct Structure {
  const BakedObject* object = nullptr;
  bool is_solid = false;                   // the whole object: its field is more exact than its nodes
  std::vector<std::int32_t> mask_of_slot;  // -1: none
  std::vector<Mask> masks;
  Vec3i low, high;  // bricks that have some: low <= brick < high

  const Mask* find(const Vec3i& brick) const {
    const std::int32_t slot = object->directory().find(brick);
    const std::int32_t mask = slot < 0 ? -1 : mask_of_slot[static_cast<std::size_t>(slot)];
    return mask < 0 ? nullptr : &masks[static_cast<std::size_t>(mask)];
  }
};

// @param materials  none: all of the object.
Structure collect(const BakedObject& object, std::span<const Material> materials) {
  Structure out;
  out.object = &object;
  out.is_solid = materials.empty();
  out.low = Vec3i::Constant(std::numeric_limits<int>::max());
  out.high = -out.low;
  std::array<bool, 256> wanted;
  wanted.fill(out.is_solid);
  for (const Material m : materials)
    if (static_cast<int>(m) >= 0 && static_cast<int>(m) < 256) wanted[static_cast<std::size_t>(m)] = true;

  out.mask_of_slot.assign(object.slots().size(), -1);
  for (std::size_t s = 0; s < object.slots().size(); ++s) {
    const BakedObject::Slot& slot = object.slots()[s];
    Mask mask;
    for (std::size_t n = 0; n < kBrickNodes; ++n) mask[n] = wanted[slot.materials[n]] && slot.phi[n] <= 0;
    if (mask.none()) continue;
    out.mask_of_slot[s] = static_cast<std::int32_t>(out.masks.size());
    out.masks.push_back(mask);
    out.low = out.low.cwiseMin(slot.brick);
    out.high = out.high.cwiseMax(slot.brick + Vec3i::Ones());
  }
  return out;
}

// Blocks that may hold a node within `reach` voxels of the structure, by the distances between bricks.
std::vector<Vec3i> blocksNear(const Structure& structure, double reach, std::size_t* bricks_near) {
  const int margin = static_cast<int>(std::ceil(reach / kBrickSide)) + 1;
  const Vec3i low = structure.low - Vec3i::Constant(margin),
              size = structure.high - structure.low + Vec3i::Constant(2 * margin);
  std::vector<std::uint8_t> seeds(cellsOf(size), 0);
  for (std::size_t s = 0; s < structure.mask_of_slot.size(); ++s)
    if (structure.mask_of_slot[s] >= 0) seeds[indexIn(size, structure.object->slots()[s].brick - low)] = 1;
  DistanceTransform transform;
  const std::span<const float> squared = transform.run(seeds, size, Vec3i::Zero(), size);

  // Two nodes are at most a brick's diagonal nearer than their bricks' centres.
  const double most = reach / kBrickSide + std::sqrt(3.0);
  std::vector<Vec3i> blocks;
  *bricks_near = 0;
  for (int i = 0; i < size[0]; ++i)
    for (int j = 0; j < size[1]; ++j)
      for (int k = 0; k < size[2]; ++k) {
        if (static_cast<double>(squared[indexIn(size, i, j, k)]) > most * most) continue;
        ++*bricks_near;
        const Vec3i brick = low + Vec3i(i, j, k);
        constexpr int kShift = kBlockLog - kBrickLog;
        blocks.emplace_back(brick[0] >> kShift, brick[1] >> kShift, brick[2] >> kShift);
      }

  const auto before = [](const Vec3i& a, const Vec3i& b) { return coordKey(a) < coordKey(b); };
  std::sort(blocks.begin(), blocks.end(), before);
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  return blocks;
}

struct FieldLimits {
  double voxel, most_distance, most_depth;  // mm
};

// One thread's memory for a block.
struct BlockWork {
  DistanceTransform transform;
  std::vector<std::uint8_t> seeds;
  std::vector<float> field;  // 129^3, mm
};

// The nodes of a box, z fastest: `in` for nodes of the structure, `out` elsewhere.
void markNodes(const Structure& structure, const Vec3i& low, const Vec3i& size, std::uint8_t in, std::uint8_t out,
               std::vector<std::uint8_t>& nodes) {
  nodes.assign(cellsOf(size), out);
  const Vec3i brick_low = brickOf(low).cwiseMax(structure.low);
  const Vec3i brick_high = brickOf(low + size - Vec3i::Ones()).cwiseMin(structure.high - Vec3i::Ones());
  for (int bi = brick_low[0]; bi <= brick_high[0]; ++bi)
    for (int bj = brick_low[1]; bj <= brick_high[1]; ++bj)
      for (int bk = brick_low[2]; bk <= brick_high[2]; ++bk) {
        const Mask* mask = structure.find({bi, bj, bk});
        if (!mask) continue;

        const Vec3i origin = kBrickSide * Vec3i(bi, bj, bk) - low;
        const Vec3i from = (-origin).cwiseMax(0), to = (size - origin).cwiseMin(kBrickSide);
        for (int i = from[0]; i < to[0]; ++i)
          for (int j = from[1]; j < to[1]; ++j)
            for (int k = from[2]; k < to[2]; ++k)
              if ((*mask)[static_cast<std::size_t>(nodeOffset(i, j, k))])
                nodes[indexIn(size, origin[0] + i, origin[1] + j, origin[2] + k)] = in;
      }
}

// In its band the baked field of a solid is the distance itself, also between nodes. Beyond it is a constant.
void takeBand(const Structure& structure, const Vec3i& first, const FieldLimits& limits, std::vector<float>& field) {
  const BakedObject& object = *structure.object;
  constexpr int kOut = kBlockSide + 1;
  const float outside = object.phi0().background(), inside = object.phi0().interior();
  const auto deepest = static_cast<float>(-limits.most_depth), farthest = static_cast<float>(limits.most_distance);
  const Vec3i brick_low = brickOf(first).cwiseMax(object.directoryLow());
  const Vec3i brick_high = brickOf(first + Vec3i::Constant(kBlockSide))
                               .cwiseMin(object.directoryLow() + object.directorySize() - Vec3i::Ones());
  for (int bi = brick_low[0]; bi <= brick_high[0]; ++bi)
    for (int bj = brick_low[1]; bj <= brick_high[1]; ++bj)
      for (int bk = brick_low[2]; bk <= brick_high[2]; ++bk) {
        const BrickValues* const phi = object.phi0().valuesAt({bi, bj, bk});
        if (!phi) continue;

        const Vec3i origin = kBrickSide * Vec3i(bi, bj, bk) - first;
        const Vec3i to = (Vec3i::Constant(kOut) - origin).cwiseMin(kBrickSide);
        for (int i = 0; i < to[0]; ++i)
          for (int j = 0; j < to[1]; ++j)
            for (int k = 0; k < to[2]; ++k) {
              const float value = (*phi)[static_cast<std::size_t>(nodeOffset(i, j, k))];
              if (value >= outside || value <= inside) continue;
              field[static_cast<std::size_t>(((origin[0] + i) * kOut + origin[1] + j) * kOut + origin[2] + k)] =
                  std::clamp(value, deepest, farthest);
            }
      }
}

// Distances at the 65^3 nodes from a block's first.
void transformBlock(const Structure& structure, const Vec3i& block, const FieldLimits& limits, BlockWork& work) {
  const auto nodes = [&limits](double mm) { return static_cast<int>(std::ceil(mm / limits.voxel)) + 2; };
  const auto distance = [&limits](float squared) {
    return (std::sqrt(static_cast<double>(squared)) - 0.5) * limits.voxel;
  };
  const int halo = nodes(limits.most_distance), depth = std::min(nodes(limits.most_depth), halo);
  const Vec3i first = kBlockSide * block;
  constexpr int kOut = kBlockSide + 1;
  work.field.assign(kOut * kOut * kOut, static_cast<float>(limits.most_distance));

  // The block with its halo, clipped to the structure: far from it, often a corner.
  const Vec3i low = (first - Vec3i::Constant(halo)).cwiseMax(kBrickSide * structure.low);
  const Vec3i high = (first + Vec3i::Constant(kOut + halo)).cwiseMin(kBrickSide * structure.high);
  if ((high.array() <= low.array()).any()) return;
  markNodes(structure, low, high - low, 1, 0, work.seeds);
  const std::span<const float> outside =
      work.transform.run(work.seeds, high - low, first - low, first - low + Vec3i::Constant(kOut));
  bool has_inside = false;
  for (std::size_t m = 0; m < outside.size(); ++m) {
    has_inside |= outside[m] == 0;
    work.field[m] = static_cast<float>(std::min(distance(outside[m]), limits.most_distance));
  }

  // The same inside, to the nearest node outside the structure.
  if (has_inside) {
    const Vec3i around = Vec3i::Constant(depth), size = Vec3i::Constant(kOut) + 2 * around;
    markNodes(structure, first - around, size, 0, 1, work.seeds);
    const std::span<const float> inside = work.transform.run(work.seeds, size, around, around + Vec3i::Constant(kOut));
    for (std::size_t m = 0; m < inside.size(); ++m)
      if (inside[m] > 0) work.field[m] = static_cast<float>(-std::min(distance(inside[m]), limits.most_depth));
  }

  if (structure.is_solid) takeBand(structure, first, limits, work.field);
}

Expected<void> checkOptions(const KeepOutOptions& options, double h) {
  // Beyond kMostVoxels a block's surroundings outgrow it, and squares their float.
  if (options.most_distance >= 2 * h && options.most_distance <= KeepOut::kMostVoxels * h &&
      options.most_depth >= 2 * h)
    return {};
  return fail(
      {.code = Error::Code::kBadValue,
       .place = "keep-out distances",
       .found = fmt::format("{} mm outside, {} mm inside", options.most_distance, options.most_depth),
       .expected = fmt::format("{} to {} mm outside, at least {} mm inside", 2 * h, KeepOut::kMostVoxels * h, 2 * h),
       .hint = "another distance"});
}

constexpr int kMostStride = 8;

// The stride to try first: overestimates the memory, so that it is mostly right.
int firstStride(std::size_t bricks_near, std::size_t most_bytes) {
  const double bytes_per_brick = kApronNodes * sizeof(float);
  int stride = 1;
  while (stride < kMostStride && 0.6 * static_cast<double>(bricks_near) * bytes_per_brick / (stride * stride * stride) >
                                     static_cast<double>(most_bytes))
    stride *= 2;
  return stride;
}

}  // namespace

// Makes the field of one structure: of every node, or of every second, fourth or eighth along each axis.
class KeepOut::Builder {
 public:
  Builder(const Structure& structure, const FieldLimits& limits, const std::vector<Vec3i>& blocks)
      : structure_(structure), limits_(limits), blocks_(blocks) {}

  // Null: the field takes more than `most_bytes`.
  Expected<std::shared_ptr<const KeepOut>> build(int stride, std::size_t most_bytes, const Progress& progress) {
    std::shared_ptr<KeepOut> out(new KeepOut);
    layOut(stride, *out);

    // A slice at a time, so that memory stops growing where the limit is, and that it can be cancelled.
    const std::size_t slice = 2 * static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    for (std::size_t begin = 0; begin < blocks_.size(); begin += slice) {
      const double done = static_cast<double>(begin) / static_cast<double>(blocks_.size());
      if (!report(progress, done, "measuring distances")) return cancelled();
      std::vector<Bricks> made(std::min(slice, blocks_.size() - begin));
      tbb::parallel_for(std::size_t{0}, made.size(),
                        [&](std::size_t b) { makeBricks(blocks_[begin + b], stride, *out, made[b]); });
      for (const Bricks& bricks : made) store(bricks, *out);
      if (out->bytes() > most_bytes) return std::shared_ptr<const KeepOut>();
    }
    out->values_.shrink_to_fit();
    return out;
  }

 private:
  // The bricks of a block.
  struct Bricks {
    std::vector<Vec3i> coord;   // of those stored
    std::vector<float> values;  // theirs, kApronNodes each
    std::vector<Vec3i> deep;    // of those that are nothing but deepest
  };

  static int bricksPerBlock(int stride) { return kBlockSide / (kBrickSide * stride); }

  // Spacing, limits and an empty directory.
  void layOut(int stride, KeepOut& out) const {
    out.spacing_ = stride * limits_.voxel;
    out.inverse_ = static_cast<float>(1 / out.spacing_);
    out.far_ = static_cast<float>(limits_.most_distance);
    out.deep_ = static_cast<float>(-limits_.most_depth);

    Vec3i low = blocks_.front(), high = low;
    for (const Vec3i& block : blocks_) {
      low = low.cwiseMin(block);
      high = high.cwiseMax(block);
    }
    out.low_ = bricksPerBlock(stride) * low;
    out.size_ = bricksPerBlock(stride) * (high - low + Vec3i::Ones());
    out.directory_.assign(cellsOf(out.size_), kNothing);
  }

  void makeBricks(const Vec3i& block, int stride, const KeepOut& out, Bricks& made) {
    BlockWork& work = works_.local();
    transformBlock(structure_, block, limits_, work);
    const int per_block = bricksPerBlock(stride);
    std::array<float, kApronNodes> values;
    for (int i = 0; i < per_block; ++i)
      for (int j = 0; j < per_block; ++j)
        for (int k = 0; k < per_block; ++k) {
          takeValues(work.field, kBrickSide * Vec3i(i, j, k), stride, values);
          const auto [least, most] = std::minmax_element(values.begin(), values.end());
          const Vec3i coord = per_block * block + Vec3i(i, j, k);
          if (*least >= out.far_) continue;
          if (*most <= out.deep_) {
            made.deep.push_back(coord);
            continue;
          }
          made.coord.push_back(coord);
          made.values.insert(made.values.end(), values.begin(), values.end());
        }
  }

  // The nodes of one stored brick, out of the field of its block.
  // @param first  of the block's stored nodes.
  static void takeValues(const std::vector<float>& field, const Vec3i& first, int stride,
                         std::array<float, kApronNodes>& values) {
    const Vec3i size = Vec3i::Constant(kBlockSide + 1);
    std::size_t to = 0;
    for (int x = 0; x < kApron; ++x)
      for (int y = 0; y < kApron; ++y)
        for (int z = 0; z < kApron; ++z)
          values[to++] =
              field[indexIn(size, stride * (first[0] + x), stride * (first[1] + y), stride * (first[2] + z))];
  }

  static void store(const Bricks& bricks, KeepOut& out) {
    const auto entry = [&out](const Vec3i& coord) -> std::int32_t& {
      return out.directory_[indexIn(out.size_, coord - out.low_)];
    };
    auto next = static_cast<std::int32_t>(out.values_.size() / kApronNodes);
    for (const Vec3i& coord : bricks.coord) entry(coord) = next++;
    for (const Vec3i& coord : bricks.deep) entry(coord) = kDeep;
    out.values_.insert(out.values_.end(), bricks.values.begin(), bricks.values.end());
  }

  const Structure& structure_;
  const FieldLimits& limits_;
  const std::vector<Vec3i>& blocks_;
  tbb::enumerable_thread_specific<BlockWork> works_;
};

Expected<std::shared_ptr<const KeepOut>> KeepOut::make(const BakedObject& object, std::span<const Material> materials,
                                                       const KeepOutOptions& options, const Progress& progress) {
  if (materials.empty())
    return fail({.code = Error::Code::kNotFound,
                 .place = "keep-out structure",
                 .found = "no material named",
                 .expected = "the materials to keep out of",
                 .hint = "KeepOut::ofSolid for all of an object"});
  return build(object, materials, options, progress);
}

Expected<std::shared_ptr<const KeepOut>> KeepOut::ofSolid(const BakedObject& object, const KeepOutOptions& options,
                                                          const Progress& progress) {
  return build(object, {}, options, progress);
}

Expected<std::shared_ptr<const KeepOut>> KeepOut::build(const BakedObject& object, std::span<const Material> materials,
                                                        const KeepOutOptions& options, const Progress& progress) {
  const double h = object.voxel();
  KERF_CHECK(checkOptions(options, h));
  const Structure structure = collect(object, materials);
  if (structure.masks.empty())
    return fail({.code = Error::Code::kNotFound,
                 .place = "keep-out structure",
                 .found = "no node of these materials",
                 .expected = "a case that has the structure",
                 .hint = "labels for it when the case is baked"});

  const FieldLimits limits{h, options.most_distance, std::min(options.most_depth, options.most_distance)};
  std::size_t bricks_near = 0;
  const std::vector<Vec3i> blocks = blocksNear(structure, limits.most_distance / h + 1, &bricks_near);

  Builder builder(structure, limits, blocks);
  for (int stride = firstStride(bricks_near, options.most_bytes); stride <= kMostStride; stride *= 2) {
    KERF_TRY(field, builder.build(stride, options.most_bytes, progress));
    if (field) return field;
  }
  return fail({.code = Error::Code::kBadValue,
               .place = "keep-out field",
               .found = "more than its memory at every eighth node",
               .expected = fmt::format("at most {} bytes", options.most_bytes),
               .hint = "a shorter distance, or more memory"});
}

float KeepOut::distance(const Vec3f& p) const noexcept {
  const Vec3f u = inverse_ * p - (kBrickSide * low_).cast<float>();
  const Vec3f end = (kBrickSide * size_).cast<float>();
  for (int c = 0; c < 3; ++c)
    if (!(u[c] >= 0 && u[c] < end[c])) return far_;  // not finite, too
  const int i = static_cast<int>(u[0]), j = static_cast<int>(u[1]), k = static_cast<int>(u[2]);
  const std::int32_t brick = directory_[indexIn(size_, i >> kBrickLog, j >> kBrickLog, k >> kBrickLog)];
  if (brick < 0) return brick == kDeep ? deep_ : far_;

  // Trilinear between the eight nodes around.
  const float x = u[0] - static_cast<float>(i), y = u[1] - static_cast<float>(j), z = u[2] - static_cast<float>(k);
  const float* v =
      values_.data() + static_cast<std::size_t>(brick) * kApronNodes + ((i & 7) * kApron + (j & 7)) * kApron + (k & 7);
  const auto along_z = [&](const float* f) { return f[0] + z * (f[1] - f[0]); };
  const auto along_y = [&](const float* f) {
    const float a = along_z(f), b = along_z(f + kApron);
    return a + y * (b - a);
  };
  const float a = along_y(v), b = along_y(v + kApron * kApron);
  return a + x * (b - a);
}

KeepOut::Reading KeepOut::read(const ToolSamples& samples, const Rigid3& T_object_tool) const noexcept {
  const Eigen::Matrix3f rotation = T_object_tool.rotation.toRotationMatrix().cast<float>();
  const Vec3f shift = T_object_tool.translation.cast<float>();
  const auto place = [&](const Vec3f& p) -> Vec3f { return rotation * p + shift; };
  Reading out;
  float best = far_;
  Vec3f where = place(samples.points().front());
  const auto test = [&](const ToolSamples::Group& group) {
    for (int n = group.begin; n < group.end; ++n) {
      const Vec3f p = place(samples.points()[static_cast<std::size_t>(n)]);
      const float d = distance(p);
      if (d < best) {
        best = d;
        where = p;
      }
    }
  };

  // The most promising group first.
  const ToolSamples::Group* first = nullptr;
  float least = std::numeric_limits<float>::infinity();
  for (const ToolSamples::Group& group : samples.groups())
    if (const float bound = distance(place(group.center)) - group.radius; bound < least) {
      least = bound;
      first = &group;
    }
  if (first) test(*first);

  // Then groups that could still be nearer: no sample is nearer than its group's centre less the radius, but for the
  // rounding of a voxel field.
  const auto slack = static_cast<float>(spacing_);
  for (const ToolSamples::Group& group : samples.groups())
    if (&group != first && distance(place(group.center)) - group.radius - slack < best) test(group);

  out.distance = static_cast<double>(best);
  out.point = where.cast<double>();
  out.is_far = best >= far_;
  return out;
}

}  // namespace kerf
