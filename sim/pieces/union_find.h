// Union-find of numbered items.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace kerf::internal {

/// Root of an item's tree: its smallest member, so that roots do not depend on the order of unions.
/// @param parent  of each item, one not larger than itself; a root is its own.
inline std::uint32_t rootOf(std::vector<std::uint32_t>& parent, std::uint32_t p) {
  while (parent[p] != p) p = parent[p] = parent[parent[p]];
  return p;
}

/// Connects a and b.
inline void unite(std::vector<std::uint32_t>& parent, std::uint32_t a, std::uint32_t b) {
  if (parent[a] == parent[b]) return;  // already joined: the usual case
  const std::uint32_t root_a = rootOf(parent, a), root_b = rootOf(parent, b);
  if (root_a != root_b) parent[std::max(root_a, root_b)] = std::min(root_a, root_b);
}

}  // namespace kerf::internal
