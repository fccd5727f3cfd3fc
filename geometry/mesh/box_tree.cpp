#include "geometry/mesh/box_tree.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace kerf {
namespace {

constexpr std::uint32_t kLeaf = 8;

}  // namespace

BoxTree::BoxTree(std::vector<Box3> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  nodes_.reserve(boxes_.size() / (kLeaf / 4) + 1);
  if (!boxes_.empty()) build(0, static_cast<std::uint32_t>(boxes_.size()));
}

std::uint32_t BoxTree::build(std::uint32_t begin, std::uint32_t end) {
  const auto n = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({{}, begin, end, 0});
  for (std::uint32_t i = begin; i < end; ++i) nodes_[n].box.add(boxes_[order_[i]]);
  if (end - begin <= kLeaf) return n;

  int axis = 0;
  nodes_[n].box.size().maxCoeff(&axis);
  const std::uint32_t middle = begin + (end - begin) / 2;
  const auto place = [&](std::uint32_t i) { return 0.5 * boxes_[i].min[axis] + 0.5 * boxes_[i].max[axis]; };
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double x = place(a), y = place(b);
                     return x != y ? x < y : a < b;
                   });
  build(begin, middle);
  const std::uint32_t second = build(middle, end);
  nodes_[n].second = second;
  return n;
}

}  // namespace kerf
