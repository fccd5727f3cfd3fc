#include "sim/object/baked_object.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/object/shell_nodes.h"

namespace kerf {
int shellOfBrick(const BrickNeighborhood& bricks, const std::uint8_t* materials, double voxel,
                 ShellChunk* out) noexcept {
  const double e = kShellHalfWidth * voxel;
  // delta h^3 / (2 h) of the central differences
  const double scale = 15.0 / 16 / e * voxel * voxel / 2;
  return internal::shellNodes(bricks, materials, static_cast<float>(e), static_cast<float>(scale), out);
}

Expected<std::shared_ptr<const BakedObject>> BakedObject::make(BrickField phi0, const MaterialField* materials,
                                                               Material fallback) {
  std::shared_ptr<BakedObject> out(new BakedObject);
  out->phi0_ = std::move(phi0);
  out->fallback_ = fallback;
  const BrickField& field = out->phi0_;
  if (field.isEmpty())
    return fail({Error::Code::kBadValue, "", "distance field", "empty", "a field with a surface", "bake again"});
  out->outside_.fill(field.background());
  out->inside_.fill(field.interior());
  const std::vector<Vec3i> interior = field.interiorBricks();
  Vec3i low = field.brickCoord(0), high = low;
  const auto add = [&](const Vec3i& c) {
    low = low.cwiseMin(c);
    high = high.cwiseMax(c);
  };
  for (std::size_t b = 0; b < field.brickCount(); ++b) add(field.brickCoord(b));
  for (const Vec3i& c : interior) add(c);
  const int air = 1 + static_cast<int>(std::ceil(kAirAround / (8 * field.voxel())));
  out->low_ = low - Vec3i::Constant(air);
  out->size_ = high - low + Vec3i::Constant(1 + 2 * air);
  const double cells = out->size_.cast<double>().prod();
  if (cells > 1 << 26)
    return fail({Error::Code::kBadValue, "", "distance field",
                 fmt::format("a box of {} x {} x {} bricks of {} mm", out->size_[0], out->size_[1], out->size_[2],
                             8 * field.voxel()),
                 "at most 67 million bricks", "larger voxels, or pieces that lie nearer together"});
  out->directory_.assign(static_cast<std::size_t>(cells), -1);
  // Sorted by coordinate: neighbours in space are neighbours in memory, and the order is that of nothing but the
  // object.
  struct Entry {
    std::uint64_t key;
    Vec3i brick;
    int stored;
  };
  std::vector<Entry> entries;
  for (std::size_t b = 0; b < field.brickCount(); ++b)
    entries.push_back({coordKey(field.brickCoord(b)), field.brickCoord(b), static_cast<int>(b)});
  for (const Vec3i& c : interior) entries.push_back({coordKey(c), c, -1});
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.key < b.key; });

  for (std::size_t m = 0; m < 256; ++m) {
    out->uniform_[m] = std::make_unique<std::uint8_t[]>(kBrickNodes);
    std::fill_n(out->uniform_[m].get(), kBrickNodes, static_cast<std::uint8_t>(m));
  }
  std::array<std::uint8_t, kBrickNodes> numbers;
  std::vector<std::int32_t> mixed(entries.size(), -1);
  std::vector<std::uint8_t> uniform(entries.size(), static_cast<std::uint8_t>(fallback));
  for (std::size_t s = 0; materials && s < entries.size(); ++s) {
    bool is_uniform = materials->copyBrick(entries[s].brick, numbers);
    // A node without a label is of the fallback: whatever it is, it can be cut.
    const bool is_none = numbers[0] == 0 && is_uniform;
    if (!is_none) std::replace(numbers.begin(), numbers.end(), std::uint8_t{0}, static_cast<std::uint8_t>(fallback));
    if (is_none) continue;
    if (is_uniform) {
      uniform[s] = numbers[0];
    } else {
      mixed[s] = static_cast<std::int32_t>(out->materials_.size());
      out->materials_.push_back(numbers);
    }
  }
  out->slots_.reserve(entries.size());
  for (std::size_t s = 0; s < entries.size(); ++s) {
    const Vec3i at = entries[s].brick - out->low_;
    out->directory_[static_cast<std::size_t>((at[0] * out->size_[1] + at[1]) * out->size_[2] + at[2])] =
        static_cast<std::int32_t>(s);
    out->slots_.push_back(
        {entries[s].brick,
         entries[s].stored < 0 ? out->inside_.data() : field.brick(static_cast<std::size_t>(entries[s].stored)).data(),
         mixed[s] < 0 ? out->uniform_[uniform[s]].get() : out->materials_[static_cast<std::size_t>(mixed[s])].data(), 0,
         0, mixed[s] < 0, 0});
    Slot& slot = out->slots_.back();
    slot.least = *std::min_element(slot.phi, slot.phi + kBrickNodes);
  }
  const double e = kShellHalfWidth * field.voxel(), cell = std::pow(field.voxel(), 3);
  std::vector<ShellChunk> chunks(kShellChunks);
  const int step[3] = {out->size_[1] * out->size_[2], out->size_[2], 1};
  for (Slot& slot : out->slots_) {
    const Vec3i at = slot.brick - out->low_;
    const int here = (at[0] * out->size_[1] + at[1]) * out->size_[2] + at[2];
    BrickNeighborhood around{slot.phi, {}};
    for (int f = 0; f < 6; ++f) {
      const std::int32_t s = out->directory_[static_cast<std::size_t>(here + (f & 1 ? 1 : -1) * step[f / 2])];
      around.face[f] = s < 0 ? out->outside_.data() : out->slots_[static_cast<std::size_t>(s)].phi;
    }
    slot.shell_begin = static_cast<std::uint32_t>(out->shell_.size());
    slot.shell_count = static_cast<std::uint32_t>(shellOfBrick(around, slot.materials, field.voxel(), chunks.data()));
    out->shell_.insert(out->shell_.end(), chunks.begin(),
                       chunks.begin() + (slot.shell_count + ShellChunk::kNodes - 1) / ShellChunk::kNodes);
    for (int n = 0; n < kBrickNodes; ++n) out->volumes_[slot.materials[n]] += cell * insidePart(slot.phi[n], e);
  }
  return std::shared_ptr<const BakedObject>(std::move(out));
}

}  // namespace kerf
