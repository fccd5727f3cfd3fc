// Text search for a tool.
#pragma once

#include <string_view>

#include "geometry/tool/tool.h"

namespace kerf {

/// True if a tool has every word of a search: in its id, name, description, shape, kind or ISO 6360 number, or as its
/// diameter: "1.4", "1.4mm" and ISO's "014" are the same. Ignores case; true without a word.
bool matchesSearch(const Tool& tool, std::string_view search);

}  // namespace kerf
