// What stands for "no source triangle".
#pragma once

#include <cstdint>

namespace kerf {

inline constexpr std::uint32_t kAdded = ~0u;  ///< a triangle that is not from the source

}  // namespace kerf
