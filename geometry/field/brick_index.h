// Finds bricks by their coordinate: a number for each stored brick, a bit for each brick wholly inside.
//
// A field of an object has some stored bricks, about its surface, and up to a million deep inside. The stored ones are
// in an open-addressing table: one block of memory, 16 bytes an entry, at most three quarters full. Inner bricks are
// contiguous: 512 bits hold a block of 8^3 bricks, and another such table holds the blocks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/base/types.h"

namespace kerf {

/// Key of an integer coordinate in [-2^20, 2^20)^3: at 0.02 mm voxels that is +-20 m. Below 2^63.
constexpr std::uint64_t coordKey(int i, int j, int k) {
  constexpr std::uint64_t kMask = (1u << 21) - 1, kBias = 1u << 20;
  return ((static_cast<std::uint64_t>(i) + kBias) & kMask) << 42 |
         ((static_cast<std::uint64_t>(j) + kBias) & kMask) << 21 | ((static_cast<std::uint64_t>(k) + kBias) & kMask);
}
inline std::uint64_t coordKey(const Vec3i& c) { return coordKey(c[0], c[1], c[2]); }
constexpr std::array<int, 3> coordOfKey(std::uint64_t key) {
  constexpr std::uint64_t kMask = (1u << 21) - 1;
  constexpr int kBias = 1 << 20;
  return {static_cast<int>(key >> 42 & kMask) - kBias, static_cast<int>(key >> 21 & kMask) - kBias,
          static_cast<int>(key & kMask) - kBias};
}

/// Numbers by key of coordKey(). No iteration over entries: their order depends on the table.
class KeyTable {
 public:
  static constexpr std::int32_t kNone = -1;

  /// The number of a key, or kNone. @cost one look into memory, mostly.
  std::int32_t find(std::uint64_t key) const noexcept {
    if (entries_.empty()) return kNone;
    const std::size_t mask = entries_.size() - 1;
    for (std::size_t at = hashOf(key) & mask;; at = (at + 1) & mask) {
      const Entry& entry = entries_[at];
      if (entry.key == key) return entry.number;
      if (entry.key == kFree) return kNone;
    }
  }
  /// @pre find(key) is kNone; number >= 0. Allocates when the table is full: then it doubles.
  void add(std::uint64_t key, std::int32_t number);
  /// Memory for that many keys in all.
  void reserve(std::size_t keys);

 private:
  static constexpr std::uint64_t kFree = ~std::uint64_t{0};  // no coordinate has this key
  struct Entry {
    std::uint64_t key = kFree;
    std::int32_t number = kNone;
  };
  static std::size_t hashOf(std::uint64_t k) noexcept {  // finaliser of MurmurHash3: brick keys differ in few bits
    k ^= k >> 33;
    k *= 0xff51afd7ed558ccdull;
    k ^= k >> 33;
    k *= 0xc4ceb9fe1a85ec53ull;
    k ^= k >> 33;
    return static_cast<std::size_t>(k);
  }
  void put(std::uint64_t key, std::int32_t number) noexcept;
  void resize(std::size_t entries);

  std::vector<Entry> entries_;  // a power of two of them, or none
  std::size_t count_ = 0;
};

/// Reading is safe from many threads, changing is not.
class BrickIndex {
 public:
  static constexpr std::int32_t kNone = KeyTable::kNone;

  /// The number of a stored brick, or kNone.
  std::int32_t find(const Vec3i& brick) const noexcept { return stored_.find(coordKey(brick)); }
  /// True if a brick is marked as wholly inside. A stored one never is.
  bool isInterior(const Vec3i& brick) const noexcept {
    const std::int32_t block = blocks_.find(coordKey(blockOf(brick)));
    return block != kNone && (bits_[static_cast<std::size_t>(block)][wordOf(brick)] & bitOf(brick)) != 0;
  }

  /// Adds a stored brick and removes its mark. @pre find(brick) is kNone; number >= 0.
  void add(const Vec3i& brick, std::int32_t number);
  /// Does nothing to a stored brick.
  void markInterior(const Vec3i& brick);
  /// The marked bricks, in order of coordKey().
  std::vector<Vec3i> interior() const;
  /// Memory for that many stored bricks in all.
  void reserve(std::size_t bricks) { stored_.reserve(bricks); }

 private:
  using Bits = std::array<std::uint64_t, 8>;  // word i, bit 8 j + k of the brick (i, j, k) of a block

  static Vec3i blockOf(const Vec3i& brick) noexcept { return {brick[0] >> 3, brick[1] >> 3, brick[2] >> 3}; }
  static std::size_t wordOf(const Vec3i& brick) noexcept { return static_cast<std::size_t>(brick[0] & 7); }
  static std::uint64_t bitOf(const Vec3i& brick) noexcept {
    return std::uint64_t{1} << ((brick[1] & 7) << 3 | (brick[2] & 7));
  }

  KeyTable stored_, blocks_;
  std::vector<Vec3i> block_coords_;
  std::vector<Bits> bits_;  // bits of each block
};

}  // namespace kerf
