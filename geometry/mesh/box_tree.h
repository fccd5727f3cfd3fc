// Tree of boxes: finds the boxes that match a query without testing all of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/base/types.h"

namespace kerf {

/// A box of no extent is a point. The tree splits at the median of the middles along the longest side, so it is
/// balanced for any boxes, and many boxes at one place cost no more than spread ones.
class BoxTree {
 public:
  /// @param boxes  none empty.   @cost O(n log n), 0.3 us per box; 60 bytes per box.
  explicit BoxTree(std::vector<Box3> boxes);

  /// Calls item(n) for boxes[n] of the nodes accepted by may(box of the node), in no particular order. `may` has to
  /// hold for a node's box if it holds for a box in it: overlaps(), contains(). It does not test single items: item()
  /// also gets some for which `may` does not hold. The visit stops once item() returns false.
  /// @return false if item() stopped it.
  template <class May, class Item>
  bool visit(const May& may, const Item& item) const {
    return nodes_.empty() || visitNode(0, may, item);
  }
  const std::vector<Box3>& boxes() const { return boxes_; }

 private:
  struct Node {
    Box3 box;
    std::uint32_t begin, end;  ///< in order_
    std::uint32_t second;      ///< the second child, the first follows the node; 0: a leaf
  };

  std::uint32_t build(std::uint32_t begin, std::uint32_t end);

  template <class May, class Item>
  bool visitNode(std::uint32_t n, const May& may, const Item& item) const {
    const Node& node = nodes_[n];
    if (!may(node.box)) return true;
    if (node.second) return visitNode(n + 1, may, item) && visitNode(node.second, may, item);
    for (std::uint32_t i = node.begin; i < node.end; ++i)
      if (!item(order_[i])) return false;
    return true;
  }

  std::vector<Box3> boxes_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

/// True if the boxes have a point in common.
inline bool overlap(const Box3& a, const Box3& b) {
  return (a.min.array() <= b.max.array()).all() && (b.min.array() <= a.max.array()).all();
}

/// True if `outer` holds all of `inner`.
inline bool holds(const Box3& outer, const Box3& inner) {
  return outer.contains(inner.min) && outer.contains(inner.max);
}

}  // namespace kerf
