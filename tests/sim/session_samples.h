// A session for tests. Every tick has a unique sample, so that a tick alone determines the expected value.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "sim/session/session_format.h"
#include "sim/session/session_log.h"

namespace kerf {

inline const SessionHeader kSomeHeader = {{"kerf", "0.1.0"}, {"case.id", "a1b2"}, {"tool", "round-014"}, {"", ""}};

/// Awkward numbers in between: NaN with a payload, -0, infinity, a denormal.
inline DeviceSample sampleOf(std::uint64_t tick) {
  const std::array<double, 5> awkward = {std::bit_cast<double>(0xfff4dead0000beefu), -0.0,
                                         std::numeric_limits<double>::infinity(),
                                         std::numeric_limits<double>::denorm_min(), 1.0 / 3};
  const double x = static_cast<double>(tick);
  DeviceSample s;
  s.T_world_device.rotation.coeffs() << std::sin(x), std::cos(x), 1 / (x + 1), awkward[tick % 5];
  s.T_world_device.translation = Vec3d(0.1 * x, awkward[(tick + 1) % 5], -x);
  s.pedal = awkward[(tick + 2) % 5];
  s.irrigation = std::fmod(0.37 * x, 1);
  s.is_valid = static_cast<std::uint32_t>(tick % 7 != 0);
  return s;
}

inline StateCheck checkOf(std::uint64_t tick) {
  const double x = static_cast<double>(tick);
  return {0x9e3779b97f4a7c15u * (tick + 1), {Vec3d(x, -0.0, 2), Vec3d(std::nan("7"), 1 / (x + 3), 5)}};
}

// Bits, not values: NaN equals itself here, and -0 differs from 0.
template <class T>
std::array<std::byte, sizeof(T)> bitsOf(const T& value) {
  std::array<std::byte, sizeof(T)> bits;
  std::memcpy(bits.data(), &value, sizeof(T));
  return bits;
}
inline bool sameBits(double a, double b) { return bitsOf(a) == bitsOf(b); }
inline bool sameBits(const Vec3d& a, const Vec3d& b) {
  return sameBits(a[0], b[0]) && sameBits(a[1], b[1]) && sameBits(a[2], b[2]);
}
/// Field by field and independent of the packing under test.
inline bool sameBits(const DeviceSample& a, const DeviceSample& b) {
  const Eigen::Quaterniond &p = a.T_world_device.rotation, &q = b.T_world_device.rotation;
  return sameBits(p.w(), q.w()) && sameBits(Vec3d(p.vec()), Vec3d(q.vec())) &&
         sameBits(a.T_world_device.translation, b.T_world_device.translation) && sameBits(a.pedal, b.pedal) &&
         sameBits(a.irrigation, b.irrigation) && a.is_valid == b.is_valid;
}
inline bool sameBits(const StateCheck& a, const StateCheck& b) {
  return a.state_hash == b.state_hash && sameBits(a.force.force, b.force.force) &&
         sameBits(a.force.torque, b.force.torque);
}
inline bool sameEvent(const SessionEvent& a, const SessionEvent& b) {
  if (a.tick != b.tick || a.samples_before != b.samples_before || a.what.index() != b.what.index()) return false;
  if (const auto* x = std::get_if<SessionCommand>(&a.what)) return x->text == std::get<SessionCommand>(b.what).text;
  if (const auto* x = std::get_if<StateCheck>(&a.what)) return sameBits(*x, std::get<StateCheck>(b.what));
  if (const auto* x = std::get_if<StrokeMark>(&a.what)) return *x == std::get<StrokeMark>(b.what);
  if (const auto* x = std::get_if<SessionGap>(&a.what)) return x->lost == std::get<SessionGap>(b.what).lost;
  const auto &x = std::get<SessionSnapshot>(a.what), &y = std::get<SessionSnapshot>(b.what);
  return x.size == y.size && x.packed == y.packed;
}

/// Whether `part` is a prefix of `whole`: required of every read of a damaged log.
inline bool isBeginning(const SessionLog& part, const SessionLog& whole) {
  if (part.header != whole.header || part.samples.size() > whole.samples.size() ||
      part.events.size() > whole.events.size())
    return false;
  for (std::size_t i = 0; i < part.samples.size(); ++i)
    if (part.samples[i].tick != whole.samples[i].tick || !sameBits(part.samples[i].sample, whole.samples[i].sample))
      return false;
  for (std::size_t i = 0; i < part.events.size(); ++i)
    if (!sameEvent(part.events[i], whole.events[i])) return false;
  return true;
}

}  // namespace kerf
