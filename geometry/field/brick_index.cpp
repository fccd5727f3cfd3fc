#include "geometry/field/brick_index.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <utility>

namespace kerf {
namespace {

constexpr std::size_t kFewest = 16;  // entries of a table that is not empty

// At most three quarters of the entries are used.
constexpr std::size_t entriesFor(std::size_t keys) { return std::max(kFewest, std::bit_ceil(keys + (keys + 2) / 3)); }

}  // namespace

void KeyTable::add(std::uint64_t key, std::int32_t number) {
  assert(key != kFree && number >= 0 && find(key) == kNone);
  if (entriesFor(count_ + 1) > entries_.size()) resize(entriesFor(count_ + 1));
  put(key, number);
  ++count_;
}

void KeyTable::reserve(std::size_t keys) {
  if (keys > 0 && entriesFor(keys) > entries_.size()) resize(entriesFor(keys));
}

void KeyTable::put(std::uint64_t key, std::int32_t number) noexcept {
  const std::size_t mask = entries_.size() - 1;
  std::size_t at = hashOf(key) & mask;
  while (entries_[at].key != kFree) at = (at + 1) & mask;
  entries_[at] = {key, number};
}

void KeyTable::resize(std::size_t entries) {
  const std::vector<Entry> before = std::exchange(entries_, std::vector<Entry>(entries));
  for (const Entry& entry : before)
    if (entry.key != kFree) put(entry.key, entry.number);
}

void BrickIndex::add(const Vec3i& brick, std::int32_t number) {
  stored_.add(coordKey(brick), number);
  const std::int32_t block = blocks_.find(coordKey(blockOf(brick)));
  if (block != kNone) bits_[static_cast<std::size_t>(block)][wordOf(brick)] &= ~bitOf(brick);
}

void BrickIndex::markInterior(const Vec3i& brick) {
  if (find(brick) != kNone) return;
  const Vec3i at = blockOf(brick);
  std::int32_t block = blocks_.find(coordKey(at));
  if (block == kNone) {
    block = static_cast<std::int32_t>(bits_.size());
    blocks_.add(coordKey(at), block);
    block_coords_.push_back(at);
    bits_.emplace_back();
  }
  bits_[static_cast<std::size_t>(block)][wordOf(brick)] |= bitOf(brick);
}

std::vector<Vec3i> BrickIndex::interior() const {
  std::vector<std::size_t> blocks(bits_.size());
  std::size_t bricks = 0;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    blocks[b] = b;
    for (const std::uint64_t word : bits_[b]) bricks += static_cast<std::size_t>(std::popcount(word));
  }
  std::sort(blocks.begin(), blocks.end(),
            [this](std::size_t a, std::size_t b) { return coordKey(block_coords_[a]) < coordKey(block_coords_[b]); });

  // Layer by layer of the blocks that share x, row by row of those that share x and y.
  std::vector<Vec3i> out;
  out.reserve(bricks);
  const auto endOf = [&](std::size_t first, int axes) {
    std::size_t end = first + 1;
    while (end < blocks.size() && block_coords_[blocks[end]].head(axes) == block_coords_[blocks[first]].head(axes))
      ++end;
    return end;
  };
  for (std::size_t layer = 0, layer_end = 0; layer < blocks.size(); layer = layer_end) {
    layer_end = endOf(layer, 1);
    for (std::size_t i = 0; i < 8; ++i)
      for (std::size_t row = layer, row_end = 0; row < layer_end; row = row_end) {
        row_end = endOf(row, 2);
        for (int j = 0; j < 8; ++j)
          for (std::size_t n = row; n < row_end; ++n) {
            const Vec3i first = 8 * block_coords_[blocks[n]] + Vec3i(static_cast<int>(i), j, 0);
            for (std::uint64_t bits = bits_[blocks[n]][i] >> 8 * j & 0xff; bits != 0; bits &= bits - 1)
              out.emplace_back(first[0], first[1], first[2] + std::countr_zero(bits));
          }
      }
  }
  return out;
}

}  // namespace kerf
