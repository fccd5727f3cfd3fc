#include "sim/object/cut_object.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <new>
#include <span>
#include <utility>

#include "geometry/field/brick_hash.h"
#include "sim/object/huge_pages.h"

namespace kerf {
namespace {

bool hasChangedMaterials(const CutObject::Slot& slot) {
  return slot.own_materials && std::memcmp(slot.own_materials, slot.baked_materials, kBrickNodes) != 0;
}

// What the materials of a brick add to the hash.
std::uint64_t materialsHash(const CutObject::Slot& slot) {
  std::uint64_t h = coordKey(slot.brick);
  for (int n = 0; n < kBrickNodes; n += 8) {
    std::uint64_t eight;
    std::memcpy(&eight, slot.own_materials + n, 8);
    h = (h ^ eight) * 0x9e3779b97f4a7c15ull;
    h ^= h >> 29;
  }
  return h;
}

}  // namespace

CutObject::CutObject(OfPiece, std::shared_ptr<const BakedObject> baked)
    : baked_(std::move(baked)), hash_sum_(hashOfNoBricks(baked_->voxel())), scratch_(kShellChunks) {}

CutObject::CutObject(std::shared_ptr<const BakedObject> baked, std::size_t bricks)
    : CutObject(OfPiece{}, std::move(baked)) {
  directory_ = baked_->directory();
  reserveSlots(baked_->slots().size());
  for (const BakedObject::Slot& from : baked_->slots()) addLoaded(from);
  brick_count_ = slots_.size();
  if (!reserve(std::min(bricks, slots_.size()))) throw std::bad_alloc();
}

void CutObject::addLoaded(const BakedObject::Slot& from) {
  Slot& s = slots_.emplace_back();
  s.brick = from.brick;
  s.phi = s.baked = from.phi;
  s.own = nullptr;
  s.version = nullptr;
  s.materials = s.baked_materials = from.materials;
  s.own_materials = nullptr;
  s.chunks.fill(nullptr);
  for (std::uint32_t n = 0; n * ShellChunk::kNodes < from.shell_count; ++n)
    s.chunks[n] = baked_->shell().data() + from.shell_begin + n;
  s.shell_count = static_cast<std::int16_t>(from.shell_count);
  s.owns_shell = s.is_dirty = s.is_exported_dirty = s.is_watched_dirty = s.is_touched = false;
  s.changed_faces = 0;
  s.has_one_material = from.has_one_material;
  s.least = from.least;
  s.sleeps_until_contact = s.sleeps_until_cut = -1;
  s.hash_term = 0;
  s.hash_round = 0;
  s.is_hash_stale = false;
}

void CutObject::reserveSlots(std::size_t bricks) {
  most_slots_ = bricks + kMostAdded;
  internal::reserveLarge(slots_, most_slots_);
  dirty_.reserve(most_slots_);
  export_.reserve(most_slots_);
  watch_.reserve(most_slots_);
  stale_.reserve(most_slots_);
  touched_.reserve(most_slots_);
  to_repair_.reserve(most_slots_);
  repair_mark_.assign(most_slots_, 0);
}

bool CutObject::reserve(std::size_t bricks) {
  auto room = BrickPool::make(bricks);
  if (!room) return false;
  take(std::move(room));
  return true;
}

void CutObject::take(std::unique_ptr<BrickPool> room) noexcept {
  free_versions_.append(room->free_versions_);
  free_chunks_.append(room->free_chunks_);
  free_records_.append(room->free_records_);
  room->next_ = std::move(pools_);
  pools_ = std::move(room);
}

std::size_t CutObject::freeBricks() const noexcept {
  return std::min(free_versions_.count, free_chunks_.count / BrickPool::kChunksPerBrick);
}

void CutObject::mark(int s) noexcept {
  Slot& slot = slots_[static_cast<std::size_t>(s)];
  if (!slot.is_dirty) {
    slot.is_dirty = true;
    dirty_.push_back(s);
  }
  if (!slot.is_exported_dirty) {
    slot.is_exported_dirty = true;
    export_.push_back(s);
  }
  if (!slot.is_hash_stale) {
    slot.is_hash_stale = true;
    stale_.push_back(s);
  }
  touch(s);
  slot.hash_round = repair_round_;
  if (!slot.is_watched_dirty) {
    slot.is_watched_dirty = true;
    watch_.push_back(s);
  }
}

// A copy of what the brick is now, as its own.
void CutObject::fillVersion(BrickVersion& version, int s, BrickVersion* before, std::uint64_t stroke) noexcept {
  Slot& slot = slots_[static_cast<std::size_t>(s)];
  version.slot = s;
  version.stroke = stroke;
  version.before = before;
  std::memcpy(version.phi.data(), slot.phi, sizeof(BrickValues));
  version.has_own_materials = slot.own_materials != nullptr;
  if (version.has_own_materials) {
    std::memcpy(version.materials.data(), slot.own_materials, kBrickNodes);
    slot.materials = slot.own_materials = version.materials.data();
  }
  slot.version = &version;
  slot.phi = slot.own = version.phi.data();
}

float* CutObject::write(int s) noexcept {
  Slot& slot = slots_[static_cast<std::size_t>(s)];
  if (!slot.version || slot.version->stroke != stroke_) {
    if (free_versions_.isEmpty()) return nullptr;
    BrickVersion* const version = free_versions_.popFront();
    fillVersion(*version, s, slot.version, stroke_);
    in_stroke_.pushFront(version);
  }
  mark(s);
  slot.changed_faces = kAllFaces;
  return slot.own;
}

std::uint8_t* CutObject::writeMaterials(int s) noexcept {
  Slot& slot = slots_[static_cast<std::size_t>(s)];
  assert(slot.version && slot.version->stroke == stroke_);
  if (!slot.own_materials) {
    slot.version->has_own_materials = true;
    slot.own_materials = slot.version->materials.data();
    std::memcpy(slot.own_materials, slot.materials, kBrickNodes);
    slot.materials = slot.own_materials;
  }
  slot.has_one_material = false;
  return slot.own_materials;
}

int CutObject::addAir(const Vec3i& brick) noexcept {
  // Its six neighbours must be in the directory, too.
  const Vec3i at = brick - baked_->directoryLow();
  const Vec3i& size = baked_->directorySize();
  if ((at.array() < 1).any() || (at.array() >= size.array() - 1).any()) return -1;
  if (slots_.size() == most_slots_) return -1;
  const auto s = static_cast<int>(slots_.size());
  addLoaded(baked_->air(brick));  // reserved
  ++brick_count_;
  directory_[static_cast<std::size_t>((at[0] * size[1] + at[1]) * size[2] + at[2])] = s;
  return s;
}

bool CutObject::carve(int s, const float* values, float least, double& removed) noexcept {
  Slot& slot = slots_[static_cast<std::size_t>(s)];
  const std::uint8_t faces = slot.changed_faces;
  float* const own = write(s);
  if (!own) return false;
  const double e = kShellHalfWidth * voxel(), cell = voxel() * voxel() * voxel();
  const auto half_width = static_cast<float>(e);
  double lost[kBrickNodes];
  const internal::NodeBits changed = internal::differingNodes(own, values);
  slot.changed_faces = faces | facesOf(changed);
  internal::volumeLost(own, values, changed, e, cell, lost);
  // One sum per material, node by node: the order is part of the result.
  double one_material = removed_mm3[slot.materials[0]];
  for (int word = 0; word < kBrickSide; ++word)
    for (std::uint64_t bits = changed[static_cast<std::size_t>(word)]; bits != 0; bits &= bits - 1) {
      const int n = 64 * word + std::countr_zero(bits);
      if (own[n] >= half_width || values[n] <= -half_width) continue;
      (slot.has_one_material ? one_material : removed_mm3[slot.materials[n]]) += lost[n];
      removed += lost[n];
    }
  if (slot.has_one_material) removed_mm3[slot.materials[0]] = one_material;
  std::memcpy(own, values, sizeof(BrickValues));
  slot.least = least;
  slot.sleeps_until_contact = -1;
  return true;
}

bool CutObject::restore(int s, const BrickValues& values, const std::uint8_t* materials) {
  if (freeBricks() == 0 && !reserve(1024)) return false;
  float* own = write(s);
  Slot& restored = slot(s);
  std::copy(values.begin(), values.end(), own);
  if (materials || restored.own_materials)
    std::copy_n(materials ? materials : restored.baked_materials, kBrickNodes, writeMaterials(s));
  restored.least = *std::min_element(own, own + kBrickNodes);
  restored.sleeps_until_contact = restored.sleeps_until_cut = -1;
  return true;
}

LinkedList<BrickVersion> CutObject::endStroke() noexcept {
  ++stroke_;
  return std::exchange(in_stroke_, {});
}

void CutObject::swapStroke(const LinkedList<BrickVersion>& stroke, bool is_undo) noexcept {
  for (BrickVersion* version = stroke.first; version; version = version->next) {
    Slot& slot = slots_[static_cast<std::size_t>(version->slot)];
    assert(slot.version == (is_undo ? version : version->before));
    const float* const phi = slot.phi;
    BrickVersion* const wanted = is_undo ? version->before : version;
    slot.version = wanted;
    slot.own = wanted ? wanted->phi.data() : nullptr;
    slot.phi = wanted ? slot.own : slot.baked;
    if (slot.own_materials) slot.has_one_material = false;  // it may have: nobody needs to know
    slot.own_materials = wanted && wanted->has_own_materials ? wanted->materials.data() : nullptr;
    slot.materials = slot.own_materials ? slot.own_materials : slot.baked_materials;
    if (slot.own_materials) slot.has_one_material = false;
    slot.changed_faces |= facesThatDiffer(phi, slot.phi);
    slot.least = *std::min_element(slot.phi, slot.phi + kBrickNodes);
    slot.sleeps_until_contact = slot.sleeps_until_cut = -1;
    mark(version->slot);
  }
}

void CutObject::prepareHash(std::size_t bricks, std::uint32_t rounds) noexcept {
  constexpr std::size_t kLanes = 4;
  std::array<std::uint64_t, kLanes> keys{}, rest{};
  std::array<const float*, kLanes> values{};
  std::array<Slot*, kLanes> slots{};
  std::size_t waiting = 0;
  const auto set = [this](Slot& slot, std::uint64_t term) {
    hash_sum_ += term - slot.hash_term;
    slot.hash_term = term;
  };
  const auto finish = [&] {
    for (std::size_t n = waiting; n < kLanes; ++n) {
      keys[n] = keys[0];
      values[n] = values[0];
    }
    const auto terms = brickHashes<kLanes>(keys, values);
    for (std::size_t n = 0; n < waiting; ++n) set(*slots[n], terms[n] + rest[n]);
    waiting = 0;
  };
  // Looks that find nothing to do are bounded as well.
  for (std::size_t looks = std::min(stale_.size(), 8 * bricks); looks > 0 && bricks > 0; --looks) {
    if (next_stale_ >= stale_.size()) next_stale_ = 0;
    Slot& slot = slots_[static_cast<std::size_t>(stale_[next_stale_])];
    if (repair_round_ - slot.hash_round < rounds) {
      ++next_stale_;
      continue;
    }
    slot.is_hash_stale = false;
    stale_[next_stale_] = stale_.back();
    stale_.pop_back();
    --bricks;
    const std::uint64_t of_materials = hasChangedMaterials(slot) ? materialsHash(slot) : 0;
    if (!slot.own || std::memcmp(slot.own, slot.baked, sizeof(BrickValues)) == 0) {
      set(slot, of_materials);  // as baked: not part of the changed field
      continue;
    }
    keys[waiting] = coordKey(slot.brick);
    values[waiting] = slot.own;
    slots[waiting] = &slot;
    rest[waiting] = of_materials;
    if (++waiting == kLanes) finish();
  }
  if (waiting > 0) finish();
}

BrickNeighborhood CutObject::around(const Slot& slot) const noexcept {
  const Vec3i at = slot.brick - baked_->directoryLow();
  const Vec3i& size = baked_->directorySize();
  const int here = (at[0] * size[1] + at[1]) * size[2] + at[2];
  const int step[3] = {size[1] * size[2], size[2], 1};
  BrickNeighborhood out{slot.phi, {}};
  for (int f = 0; f < 6; ++f) {
    const std::int32_t s = directory_[static_cast<std::size_t>(here + (f & 1 ? 1 : -1) * step[f / 2])];
    out.face[f] = s < 0 ? baked_->outsideBrick() : slots_[static_cast<std::size_t>(s)].phi;
  }
  return out;
}

bool CutObject::repairShell(Slot& slot) noexcept {
  touch(static_cast<int>(&slot - slots_.data()));
  const int count = shellOfBrick(around(slot), slot.materials, voxel(), scratch_.data());
  const int chunks = chunkCount(count), had = chunkCount(slot.shell_count);
  const int owned = slot.owns_shell ? had : 0;
  if (static_cast<int>(free_chunks_.count) < chunks - owned) return false;
  std::array<ShellChunk*, kShellChunks> next{};
  for (int c = 0; c < chunks; ++c) {
    if (c < owned) {
      next[static_cast<std::size_t>(c)] = const_cast<ShellChunk*>(slot.chunks[static_cast<std::size_t>(c)]);
    } else {
      next[static_cast<std::size_t>(c)] = &free_chunks_.popFront()->chunk;
    }
  }
  for (int c = chunks; c < owned; ++c)  // owned ones came from a room
    free_chunks_.pushFront(
        reinterpret_cast<PoolChunk*>(const_cast<ShellChunk*>(slot.chunks[static_cast<std::size_t>(c)])));
  slot.chunks.fill(nullptr);
  for (int c = 0; c < chunks; ++c) {
    *next[static_cast<std::size_t>(c)] = scratch_[static_cast<std::size_t>(c)];
    slot.chunks[static_cast<std::size_t>(c)] = next[static_cast<std::size_t>(c)];
  }
  slot.shell_count = static_cast<std::int16_t>(count);
  slot.owns_shell = true;
  return true;
}

bool CutObject::repair() noexcept {
  ++repair_round_;
  if (dirty_.empty()) return true;  // held, it may be read by others: nothing is written
  to_repair_.clear();
  for (const int s : dirty_) {
    const Vec3i brick = slots_[static_cast<std::size_t>(s)].brick;
    const auto want = [&](int slot) {
      if (slot < 0 || repair_mark_[static_cast<std::size_t>(slot)] == repair_round_) return;
      repair_mark_[static_cast<std::size_t>(slot)] = repair_round_;
      to_repair_.push_back(slot);
    };
    want(s);
    // A neighbour's set of nodes stays, its own values did not change; only their gradients do, if it has any.
    for (int face = 0; face < 6; ++face) {
      if (!(slots_[static_cast<std::size_t>(s)].changed_faces >> face & 1)) continue;
      Vec3i next = brick;
      next[face / 2] += face & 1 ? 1 : -1;
      const int neighbor = find(next);
      if (neighbor >= 0 && slots_[static_cast<std::size_t>(neighbor)].shell_count > 0) want(neighbor);
    }
  }
  for (const int s : to_repair_)
    if (!repairShell(slots_[static_cast<std::size_t>(s)])) return false;
  for (const int s : dirty_) {
    slots_[static_cast<std::size_t>(s)].is_dirty = false;
    slots_[static_cast<std::size_t>(s)].changed_faces = 0;
  }
  dirty_.clear();
  return true;
}

BrickField CutObject::changedField() const {
  const BrickField& phi0 = baked_->phi0();
  BrickField out(phi0.voxel(), phi0.background(), phi0.interior());
  for (const Slot& slot : slots_)
    if (slot.own && std::memcmp(slot.own, slot.baked, sizeof(BrickValues)) != 0)
      out.add(slot.brick, std::span<const float, kBrickNodes>(slot.own, kBrickNodes));
  return out;
}

BrickField CutObject::field() const {
  const BrickField& phi0 = baked_->phi0();
  BrickField out(phi0.voxel(), phi0.background(), phi0.interior());
  for (int n = 0; n < slotCount(); ++n) {
    if (!has(n)) continue;
    const Slot& slot = this->slot(n);
    const bool is_constant = !slot.own && phi0.find(slot.brick) < 0;
    if (!is_constant)
      out.add(slot.brick, std::span<const float, kBrickNodes>(slot.phi, kBrickNodes));
    else if (slot.phi[0] < 0)
      out.markInterior(slot.brick);
  }
  return out;
}

bool CutObject::hasOwnMaterials() const { return std::any_of(slots_.begin(), slots_.end(), hasChangedMaterials); }

std::uint64_t CutObject::stateHash() const {
  std::uint64_t out = changedField().stateHash() + piece_key_;
  for (const Slot& slot : slots_)
    if (hasChangedMaterials(slot)) out += materialsHash(slot);  // a sum: the order of the bricks does not matter
  return out;
}

std::array<double, 256> CutObject::countVolumes() const {
  const double e = kShellHalfWidth * voxel(), cell = std::pow(voxel(), 3);
  std::array<double, 256> out{};
  for (int s = 0; s < slotCount(); ++s)
    for (int n = 0; has(s) && n < kBrickNodes; ++n) out[slot(s).materials[n]] += cell * insidePart(slot(s).phi[n], e);
  return out;
}

std::size_t CutObject::shellDefects() const {
  std::vector<ShellChunk> expected(kShellChunks);
  std::size_t defects = 0;
  for (int n = 0; n < slotCount(); ++n) {
    if (!has(n)) continue;
    const Slot& slot = this->slot(n);
    const int count = shellOfBrick(around(slot), slot.materials, voxel(), expected.data());
    bool is_same = count == slot.shell_count;
    for (std::size_t c = 0; is_same && c < static_cast<std::size_t>(chunkCount(count)); ++c)
      is_same = slot.chunks[c]->x == expected[c].x && slot.chunks[c]->y == expected[c].y &&
                slot.chunks[c]->z == expected[c].z && slot.chunks[c]->phi == expected[c].phi &&
                slot.chunks[c]->offset == expected[c].offset && slot.chunks[c]->material == expected[c].material;
    defects += !is_same;
  }
  return defects;
}

}  // namespace kerf
