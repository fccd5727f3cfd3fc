#include "geometry/formats/named_part.h"

#include <algorithm>
#include <utility>

#include "geometry/base/text.h"

namespace kerf {

std::string objectName(std::string_view text) {
  const auto isEdge = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
  while (!text.empty() && isEdge(text.front())) text.remove_prefix(1);
  while (!text.empty() && isEdge(text.back())) text.remove_suffix(1);

  // More than can be kept, so that a character cut in two is not kept.
  const std::string clean = printable(text.substr(0, kLongestObjectName + 4));
  std::size_t end = 0;
  while (end < clean.size()) {
    const std::size_t length = utf8Length(clean, end);
    if (end + length > kLongestObjectName) break;
    end += length;
  }
  while (end > 0 && clean[end - 1] == ' ') --end;
  return clean.substr(0, end);
}

namespace internal {

void PartList::begin(std::string_view text, std::size_t first) {
  if (has_too_many_) return;
  std::string name = objectName(text);
  if (parts_.empty() && first > 0) parts_.push_back({"", 0});
  if (!parts_.empty() && parts_.back().first_triangle == first) parts_.pop_back();  // it got no triangle
  if (!parts_.empty() && parts_.back().name == name) return;
  has_too_many_ = parts_.size() == kMostNamedParts;
  if (!has_too_many_) parts_.push_back({std::move(name), first});
}

std::vector<NamedPart> PartList::finish(std::size_t count) {
  if (!parts_.empty() && parts_.back().first_triangle >= count) parts_.pop_back();
  const bool is_named = std::any_of(parts_.begin(), parts_.end(), [](const NamedPart& p) { return !p.name.empty(); });
  if (has_too_many_ || !is_named) return {};
  return std::move(parts_);
}

}  // namespace internal
}  // namespace kerf
