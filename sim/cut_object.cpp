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
  slots_.reserve(baked_->slots().size());
  for (const BakedObject::Slot& from : baked_->slots()) {
    Slot& s = slots_.emplace_back();
    s.brick = from.brick, s.phi = from.phi, s.own = nullptr, s.materials = from.materials;
    s.chunks.fill(nullptr);
    for (std::uint32_t n = 0; n * ShellChunk::kNodes < from.shell_count; ++n)
      s.chunks[n] = baked_->shell().data() + from.shell_begin + n;
    s.shell_count = static_cast<std::int16_t>(from.shell_count);
    s.owns_shell = s.is_dirty = s.is_exported_dirty = false;
    s.changed_faces = 0;
    s.has_one_material = from.has_one_material;
    s.least = *std::min_element(s.phi, s.phi + kBrickNodes);
    s.sleeps_until_contact = s.sleeps_until_cut = -1;
  }
  dirty_.reserve(slots_.size()), export_.reserve(slots_.size()), to_repair_.reserve(slots_.size());
  repair_mark_.assign(slots_.size(), 0);
  if (!reserve(std::min(bricks, slots_.size()))) throw std::bad_alloc();
}

bool CutObject::reserve(std::size_t bricks) {
  bricks = std::max<std::size_t>(bricks, 1);
  try {
    auto values = std::make_unique<BrickValues[]>(bricks);
    auto nodes = std::make_unique<ShellChunk[]>(bricks * kChunksPerBrick);
    // Room for all that exist: giving back never allocates.
    free_phi_.reserve(all_bricks_ + bricks);
    free_chunks_.reserve((all_bricks_ + bricks) * kChunksPerBrick);
    phi_blocks_.push_back(std::move(values));
    shell_blocks_.push_back(std::move(nodes));
  } catch (const std::bad_alloc&) {
    return false;
  }
  all_bricks_ += bricks;
  for (std::size_t n = bricks; n-- > 0;) free_phi_.push_back(phi_blocks_.back()[n].data());
  for (std::size_t n = bricks * kChunksPerBrick; n-- > 0;) free_chunks_.push_back(shell_blocks_.back().get() + n);
  return true;
}

std::size_t CutObject::freeBricks() const noexcept {
  return std::min(free_phi_.size(), free_chunks_.size() / kChunksPerBrick);
}

void CutObject::mark(int s) noexcept {
  Slot& slot = slots_[static_cast<std::size_t>(s)];
  if (!slot.is_dirty) slot.is_dirty = true, dirty_.push_back(s);
  if (!slot.is_exported_dirty) slot.is_exported_dirty = true, export_.push_back(s);
}

float* CutObject::write(int s) noexcept {
  Slot& slot = slots_[static_cast<std::size_t>(s)];
  if (!slot.own) {
    if (free_phi_.empty()) return nullptr;
    slot.own = free_phi_.back();
    free_phi_.pop_back();
    std::memcpy(slot.own, slot.phi, sizeof(BrickValues));
    slot.phi = slot.own;
  }
  mark(s);
  slot.changed_faces = kAllFaces;
  return slot.own;
}

std::uint8_t CutObject::facesOf(const internal::NodeBits& nodes) noexcept {
  std::uint64_t any = 0;
  for (const std::uint64_t slab : nodes) any |= slab;
  constexpr std::uint64_t kRow = 0xff, kLow = 0x0101010101010101;
  return static_cast<std::uint8_t>((nodes.front() != 0) | (nodes.back() != 0) << 1 | ((any & kRow) != 0) << 2 |
                                   ((any & kRow << 56) != 0) << 3 | ((any & kLow) != 0) << 4 |
                                   ((any & kLow << 7) != 0) << 5);
}

bool CutObject::restore(const Vec3i& brick, const BrickValues& values) {
  const int s = find(brick);
  if (s < 0) return false;
  if (freeBricks() == 0 && !reserve(1024)) return false;
  float* own = write(s);
  Slot& restored = slot(s);
  const double e = kShellHalfWidth * voxel(), cell = std::pow(voxel(), 3);
  for (std::size_t n = 0; n < kBrickNodes; ++n)
    if (own[n] != values[n])
      removed_mm3[restored.materials[n]] += cell * (insidePart(own[n], e) - insidePart(values[n], e));
  std::copy(values.begin(), values.end(), own);
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
  for (std::size_t s = 0; s < slots_.size(); ++s)
    if (slots_[s].own && std::memcmp(slots_[s].own, baked_->slots()[s].phi, sizeof(BrickValues)) != 0)
      out.add(slots_[s].brick, std::span<const float, kBrickNodes>(slots_[s].own, kBrickNodes));
  return out;
}

std::uint64_t CutObject::stateHash() const { return changedField().stateHash(); }

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
                slot.chunks[c]->z == expected[c].z && slot.chunks[c]->phi == expected[c].phi &&
                slot.chunks[c]->offset == expected[c].offset && slot.chunks[c]->material == expected[c].material;
    defects += !is_same;
  }
  return defects;
}

}  // namespace kerf
