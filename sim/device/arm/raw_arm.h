// Reports of Kerf's own profile for force-feedback arms on HID, version 1; docs/reference/rawhid-arm.md has the same
// table for authors of firmware. Fixed layout, little-endian, 64 bytes each way.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "sim/device/frame/device_frame.h"

namespace kerf {

inline constexpr std::uint16_t kRawArmPage = 0xFF4B, kRawArmUsage = 0x0001;
inline constexpr std::uint8_t kRawArmVersion = 1;
inline constexpr std::size_t kRawArmSize = 64;

using RawArmReport = std::array<std::uint8_t, kRawArmSize>;

/// Report from an arm.
RawArmReport encodeRawHand(const HandFrame& hand) noexcept;
FrameFault decodeRawHand(std::span<const std::uint8_t> report, HandFrame& out) noexcept;
/// Report to an arm.
RawArmReport encodeRawForce(const ForceFrame& force) noexcept;
FrameFault decodeRawForce(std::span<const std::uint8_t> report, ForceFrame& out) noexcept;

}  // namespace kerf
