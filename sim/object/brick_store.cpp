#include "sim/object/brick_store.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include "sim/object/brick_faces.h"
#include "sim/object/huge_pages.h"
#include "sim/object/state_hash.h"

namespace kerf {

BrickStore::BrickStore(std::shared_ptr<const BakedObject> baked, Begin begin) : baked_(std::move(baked)) {
  if (begin == Begin::kEmpty) return;
  directory_ = baked_->directory();
  reserveSlots(baked_->slots().size());
  for (const BakedObject::Slot& from : baked_->slots()) addLoaded(from);
  brick_count_ = slots_.size();
}

void BrickStore::reserveSlots(std::size_t bricks) {
  most_slots_ = bricks + kMostAdded;
  internal::reserveLarge(slots_, most_slots_);
  touched_.reserve(most_slots_);
}

void BrickStore::addLoaded(const BakedObject::Slot& from) {
  BrickSlot& s = slots_.emplace_back();
  s.brick = from.brick;
  s.phi = s.baked = from.phi;
  s.materials = s.baked_materials = from.materials;
  s.shell_count = static_cast<std::int16_t>(from.shell_count);
  s.has_one_material = from.has_one_material;
  s.least = from.least;
}

int BrickStore::addAir(const Vec3i& brick) noexcept {
  // Its six neighbours must be in the directory, too.
  const Vec3i at = brick - directory_.low();
  if ((at.array() < 1).any() || (at.array() >= directory_.size().array() - 1).any()) return -1;
  if (slots_.size() == most_slots_) return -1;

  const int s = slotCount();
  addLoaded(baked_->air(brick));  // reserved
  ++brick_count_;
  directory_.set(directory_.indexOf(brick), s);
  return s;
}

void BrickStore::copyInto(BrickVersion& version, int s, std::uint64_t stroke) noexcept {
  BrickSlot& slot = this->slot(s);
  version.slot = s;
  version.stroke = stroke;
  version.before = slot.version;
  std::memcpy(version.phi.data(), slot.phi, sizeof(BrickValues));

  version.has_own_materials = slot.own_materials != nullptr;
  if (version.has_own_materials) {
    std::memcpy(version.materials.data(), slot.own_materials, kBrickNodes);
    slot.materials = slot.own_materials = version.materials.data();
  }
  slot.version = &version;
  slot.phi = slot.own = version.phi.data();
}

std::uint8_t* BrickStore::ownMaterials(int s) noexcept {
  BrickSlot& slot = this->slot(s);
  if (!slot.own_materials) {
    slot.version->has_own_materials = true;
    slot.own_materials = slot.version->materials.data();
    std::memcpy(slot.own_materials, slot.materials, kBrickNodes);
    slot.materials = slot.own_materials;
  }
  slot.has_one_material = false;
  return slot.own_materials;
}

std::uint8_t BrickStore::swapIn(BrickVersion& version, bool is_undo) noexcept {
  BrickSlot& slot = this->slot(version.slot);
  assert(slot.version == (is_undo ? &version : version.before));
  const float* const phi = slot.phi;
  BrickVersion* const wanted = is_undo ? version.before : &version;

  slot.version = wanted;
  slot.own = wanted ? wanted->phi.data() : nullptr;
  slot.phi = wanted ? slot.own : slot.baked;

  if (slot.own_materials) slot.has_one_material = false;  // perhaps: nothing depends on it
  slot.own_materials = wanted && wanted->has_own_materials ? wanted->materials.data() : nullptr;
  slot.materials = slot.own_materials ? slot.own_materials : slot.baked_materials;
  if (slot.own_materials) slot.has_one_material = false;

  slot.least = *std::min_element(slot.phi, slot.phi + kBrickNodes);
  return facesThatDiffer(phi, slot.phi);
}

BrickNeighborhood BrickStore::around(const BrickSlot& slot) const noexcept {
  const std::size_t here = directory_.indexOf(slot.brick);
  BrickNeighborhood out{slot.phi, {}};
  for (int face = 0; face < 6; ++face) {
    const std::int32_t s = directory_.at(directory_.indexBeside(here, face));
    out.face[face] = s < 0 ? baked_->outsideBrick() : this->slot(s).phi;
  }
  return out;
}

MaterialNeighborhood BrickStore::materialsAround(const BrickSlot& slot) const noexcept {
  const std::size_t here = directory_.indexOf(slot.brick);
  MaterialNeighborhood out{slot.materials, {}, slot.has_one_material};
  for (int face = 0; face < 6; ++face)
    if (const std::int32_t s = directory_.at(directory_.indexBeside(here, face)); s >= 0) out.add(face, this->slot(s));
  return out;
}

BrickField BrickStore::changedField() const {
  const BrickField& phi0 = baked_->phi0();
  BrickField out(phi0.voxel(), phi0.background(), phi0.interior());
  for (const BrickSlot& slot : slots_)
    if (slot.hasChangedValues()) out.add(slot.brick, std::span<const float, kBrickNodes>(slot.own, kBrickNodes));
  return out;
}

BrickField BrickStore::field() const {
  const BrickField& phi0 = baked_->phi0();
  BrickField out(phi0.voxel(), phi0.background(), phi0.interior());
  for (int n = 0; n < slotCount(); ++n) {
    if (!has(n)) continue;
    const BrickSlot& slot = this->slot(n);
    const bool is_constant = !slot.own && phi0.find(slot.brick) < 0;
    if (!is_constant)
      out.add(slot.brick, std::span<const float, kBrickNodes>(slot.phi, kBrickNodes));
    else if (slot.phi[0] < 0)
      out.markInterior(slot.brick);
  }
  return out;
}

std::uint64_t BrickStore::stateHash() const {
  std::uint64_t out = changedField().stateHash() + piece_key_;
  for (const BrickSlot& slot : slots_)
    if (slot.hasChangedMaterials()) out += materialsHash(slot);  // a sum: the order of the bricks does not matter
  return out;
}

std::array<double, 256> BrickStore::countVolumes() const {
  PartsByNumber parts{};
  for (int s = 0; s < slotCount(); ++s)
    if (has(s)) addVolumes(around(slot(s)), materialsAround(slot(s)), baked_->phi0().background(), parts);

  const double part = volumeOfPart(baked_->voxel());
  std::array<double, 256> out{};
  for (std::size_t m = 0; m < parts.size(); ++m) out[m] = addParts(0, parts[m], part);
  return out;
}

std::size_t BrickStore::shellDefects() const {
  std::vector<ShellChunk> expected(kShellChunks), loaded(kShellChunks);
  std::size_t defects = 0;
  for (int n = 0; n < slotCount(); ++n) {
    if (!has(n)) continue;
    const BrickSlot& slot = this->slot(n);
    const int count = shellOfBrick(around(slot), slot.materials, baked_->voxel(), expected.data());
    bool is_same = count == slot.shell_count;
    const bool is_made = slot.shell_count == 0 || slot.shell != nullptr;
    if (is_same && !is_made) {
      const std::int32_t before = baked_->directory().find(slot.brick);
      is_same =
          before >= 0 && baked_->shellOf(baked_->slots()[static_cast<std::size_t>(before)], loaded.data()) == count;
    }
    for (std::size_t c = 0; is_same && c < static_cast<std::size_t>(chunkCount(count)); ++c) {
      const ShellChunk& chunk = is_made ? slot.chunk(c) : loaded[c];
      is_same = chunk.x == expected[c].x && chunk.y == expected[c].y && chunk.z == expected[c].z &&
                chunk.phi == expected[c].phi && chunk.offset == expected[c].offset &&
                chunk.material == expected[c].material;
    }
    defects += !is_same;
  }
  return defects;
}

}  // namespace kerf
