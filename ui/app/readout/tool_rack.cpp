#include "ui/app/readout/tool_rack.h"

#include <algorithm>

#include "ui/app/tool/tool_search.h"
#include "ui/app/workbench/tools.h"

namespace kerf {

bool isFavourite(const RackView& view, const Tool& tool) {
  return std::find(view.favourites.begin(), view.favourites.end(), tool.id) != view.favourites.end();
}

std::vector<std::size_t> rackRows(const Workbench& bench, const RackView& view) {
  const auto isWanted = [&](std::size_t n) {
    if (!view.search.empty()) return matchesSearch(bench.tools->at(n), view.search);
    return view.shows_all || n < bench.tools->firstLook() || n == bench.tools->inHand() ||
           isFavourite(view, bench.tools->at(n));
  };

  std::vector<std::size_t> out;
  for (const std::string& id : view.favourites)
    for (std::size_t n = 0; n < bench.tools->count(); ++n)
      if (bench.tools->at(n).id == id && isWanted(n)) out.push_back(n);
  for (std::size_t n = 0; n < bench.tools->count(); ++n)
    if (!isFavourite(view, bench.tools->at(n)) && isWanted(n)) out.push_back(n);
  return out;
}

}  // namespace kerf
