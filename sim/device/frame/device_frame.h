// Frames between Kerf and a bridge: a small program that knows a vendor's force-feedback device. Version 1, fixed
// layout, little-endian; docs/reference/device-bridge.md has the same table for authors of bridges.
//
//   bridge ──hand frame, about 1000 a second──▶ Kerf         pose, velocity, buttons, what the device can
//   bridge ◀──────────force frame──────────── Kerf           force, torque, enable, deadline
//
// In frames units are SI (m, N, N m), as devices have them; here mm, N, N mm. Functions of their arguments alone. @rt
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "geometry/base/types.h"

namespace kerf {

inline constexpr std::uint32_t kFrameMagic = 0x3144464B;  ///< "KFD1"
inline constexpr std::uint16_t kFrameVersion = 1;
inline constexpr std::size_t kHandFrameSize = 152, kForceFrameSize = 88;  ///< bytes

/// State from the device, in its own frame.
struct HandFrame {
  std::uint64_t number = 0;                                 ///< counts up
  std::uint64_t time_ns = 0;                                ///< of the bridge's clock; returned unchanged
  Rigid3 pose;                                              ///< mm
  Vec3d velocity = Vec3d::Zero(), angular = Vec3d::Zero();  ///< mm/s, rad/s
  std::uint32_t buttons = 0;                                ///< bit n: button n + 1 is down
  bool is_ready = true;                                     ///< calibrated and switched on: it may lead and receive
                                                            ///< force
  bool senses_orientation = true;                           ///< false: the rotation is not used
  bool gives_torque = false;
  double most_force = 3;      ///< N
  double most_torque = 0;     ///< N mm
  double most_stiffness = 1;  ///< N/mm, rated; 0: not reported
};

/// Kerf's request to the device, in the device's frame.
struct ForceFrame {
  std::uint64_t number = 0;
  std::uint64_t hand_number = 0, hand_time_ns = 0;      ///< of the newest hand frame
  Vec3d force = Vec3d::Zero(), torque = Vec3d::Zero();  ///< N, N mm
  bool is_enabled = false;                              ///< false: no force, for any values
  std::uint32_t deadline_ms = 20;                       ///< without another frame in this time the bridge gives no
                                                        ///< force
};

enum class FrameFault { kNone, kLength, kMagic, kVersion, kKind, kNotFinite, kOutOfRange };
/// "its length", for people.
const char* nameOf(FrameFault fault) noexcept;

std::array<std::uint8_t, kHandFrameSize> encode(const HandFrame& frame) noexcept;
std::array<std::uint8_t, kForceFrameSize> encode(const ForceFrame& frame) noexcept;
/// Anything but kNone: `out` keeps its value. Rejects numbers that are not finite, a quaternion that is not of unit
/// length within 1e-3, a place farther away than 10 m, and negative limits.
FrameFault decode(std::span<const std::uint8_t> bytes, HandFrame& out) noexcept;
FrameFault decode(std::span<const std::uint8_t> bytes, ForceFrame& out) noexcept;

}  // namespace kerf
