#include "geometry/formats/named_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "geometry/base/text.h"

namespace kerf {

std::string objectName(std::string_view text) {
  const auto isSpace = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
  while (!text.empty() && isSpace(text.front())) text.remove_prefix(1);
  while (!text.empty() && isSpace(text.back())) text.remove_suffix(1);

  // More than can be kept, so that a character cut in two is not kept.
  std::string line(text.substr(0, kLongestObjectName + 4));
  for (char& c : line)
    if (isSpace(c)) c = ' ';
  const std::string clean = printable(line);
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

std::string noteOfTooManyNames() {
  return fmt::format("Names of objects were not read: there are more than {}.", kMostObjectNames);
}

void PartList::begin(std::string_view text, std::size_t first) {
  if (hasTooMany()) return;
  std::string name = objectName(text);
  if (parts_.empty() && first > 0) parts_.push_back({"", 0});
  if (!parts_.empty() && parts_.back().first_triangle == first) parts_.pop_back();  // it got no triangle
  if (!parts_.empty()) count(parts_.back().name);
  if (parts_.empty() || parts_.back().name != name) parts_.push_back({std::move(name), first});
}

std::vector<NamedPart> PartList::finish(std::size_t triangles) {
  if (!parts_.empty() && parts_.back().first_triangle >= triangles) parts_.pop_back();
  if (!parts_.empty()) count(parts_.back().name);
  if (hasTooMany() || names_.empty()) return {};
  return std::move(parts_);
}

void PartList::count(const std::string& name) {
  if (!name.empty()) names_.insert(name);
}

}  // namespace internal
}  // namespace kerf
