// Joins points with exactly equal coordinates, numbering them in order of first appearance.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "geometry/base/types.h"

namespace kerf::internal {

/// Open-addressing table of vertex indices. 0.0 and -0.0 are equal; the bits of the first appearance stay.
class ExactWelder {
 public:
  explicit ExactWelder(std::size_t expected_vertices) : table_(std::bit_ceil(2 * expected_vertices + 16), kFree) {
    vertices.reserve(expected_vertices);
  }

  std::uint32_t add(const Vec3d& p) {
    if (2 * (vertices.size() + 1) > table_.size()) grow();
    std::uint32_t& entry = table_[slotOf(p)];
    if (entry == kFree) {
      entry = static_cast<std::uint32_t>(vertices.size());
      vertices.push_back(p);
    }
    return entry;
  }

  static constexpr std::uint32_t kNotThere = ~0u;
  /// The point's number from add(), or kNotThere.
  std::uint32_t find(const Vec3d& p) const { return table_[slotOf(p)]; }

  std::vector<Vec3d> vertices;

 private:
  static constexpr std::uint32_t kFree = kNotThere;

  // Slot of the point, or the free slot for it.
  std::size_t slotOf(const Vec3d& p) const {
    const std::size_t mask = table_.size() - 1;
    std::size_t slot = hash(p) & mask;
    while (table_[slot] != kFree && vertices[table_[slot]] != p) slot = (slot + 1) & mask;
    return slot;
  }

  static std::size_t hash(const Vec3d& p) {
    std::uint64_t h = 0x9e3779b97f4a7c15ull;
    for (int k = 0; k < 3; ++k) {
      h ^= std::bit_cast<std::uint64_t>(p[k] + 0.0);  // + 0.0 turns -0.0 into 0.0
      h *= 0xff51afd7ed558ccdull;
      h ^= h >> 32;
    }
    return static_cast<std::size_t>(h);
  }

  void grow() {
    std::vector<std::uint32_t> bigger(2 * table_.size(), kFree);
    for (std::uint32_t i = 0; i < vertices.size(); ++i) {
      std::size_t slot = hash(vertices[i]);
      while (bigger[slot & (bigger.size() - 1)] != kFree) ++slot;
      bigger[slot & (bigger.size() - 1)] = i;
    }
    table_ = std::move(bigger);
  }

  std::vector<std::uint32_t> table_;
};

}  // namespace kerf::internal
