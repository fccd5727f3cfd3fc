// The inner loop of SHA-256 (FIPS 180-4, section 6.2.2), in the forms that processors offer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace kerf::internal {

/// The eight words of the hash so far.
using Sha256State = std::array<std::uint32_t, 8>;

/// Takes `count` blocks of 64 bytes into the state.
using Sha256Blocks = void (*)(Sha256State& state, const std::byte* blocks, std::size_t count);

/// On any processor. @cost 4.5 ns a byte.
void sha256BlocksPortable(Sha256State& state, const std::byte* blocks, std::size_t count);

/// By the SHA instructions of x86-64; null where this processor has none. @cost 0.6 ns a byte.
Sha256Blocks sha256BlocksByInstructions() noexcept;

/// The fastest form that this processor has. All forms give the same state.
Sha256Blocks sha256BlocksHere() noexcept;

}  // namespace kerf::internal
