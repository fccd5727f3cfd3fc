// Blocks and pieces: how PieceFinder joins the parts of bricks to groups of blocks, and groups to pieces.
#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <utility>

#include "sim/pieces/pieces.h"
#include "sim/pieces/union_find.h"

namespace kerf {

void PieceFinder::Group::add(const Group& other) {
  measure.add(other.measure);
  low = low.cwiseMin(other.low);
  high = high.cwiseMax(other.high);
  first = std::min(first, other.first);
}

const PieceList& PieceFinder::find() {
  if (is_current_) return list_;
  for (Block& block : blocks_)
    if (block.is_changed) groupParts(block);
  joinBlocks();
  listPieces(mergeGroups());
  is_current_ = true;
  return list_;
}

// Calls unite(part of a, part of b) for parts that meet in the face of a towards b, its upper neighbour along the axis.
// Where both have one part, as nearly all bricks do, a look at two masks is enough.
template <class Unite>
void PieceFinder::joinBricks(std::int32_t a, std::int32_t b, int axis, const Unite& unite) const {
  const auto side = static_cast<std::size_t>(2 * axis + 1);
  std::uint64_t both = face(a, side) & face(b, side ^ 1);
  if (!both) return;
  if (partCount(a) == 1 && partCount(b) == 1) {
    unite(0u, 0u);
    return;
  }
  for (; both; both &= both - 1) {
    const int n = std::countr_zero(both);
    unite(partAt(a, internal::faceNode(side, n)), partAt(b, internal::faceNode(side ^ 1, n)));
  }
}

// Unites the touching parts of one block, in parent_. Its parts are numbered slot by slot: first_part_.
void PieceFinder::uniteParts(const Block& block) {
  const std::uint32_t mine = block_of_[indexOf(block.slots.front())];
  first_part_.resize(keys_.size());  // valid for the slots of this block only
  parent_.clear();
  for (const std::int32_t slot : block.slots) {
    first_part_[indexOf(slot)] = static_cast<std::uint32_t>(parent_.size());
    for (std::uint32_t p = partCount(slot); p > 0; --p) parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
  }

  for (const std::int32_t slot : block.slots) {
    if (partCount(slot) == 0) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int32_t next = neighbors_[indexOf(slot)][static_cast<std::size_t>(2 * axis + 1)];
      if (next == kNoSlot || block_of_[indexOf(next)] != mine) continue;
      joinBricks(slot, next, axis, [&](std::uint32_t a, std::uint32_t b) {
        internal::unite(parent_, first_part_[indexOf(slot)] + a, first_part_[indexOf(next)] + b);
      });
    }
  }
}

// Makes the groups of one block.
void PieceFinder::groupParts(Block& block) {
  uniteParts(block);

  block.groups.clear();
  std::vector<std::uint32_t> group_of(parent_.size());
  for (const std::int32_t slot : block.slots) {
    const std::size_t s = indexOf(slot);
    const Vec3i base = internal::coordOf(keys_[s]) * kBrickSide;
    const std::uint32_t parts = partCount(slot);
    for (std::uint32_t n = 0; n < parts; ++n) {
      const std::uint32_t p = first_part_[s] + n, root = internal::rootOf(parent_, p);
      if (root == p) {
        group_of[p] = static_cast<std::uint32_t>(block.groups.size());
        block.groups.push_back({{},
                                Vec3i::Constant(std::numeric_limits<int>::max()),
                                Vec3i::Constant(std::numeric_limits<int>::min()),
                                internal::kAllNodes});
      }
      group_of[p] = group_of[root];

      Group& group = block.groups[group_of[p]];
      if (parts_of_[s] == kFull) {
        group_of_full_[s] = group_of[p];
        group.add({{kBrickNodes, 0}, base, base + Vec3i::Constant(kBrickSide - 1), coordKey(base)});
        continue;
      }
      internal::BrickPart& part = parts_[indexOf(parts_of_[s])].parts[n];
      part.group = group_of[p];
      const Vec3i first = base + Vec3i{part.first >> 6, part.first >> 3 & 7, part.first & 7};
      group.add({part.measure, base + Vec3i{part.low[0], part.low[1], part.low[2]},
                 base + Vec3i{part.high[0], part.high[1], part.high[2]}, coordKey(first)});
    }
  }
}

