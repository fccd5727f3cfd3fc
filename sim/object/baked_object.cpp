#include "sim/object/baked_object.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "sim/object/huge_pages.h"
#include "sim/object/node_volumes.h"
#include "sim/object/shell_nodes.h"

namespace kerf {

int shellOfBrick(const BrickNeighborhood& bricks, const std::uint8_t* materials, double voxel,
                 ShellChunk* out) noexcept {
  const double e = kShellHalfWidth * voxel;
  // delta h^3 / (2 h) of the central differences
  const double scale = 15.0 / 16 / e * voxel * voxel / 2;
  return internal::shellNodes(bricks, materials, static_cast<float>(e), static_cast<float>(scale), out);
}

Expected<std::shared_ptr<BakedObject>> BakedObject::start(BrickField phi0, Material fallback) {
  std::shared_ptr<BakedObject> out(new BakedObject);
  out->phi0_ = std::move(phi0);
  out->fallback_ = fallback;
  if (out->phi0_.isEmpty())
    return fail({.code = Error::Code::kBadValue,
                 .place = "distance field",
                 .found = "empty",
                 .expected = "a field with a surface",
                 .hint = "bake again"});

  out->outside_.fill(out->phi0_.background());
  out->inside_.fill(out->phi0_.interior());
  for (std::size_t m = 0; m < 256; ++m) {
    out->uniform_[m] = std::make_unique<std::uint8_t[]>(kBrickNodes);
    std::fill_n(out->uniform_[m].get(), kBrickNodes, static_cast<std::uint8_t>(m));
  }
  KERF_CHECK(out->laySlots());
  return out;
}

Expected<std::shared_ptr<const BakedObject>> BakedObject::make(BrickField phi0, const MaterialField* materials,
                                                               Material fallback) {
  KERF_TRY(out, start(std::move(phi0), fallback));
  if (materials) out->label(*materials);
  out->countShells();
  out->measureVolumes();
  return std::shared_ptr<const BakedObject>(std::move(out));
}

Expected<std::shared_ptr<const BakedObject>> BakedObject::make(BrickField phi0, MaterialField&& materials,
                                                               Material fallback) {
  KERF_TRY(out, start(std::move(phi0), fallback));
  {
    const MaterialField labels = std::move(materials);
    out->label(labels);
  }
  internal::returnFreeMemory();
  out->countShells();
  out->measureVolumes();
  return std::shared_ptr<const BakedObject>(std::move(out));
}

// Makes a slot, with the fallback material, for each stored or interior brick, and the directory.
Expected<void> BakedObject::laySlots() {
  // Sorted by coordinate: neighbours in space are neighbours in memory, and the order depends on the object alone.
  std::vector<std::pair<std::uint64_t, std::size_t>> stored;  // key, number
  stored.reserve(phi0_.brickCount());
  for (std::size_t b = 0; b < phi0_.brickCount(); ++b) stored.emplace_back(coordKey(phi0_.brickCoord(b)), b);
  std::sort(stored.begin(), stored.end());
  const std::vector<Vec3i> interior = phi0_.interiorBricks();  // sorted

  Vec3i low = phi0_.brickCoord(0), high = low;
  const auto take = [&](const Vec3i& brick) {
    low = low.cwiseMin(brick);
    high = high.cwiseMax(brick);
  };
  for (std::size_t b = 0; b < phi0_.brickCount(); ++b) take(phi0_.brickCoord(b));
  for (const Vec3i& brick : interior) take(brick);
  const int air = 1 + static_cast<int>(std::ceil(kAirAround / (8 * voxel())));
  const Vec3i size = high - low + Vec3i::Constant(1 + 2 * air);
  if (size.cast<double>().prod() > 1 << 26)
    return fail({.code = Error::Code::kBadValue,
                 .place = "distance field",
                 .found = fmt::format("a box of {} x {} x {} bricks of {} mm", size[0], size[1], size[2], 8 * voxel()),
                 .expected = "at most 67 million bricks",
                 .hint = "use larger voxels, or pieces closer together"});

  directory_ = BrickDirectory(low - Vec3i::Constant(air), size);
  slots_.reserve(stored.size() + interior.size());
  const auto lay = [&](const Vec3i& brick, const float* phi) {
    directory_.set(directory_.indexOf(brick), static_cast<std::int32_t>(slots_.size()));
    slots_.push_back({brick, phi0_.interior(), phi, fallbackMaterials(), 0, true});
  };
  auto next = stored.begin();
  const auto layStored = [&](std::uint64_t below) {
    for (; next != stored.end() && next->first < below; ++next)
      lay(phi0_.brickCoord(next->second), phi0_.brick(next->second).data());
  };
  for (const Vec3i& brick : interior) {
    layStored(coordKey(brick));
    lay(brick, inside_.data());
  }
  layStored(~std::uint64_t{0});
  return {};
}

// Sets the materials of each slot. A node without a label gets the fallback: any such node can be cut.
void BakedObject::label(const MaterialField& materials) {
  std::vector<std::size_t> mixed;  // slots, in the order of materials_
  for (std::size_t s = 0; s < slots_.size(); ++s) {
    const std::optional<Material> one = materials.oneOf(slots_[s].brick);
    if (one == Material::kNone) continue;
    if (one) {
      slots_[s].materials = uniform_[static_cast<std::size_t>(*one)].get();
    } else {
      slots_[s].has_one_material = false;
      mixed.push_back(s);
    }
  }

  internal::reserveLarge(materials_, mixed.size());
  materials_.resize(mixed.size());
  tbb::parallel_for(std::size_t{0}, mixed.size(), [&](std::size_t n) {
    auto& numbers = materials_[n];
    materials.copyBrick(slots_[mixed[n]].brick, numbers);
    std::replace(numbers.begin(), numbers.end(), std::uint8_t{0}, static_cast<std::uint8_t>(fallback_));
    slots_[mixed[n]].materials = numbers.data();
  });
}

BrickNeighborhood BakedObject::around(const Slot& slot) const noexcept {
  const std::size_t here = directory_.indexOf(slot.brick);
  BrickNeighborhood out{slot.phi, {}};
  for (int face = 0; face < 6; ++face) {
    const std::int32_t beside = directory_.at(directory_.indexBeside(here, face));
    out.face[face] = beside < 0 ? outside_.data() : slots_[static_cast<std::size_t>(beside)].phi;
  }
  return out;
}

int BakedObject::shellOf(const Slot& slot, ShellChunk* out) const noexcept {
  return shellOfBrick(around(slot), slot.materials, voxel(), out);
}

// Counts the shell nodes of each slot and finds its least value, both from the slot's own values.
void BakedObject::countShells() {
  const auto e = static_cast<float>(kShellHalfWidth * voxel());
  const bool is_interior_empty = std::abs(phi0_.interior()) >= e;
  tbb::parallel_for(std::size_t{0}, slots_.size(), [&](std::size_t s) {
    Slot& slot = slots_[s];
    if (isInterior(slot) && is_interior_empty) return;
    // Eight at a time.
    std::array<float, 8> least;
    std::copy_n(slot.phi, 8, least.begin());
    std::array<std::int32_t, 8> nodes{};
    for (int row = 0; row < kBrickNodes; row += 8)
      for (std::size_t n = 0; n < 8; ++n) {
        const float phi = slot.phi[static_cast<std::size_t>(row) + n];
        least[n] = phi < least[n] ? phi : least[n];
        nodes[n] += std::abs(phi) < e ? 1 : 0;
      }
    slot.least = *std::min_element(least.begin(), least.end());
    slot.shell_count = static_cast<std::uint16_t>(std::accumulate(nodes.begin(), nodes.end(), 0));
  });
  for (const Slot& slot : slots_) shell_chunks_ += static_cast<std::size_t>(chunkCount(slot.shell_count));
}

// In whole parts of a cell: the number of threads changes nothing.
void BakedObject::measureVolumes() {
  const auto ofSlots = [&](const tbb::blocked_range<std::size_t>& range, PartsByNumber parts) {
    for (std::size_t n = range.begin(); n < range.end(); ++n) {
      const Slot& slot = slots_[n];
      const std::size_t here = directory_.indexOf(slot.brick);
      BrickNeighborhood around{slot.phi, {}};
      MaterialNeighborhood materials{slot.materials, {}, slot.has_one_material};
      bool is_deep = isInterior(slot);
      for (int face = 0; face < 6; ++face) {
        const std::int32_t beside = directory_.at(directory_.indexBeside(here, face));
        around.face[face] = beside < 0 ? outside_.data() : slots_[static_cast<std::size_t>(beside)].phi;
        if (beside >= 0) materials.add(face, slots_[static_cast<std::size_t>(beside)]);
        is_deep = is_deep && around.face[face] == inside_.data();
      }
      if (is_deep && slot.has_one_material)  // no surface: whole cells
        parts[slot.materials[0]] += std::int64_t{kBrickNodes} * kCellParts;
      else
        addVolumes(around, materials, phi0_.background(), parts);
    }
    return parts;
  };
  const auto together = [](PartsByNumber one, const PartsByNumber& other) {
    for (std::size_t m = 0; m < one.size(); ++m) one[m] += other[m];
    return one;
  };
  const PartsByNumber parts =
      tbb::parallel_reduce(tbb::blocked_range<std::size_t>(0, slots_.size(), 1024), PartsByNumber{}, ofSlots, together);

  const double part = volumeOfPart(voxel());
  for (std::size_t m = 0; m < parts.size(); ++m) volumes_[m] = addParts(0, parts[m], part);
}

}  // namespace kerf
