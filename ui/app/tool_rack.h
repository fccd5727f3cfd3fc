// Which tools of the rack a person sees, and in which order.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ui/app/workbench.h"

namespace kerf {

struct RackView {
  std::string_view search = {};                  ///< matchesSearch(); empty: all
  bool shows_all = false;                        ///< without a search: more than the first ones
  std::span<const std::string> favourites = {};  ///< ids, in the order in which they were chosen
};

bool isFavourite(const RackView& view, const Tool& tool);

/// Numbers of tools: first the favourites, as they were chosen, then the others in the order of the rack. Without a
/// search the others are those for a first look (Workbench::firstLookTools()) and the one in hand, or all.
std::vector<std::size_t> rackRows(const Workbench& bench, const RackView& view);

}  // namespace kerf
