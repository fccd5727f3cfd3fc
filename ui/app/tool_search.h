// Finding a tool by what people call it.
#pragma once

#include <string_view>

#include "geometry/tool/tool.h"

namespace kerf {

/// Whether every word of a search is found in a tool: in its id, name, description, shape, kind or ISO 6360 number, or
/// as its diameter: "1.4", "1.4mm" and ISO's "014" are the same. Letters of either case; no word: true.
bool matchesSearch(const Tool& tool, std::string_view search);

}  // namespace kerf
