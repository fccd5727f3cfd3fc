// Slots and bricks: PieceFinder's data of each single brick. piece_groups.cpp joins them.
#include "sim/pieces/pieces.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>

namespace kerf {
namespace {

void sortOnce(std::vector<std::int32_t>& slots) {
  std::sort(slots.begin(), slots.end());
  slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
}

}  // namespace

PieceFinder::PieceFinder(const BrickField& phi0, const PieceOptions& options) : field_(phi0), options_(options) {
  const std::vector<Vec3i> interior = phi0.interiorBricks();
  keys_.reserve(phi0.brickCount() + interior.size());
  for (std::size_t b = 0; b < phi0.brickCount(); ++b) keys_.push_back(coordKey(phi0.brickCoord(b)));
  for (const Vec3i& c : interior) keys_.push_back(coordKey(c));
  scanAll();
}

PieceFinder::PieceFinder(const BrickField& phi0, std::span<const Vec3i> bricks, const PieceOptions& options)
    : field_(phi0), options_(options) {
  for (const Vec3i& c : bricks)
    if (field_.valuesAt(c) || field_.constantAt(c) < 0) keys_.push_back(coordKey(c));
  scanAll();
}

void PieceFinder::scanAll() {
  std::sort(keys_.begin(), keys_.end());
  const std::size_t count = first_count_ = keys_.size();
  layDirectory();
  is_baked_.resize(count);
  for (std::size_t s = 0; s < count; ++s)
    is_baked_[s] = field_.baked().valuesAt(internal::coordOf(keys_[s])) != nullptr;
  findNeighbors();

  // Parts of all bricks with values, then their fringes, which read the neighbours' faces.
  parts_of_.assign(count, kFull);
  std::vector<std::int32_t> stored;
  for (std::size_t s = 0; s < count; ++s) {
    if (!field_.valuesAt(internal::coordOf(keys_[s]))) continue;
    parts_of_[s] = static_cast<std::int32_t>(stored.size());
    stored.push_back(static_cast<std::int32_t>(s));
  }
  parts_.resize(stored.size());
  tbb::parallel_for(std::size_t{0}, stored.size(), [&](std::size_t n) {
    internal::findParts(*field_.valuesAt(internal::coordOf(keys_[indexOf(stored[n])])), parts_[n]);
  });
  tbb::parallel_for(std::size_t{0}, stored.size(), [&](std::size_t n) { measureFringeOf(stored[n]); });

  // Bricks stored as a constant rarely have a fringe: only where they border on a node that is not inside.
  for (std::size_t s = 0; s < count; ++s) {
    const auto slot = static_cast<std::int32_t>(s);
    if (parts_of_[s] == kFull && touchesOutside(slot)) {
      partsOf(slot);
      measureFringeOf(slot);
    }
  }

  block_of_.reserve(count);
  group_of_full_.reserve(count);
  for (std::size_t s = 0; s < count; ++s) addToBlock(static_cast<std::int32_t>(s));
}

// The box of all slots, with air around it for fills without a new layout.
void PieceFinder::layDirectory() {
  Vec3i low = Vec3i::Constant(std::numeric_limits<int>::max()), high = -low;
  for (const std::uint64_t key : keys_) {
    low = low.cwiseMin(internal::coordOf(key));
    high = high.cwiseMax(internal::coordOf(key));
  }
  if (keys_.empty()) low = high = Vec3i::Zero();

  constexpr int kAir = 4;
  directory_ = BrickDirectory(low - Vec3i::Constant(kAir), high - low + Vec3i::Constant(1 + 2 * kAir));
  for (std::size_t s = 0; s < keys_.size(); ++s)
    directory_.set(directory_.indexOf(internal::coordOf(keys_[s])), static_cast<std::int32_t>(s));
}

// Upper neighbours come in the order of the bricks themselves: one pointer per axis walks along.
void PieceFinder::findNeighbors() {
  const std::size_t count = keys_.size();
  neighbors_.assign(count, {kNoSlot, kNoSlot, kNoSlot, kNoSlot, kNoSlot, kNoSlot});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::size_t above = 0;
    for (std::size_t s = 0; s < count; ++s) {
      const std::uint64_t wanted = coordKey(internal::beside(internal::coordOf(keys_[s]), 2 * axis + 1));
      while (above < count && keys_[above] < wanted) ++above;
      if (above == count) break;
      if (keys_[above] != wanted) continue;
      neighbors_[s][2 * axis + 1] = static_cast<std::int32_t>(above);
      neighbors_[above][2 * axis] = static_cast<std::int32_t>(s);
    }
  }
}

std::int32_t PieceFinder::addSlot(const Vec3i& brick) {
  const auto slot = static_cast<std::int32_t>(keys_.size());
  keys_.push_back(coordKey(brick));
  is_baked_.push_back(0);
  if (directory_.contains(brick))
    directory_.set(directory_.indexOf(brick), slot);
  else
    layDirectory();

  parts_of_.push_back(kOutside);
  std::array<std::int32_t, 6>& mine = neighbors_.emplace_back();
  for (std::size_t side = 0; side < 6; ++side) {
    mine[side] = slotOf(internal::beside(brick, side));
    if (mine[side] != kNoSlot) neighbors_[indexOf(mine[side])][side ^ 1] = slot;
  }
  addToBlock(slot);
  return slot;
}

