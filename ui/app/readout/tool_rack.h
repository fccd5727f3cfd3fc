// Selection and order of the tools shown in the rack.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/tool/tool.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

struct RackView {
  std::string_view search = {};                  ///< matchesSearch(); empty: all
  bool shows_all = false;                        ///< without a search: more than the leading ones
  std::span<const std::string> favourites = {};  ///< ids, in the order of choice
};

bool isFavourite(const RackView& view, const Tool& tool);

/// Indices of tools: first the favourites in the order of choice, then the others in the order of the rack. Without a
/// search the others are those for a first look (Workbench::firstLookTools()) and the one in hand, or all.
std::vector<std::size_t> rackRows(const Workbench& bench, const RackView& view);

}  // namespace kerf