// Finds the pairs of its groups and groups of the block above that meet.
void PieceFinder::joinAbove(Block& block, int axis) const {
  auto& joins = block.joins[static_cast<std::size_t>(axis)];
  joins.clear();
  const std::int32_t above = block.above[static_cast<std::size_t>(axis)];
  if (above == kNoSlot) return;
  for (const std::int32_t slot : block.slots) {
    const std::int32_t next = neighbors_[indexOf(slot)][static_cast<std::size_t>(2 * axis + 1)];
    if (next == kNoSlot || block_of_[indexOf(next)] != static_cast<std::uint32_t>(above)) continue;
    joinBricks(slot, next, axis, [&](std::uint32_t a, std::uint32_t b) {
      const std::pair pair(groupOf(slot, a), groupOf(next, b));
      if (std::find(joins.rbegin(), joins.rend(), pair) == joins.rend()) joins.push_back(pair);
    });
  }
}

// Updates the joins of changed blocks and of those below them, and the numbers of all groups.
void PieceFinder::joinBlocks() {
  const auto isChangedAbove = [&](const Block& block, int axis) {
    const std::int32_t above = block.above[static_cast<std::size_t>(axis)];
    return above != kNoSlot && blocks_[indexOf(above)].is_changed;
  };
  std::uint32_t groups = 0;
  for (Block& block : blocks_) {
    for (int axis = 0; axis < 3; ++axis)
      if (block.is_changed || isChangedAbove(block, axis)) joinAbove(block, axis);
    block.first_group = groups;
    groups += static_cast<std::uint32_t>(block.groups.size());
  }
  for (Block& block : blocks_) block.is_changed = false;
  piece_of_group_.resize(groups);
}

// Merges joined groups. piece_of_group_ holds the number of each group's result.
std::vector<PieceFinder::Group> PieceFinder::mergeGroups() {
  std::vector<std::uint32_t> parent(piece_of_group_.size());
  std::iota(parent.begin(), parent.end(), 0u);
  for (const Block& block : blocks_)
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const auto& [a, b] : block.joins[axis])
        internal::unite(parent, block.first_group + a, blocks_[indexOf(block.above[axis])].first_group + b);

  std::vector<Group> merged;
  for (const Block& block : blocks_)
    for (std::uint32_t n = 0; n < block.groups.size(); ++n) {
      const std::uint32_t group = block.first_group + n, root = internal::rootOf(parent, group);
      if (root == group) {
        piece_of_group_[group] = static_cast<std::uint32_t>(merged.size());
        merged.push_back(block.groups[n]);
      } else {
        piece_of_group_[group] = piece_of_group_[root];
        merged[piece_of_group_[group]].add(block.groups[n]);
      }
    }
  return merged;
}

// Sorts the pieces, separates the crumbs, and assigns ids.
void PieceFinder::listPieces(const std::vector<Group>& found) {
  const double h = field_.voxel();
  list_ = {};
  std::vector<Piece> all(found.size());
  for (std::size_t n = 0; n < found.size(); ++n) {
    all[n].id = static_cast<std::uint32_t>(n);  // final numbers follow after sorting
    all[n].measure = found[n].measure;
    all[n].volume = found[n].measure.volume(h);
    all[n].bounds.add(h * found[n].low.cast<double>());
    all[n].bounds.add(h * found[n].high.cast<double>());
    all[n].first_node = internal::coordOf(found[n].first);
    list_.whole.add(found[n].measure);
  }
  std::sort(all.begin(), all.end(), [&](const Piece& a, const Piece& b) {
    return a.volume != b.volume ? a.volume > b.volume : found[a.id].first < found[b.id].first;
  });

  std::vector<std::uint32_t> renamed(all.size());
  for (std::size_t n = 0; n < all.size(); ++n) {
    renamed[all[n].id] = static_cast<std::uint32_t>(n);
    all[n].id = static_cast<std::uint32_t>(n);
    (all[n].volume < options_.crumb_mm3 ? list_.crumbs : list_.pieces).push_back(all[n]);
  }
  for (std::uint32_t& p : piece_of_group_) p = renamed[p];
}

}  // namespace kerf