void PieceFinder::addToBlock(std::int32_t slot) {
  const Vec3i at = brickOf(internal::coordOf(keys_[indexOf(slot)]));  // a block has bricks as a brick has nodes
  const auto [known, is_new] = block_at_.try_emplace(coordKey(at), static_cast<std::int32_t>(blocks_.size()));
  const std::int32_t b = known->second;
  if (is_new) {
    blocks_.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto above = block_at_.find(coordKey(internal::beside(at, 2 * axis + 1)));
      if (above != block_at_.end()) blocks_.back().above[axis] = above->second;
      const auto below = block_at_.find(coordKey(internal::beside(at, 2 * axis)));
      if (below != block_at_.end()) blocks_[indexOf(below->second)].above[axis] = b;
    }
  }
  Block& block = blocks_[indexOf(b)];
  block.slots.push_back(slot);
  block.is_changed = true;
  block_of_.push_back(static_cast<std::uint32_t>(b));
  group_of_full_.push_back(0);
}

// Makes parts for a brick that was all inside or all outside so far.
internal::BrickParts& PieceFinder::partsOf(std::int32_t slot) {
  std::int32_t& index = parts_of_[indexOf(slot)];
  if (index < 0) {
    const bool is_full = index == kFull;
    index = static_cast<std::int32_t>(parts_.size());
    internal::BrickParts& made = parts_.emplace_back();
    if (is_full) internal::makeFull(made);
  }
  return parts_[indexOf(index)];
}

std::uint32_t PieceFinder::partCount(std::int32_t slot) const {
  const std::int32_t index = parts_of_[indexOf(slot)];
  if (index < 0) return index == kFull ? 1 : 0;
  return static_cast<std::uint32_t>(parts_[indexOf(index)].parts.size());
}

std::uint64_t PieceFinder::face(std::int32_t slot, std::size_t side) const {
  if (slot == kNoSlot) return 0;
  const std::int32_t index = parts_of_[indexOf(slot)];
  if (index < 0) return index == kFull ? internal::kAllNodes : 0;
  return parts_[indexOf(index)].faces[side];
}

// The touching face of the neighbour on a side.
std::uint64_t PieceFinder::faceBeside(std::int32_t slot, std::size_t side) const {
  return face(neighbors_[indexOf(slot)][side], side ^ 1);
}

bool PieceFinder::touchesOutside(std::int32_t slot) const {
  for (std::size_t side = 0; side < 6; ++side)
    if (faceBeside(slot, side) != internal::kAllNodes) return true;
  return false;
}

// @pre the slot has parts of its own, or none.
void PieceFinder::measureFringeOf(std::int32_t slot) {
  auto& own = parts_[indexOf(parts_of_[indexOf(slot)])];
  if (own.parts.empty()) {  // most bricks of the outer band: no look-up of neighbours
    own.outermost = {};
    return;
  }

  const Vec3i brick = internal::coordOf(keys_[indexOf(slot)]);
  internal::FringeInput in;
  in.own = {field_.valuesAt(brick), field_.constantAt(brick)};
  for (std::size_t side = 0; side < 6; ++side) {
    const Vec3i next = internal::beside(brick, side);
    in.beside[side] = {field_.valuesAt(next), field_.constantAt(next)};
    in.faces_beside[side] = faceBeside(slot, side);
  }
  internal::measureFringe(in, own);
}

void PieceFinder::apply(std::span<const BrickEdit> edits) {
  if (edits.empty()) return;
  is_current_ = false;

  std::vector<std::int32_t> changed;
  for (const BrickEdit& edit : edits) {
    field_.set(edit);
    std::int32_t slot = slotOf(edit.brick);
    if (slot == kNoSlot) slot = addSlot(edit.brick);
    changed.push_back(slot);
  }
  sortOnce(changed);

  // First their parts, then their own and their neighbours' fringes.
  std::vector<std::int32_t> measured = changed;
  for (const std::int32_t slot : changed) {
    internal::findParts(*field_.valuesAt(internal::coordOf(keys_[indexOf(slot)])), partsOf(slot));
    blocks_[block_of_[indexOf(slot)]].is_changed = true;
    for (const std::int32_t next : neighbors_[indexOf(slot)])
      if (next != kNoSlot) measured.push_back(next);
  }
  sortOnce(measured);
  for (const std::int32_t slot : measured) {
    const std::int32_t index = parts_of_[indexOf(slot)];
    if (index == kOutside || (index == kFull && !touchesOutside(slot))) continue;
    partsOf(slot);
    measureFringeOf(slot);
    blocks_[block_of_[indexOf(slot)]].is_changed = true;
  }
}

}  // namespace kerf
