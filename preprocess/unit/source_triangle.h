// Marker for "no source triangle".
#pragma once

#include <cstdint>

namespace kerf {

inline constexpr std::uint32_t kAdded = ~0u;  ///< an added triangle, not from the source

}  // namespace kerf
