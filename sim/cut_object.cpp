#include "sim/cut_object.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <new>

namespace kerf {
namespace {

int chunkCount(int nodes) { return (nodes + ShellChunk::kNodes - 1) / ShellChunk::kNodes; }

constexpr std::size_t kChunksPerBrick = 5;  // 320 nodes: more than a plane's 8 x 8 x 3, or two of them

}  // namespace

CutObject::CutObject(std::shared_ptr<const BakedObject> baked, std::size_t bricks)
    : baked_(std::move(baked)), directory_(baked_->directory()), scratch_(kShellChunks) {
  reserveSlots(baked_->slots().size());
  for (const BakedObject::Slot& from : baked_->slots()) {
    Slot& s = slots_.emplace_back();
    s.brick = from.brick, s.phi = s.baked = from.phi, s.own = nullptr;
    s.materials = s.baked_materials = from.materials, s.own_materials = nullptr;
    s.chunks.fill(nullptr);
    for (std::uint32_t n = 0; n * ShellChunk::kNodes < from.shell_count; ++n)
      s.chunks[n] = baked_->shell().data() + from.shell_begin + n;
    s.shell_count = static_cast<std::int16_t>(from.shell_count);
    s.owns_shell = s.is_dirty = s.is_exported_dirty = s.is_watched_dirty = false;
    s.changed_faces = 0;
    s.has_one_material = from.has_one_material;
    s.least = *std::min_element(s.phi, s.phi + kBrickNodes);
    s.sleeps_until_contact = s.sleeps_until_cut = -1;
  }
  if (!reserve(std::min(bricks, slots_.size()))) throw std::bad_alloc();
}

void CutObject::reserveSlots(std::size_t bricks) {
  most_slots_ = bricks + kMostAdded;
  slots_.reserve(most_slots_);
  dirty_.reserve(most_slots_), export_.reserve(most_slots_), watch_.reserve(most_slots_);
  to_repair_.reserve(most_slots_);
  repair_mark_.assign(most_slots_, 0);
}

CutObject CutObject::piece(const CutObject& whole, const PieceBricks& bricks) {
  CutObject out(OfPiece{}, whole.baked_);
  out.is_piece_ = true;
  out.T_world_object = whole.T_world_object;
  out.directory_.assign(whole.directory_.size(), -1);
  out.reserveSlots(bricks.bricks.size() + bricks.interior.size());
  // Both lists are in order of coordinate; so are the slots.
  std::size_t b = 0, i = 0, next_changed = 0, own = 0;
  std::vector<const BrickValues*> values_of;  // by slot: new ones; null: those of the whole
  const auto isBefore = [](const Vec3i& p, const Vec3i& q) { return coordKey(p) < coordKey(q); };
  std::vector<Vec3i> interior = bricks.interior;
  std::sort(interior.begin(), interior.end(), isBefore);
  while (b < bricks.bricks.size() || i < interior.size()) {
    const bool from_interior =
        b == bricks.bricks.size() || (i < interior.size() && isBefore(interior[i], bricks.bricks[b]));
    const Vec3i& brick = from_interior ? interior[i++] : bricks.bricks[b++];
    const BrickValues* changed = nullptr;
    if (!from_interior && next_changed < bricks.changed.size() && bricks.changed[next_changed].brick == brick)
      changed = &bricks.changed[next_changed++].phi;
    const int from = whole.find(brick);
    assert(from >= 0);
    const Vec3i at = brick - out.baked_->directoryLow();
    const Vec3i& size = out.baked_->directorySize();
    out.directory_[static_cast<std::size_t>((at[0] * size[1] + at[1]) * size[2] + at[2])] =
        static_cast<std::int32_t>(out.slots_.size());
    Slot& slot = out.slots_.emplace_back(whole.slot(from));
    slot.is_dirty = slot.is_exported_dirty = slot.is_watched_dirty = false;
    slot.changed_faces = 0;
    slot.sleeps_until_contact = slot.sleeps_until_cut = -1;
    if (changed || slot.own)
      values_of.push_back(changed), ++own;
    else
      values_of.push_back(nullptr);
    out.piece_key_ += (coordKey(brick) + 1) * 0x9e3779b97f4a7c15ull;
  }
  if (!out.reserve(own + own / 2 + 64)) throw std::bad_alloc();
  std::vector<int> rebuild;
  for (int s = 0; s < out.slotCount(); ++s) {
    Slot& slot = out.slot(s);
    const BrickValues* changed = values_of[static_cast<std::size_t>(s)];
    // New shells where values or those of a neighbour are other than baked, or a neighbour is no longer there.
    bool is_new = changed || slot.owns_shell;
    for (int face = 0; face < 6 && !is_new; ++face) {
      Vec3i next = slot.brick;
      next[face / 2] += face & 1 ? 1 : -1;
      const int here = out.find(next);
      is_new = here < 0 ? whole.find(next) >= 0 : values_of[static_cast<std::size_t>(here)] != nullptr;
    }
    if (is_new) rebuild.push_back(s);
    if (!changed && !slot.own) continue;
    OwnBrick* room = out.free_bricks_.back();
    out.free_bricks_.pop_back();
    std::memcpy(room->phi.data(), changed ? changed->data() : slot.phi, sizeof(BrickValues));
    slot.own = room->phi.data(), slot.phi = slot.own;
    if (slot.own_materials) {
      std::memcpy(room->materials.data(), slot.own_materials, kBrickNodes);
      slot.own_materials = room->materials.data(), slot.materials = slot.own_materials;
    }
    if (changed) slot.least = *std::min_element(slot.own, slot.own + kBrickNodes);
  }
  for (const int s : rebuild) {
    out.slot(s).owns_shell = false;  // its chunks are the whole's
    while (!out.repairShell(out.slot(s)))
      if (!out.reserve(1024)) throw std::bad_alloc();
  }
  return out;
}

bool CutObject::reserve(std::size_t bricks) {
  bricks = std::max<std::size_t>(bricks, 1);
  try {
    auto values = std::make_unique<OwnBrick[]>(bricks);
    auto nodes = std::make_unique<ShellChunk[]>(bricks * kChunksPerBrick);
    // Room for all that exist: giving back never allocates.
    free_bricks_.reserve(all_bricks_ + bricks);
    free_chunks_.reserve((all_bricks_ + bricks) * kChunksPerBrick);
    brick_blocks_.push_back(std::move(values));
    shell_blocks_.push_back(std::move(nodes));
  } catch (const std::bad_alloc&) {
    return false;
  }
  all_bricks_ += bricks;
  for (std::size_t n = bricks; n-- > 0;) free_bricks_.push_back(brick_blocks_.back().get() + n);
  for (std::size_t n = bricks * kChunksPerBrick; n-- > 0;) free_chunks_.push_back(shell_blocks_.back().get() + n);
  return true;
}

std::size_t CutObject::freeBricks() const noexcept {
  return std::min(free_bricks_.size(), free_chunks_.size() / kChunksPerBrick);
}

void CutObject::mark(int s) noexcept {
  Slot& slot = slots_[static_cast<std::size_t>(s)];
  if (!slot.is_dirty) slot.is_dirty = true, dirty_.push_back(s);
  if (!slot.is_exported_dirty) slot.is_exported_dirty = true, export_.push_back(s);
  if (!slot.is_watched_dirty) slot.is_watched_dirty = true, watch_.push_back(s);
}

float* CutObject::write(int s) noexcept {
  Slot& slot = slots_[static_cast<std::size_t>(s)];
  if (!slot.own) {
    if (free_bricks_.empty()) return nullptr;
    slot.own = free_bricks_.back()->phi.data();
    free_bricks_.pop_back();
    std::memcpy(slot.own, slot.phi, sizeof(BrickValues));
    slot.phi = slot.own;
  }
  mark(s);
  slot.changed_faces = kAllFaces;
  return slot.own;
}

std::uint8_t CutObject::facesThatDiffer(const float* a, const float* b) noexcept {
  unsigned faces = 0;
  const auto differs = [&](int n) { return a[n] != b[n]; };
  for (int u = 0; u < 8; ++u)
    for (int v = 0; v < 8; ++v) {
      faces |= static_cast<unsigned>(differs(8 * u + v));
      faces |= static_cast<unsigned>(differs(448 + 8 * u + v)) << 1;
      faces |= static_cast<unsigned>(differs(64 * u + v)) << 2;
      faces |= static_cast<unsigned>(differs(64 * u + 56 + v)) << 3;
      faces |= static_cast<unsigned>(differs(64 * u + 8 * v)) << 4;
      faces |= static_cast<unsigned>(differs(64 * u + 8 * v + 7)) << 5;
    }
  return static_cast<std::uint8_t>(faces);
}

std::uint8_t* CutObject::writeMaterials(int s) noexcept {
  Slot& slot = slots_[static_cast<std::size_t>(s)];
  assert(slot.own);
  if (!slot.own_materials) {
    // Values and numbers of a brick lie in one OwnBrick, values first.
    slot.own_materials = reinterpret_cast<OwnBrick*>(slot.own)->materials.data();
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
  Slot& slot = slots_.emplace_back();  // reserved
  slot.brick = brick, slot.phi = slot.baked = baked_->outsideBrick(), slot.own = nullptr;
  slot.materials = slot.baked_materials = baked_->fallbackMaterials(), slot.own_materials = nullptr;
  slot.chunks.fill(nullptr);
  slot.shell_count = 0;
  slot.owns_shell = slot.is_dirty = slot.is_exported_dirty = slot.is_watched_dirty = false;
  slot.has_one_material = true;
  slot.changed_faces = 0;
  slot.least = slot.phi[0];
  slot.sleeps_until_contact = slot.sleeps_until_cut = -1;
  directory_[static_cast<std::size_t>((at[0] * size[1] + at[1]) * size[2] + at[2])] = s;
  return s;
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
  const int count = shellOfBrick(around(slot), slot.materials, voxel(), scratch_.data());
  const int chunks = chunkCount(count), had = chunkCount(slot.shell_count);
  const int owned = slot.owns_shell ? had : 0;
  if (static_cast<int>(free_chunks_.size()) < chunks - owned) return false;
  std::array<ShellChunk*, kShellChunks> next{};
  for (int c = 0; c < chunks; ++c) {
    if (c < owned) {
      next[static_cast<std::size_t>(c)] = const_cast<ShellChunk*>(slot.chunks[static_cast<std::size_t>(c)]);
    } else {
      next[static_cast<std::size_t>(c)] = free_chunks_.back();
      free_chunks_.pop_back();
    }
  }
  for (int c = chunks; c < owned; ++c)
    free_chunks_.push_back(const_cast<ShellChunk*>(slot.chunks[static_cast<std::size_t>(c)]));
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
  for (const Slot& slot : slots_) {
    const bool is_constant = !slot.own && phi0.find(slot.brick) < 0;
    if (!is_constant)
      out.add(slot.brick, std::span<const float, kBrickNodes>(slot.phi, kBrickNodes));
    else if (slot.phi[0] < 0)
      out.markInterior(slot.brick);
  }
  return out;
}

bool CutObject::hasOwnMaterials() const {
  return std::any_of(slots_.begin(), slots_.end(), [](const Slot& slot) {
    return slot.own_materials && std::memcmp(slot.own_materials, slot.baked_materials, kBrickNodes) != 0;
  });
}

std::uint64_t CutObject::stateHash() const {
  std::uint64_t out = changedField().stateHash() + piece_key_;
  for (const Slot& slot : slots_) {
    if (!slot.own_materials || std::memcmp(slot.own_materials, slot.baked_materials, kBrickNodes) == 0) continue;
    std::uint64_t h = coordKey(slot.brick);
    for (int n = 0; n < kBrickNodes; n += 8) {
      std::uint64_t eight;
      std::memcpy(&eight, slot.own_materials + n, 8);
      h = (h ^ eight) * 0x9e3779b97f4a7c15ull, h ^= h >> 29;
    }
    out += h;  // a sum: the order of the bricks does not matter
  }
  return out;
}

std::array<double, 256> CutObject::countVolumes() const {
  const double e = kShellHalfWidth * voxel(), cell = std::pow(voxel(), 3);
  std::array<double, 256> out{};
  for (const Slot& slot : slots_)
    for (int n = 0; n < kBrickNodes; ++n) out[slot.materials[n]] += cell * insidePart(slot.phi[n], e);
  return out;
}

std::size_t CutObject::shellDefects() const {
  std::vector<ShellChunk> expected(kShellChunks);
  std::size_t defects = 0;
  for (const Slot& slot : slots_) {
    const int count = shellOfBrick(around(slot), slot.materials, voxel(), expected.data());
    bool is_same = count == slot.shell_count;
    for (std::size_t c = 0; is_same && c < static_cast<std::size_t>(chunkCount(count)); ++c)
      is_same = slot.chunks[c]->x == expected[c].x && slot.chunks[c]->y == expected[c].y &&
                slot.chunks[c]->z == expected[c].z && slot.chunks[c]->offset == expected[c].offset &&
                slot.chunks[c]->material == expected[c].material;
    defects += !is_same;
  }
  return defects;
}

}  // namespace kerf
