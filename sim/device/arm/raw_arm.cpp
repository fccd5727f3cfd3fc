// Kerf's own profile for force-feedback arms: any vendor's and product's id, recognised by usage page 0xFF4B, usage 1.
//
//   hand, from the arm                          force, to the arm
//   0   'K' 'A'                                 0   'K' 'A'
//   2   u8  version, 1                          2   u8  version, 1
//   3   u8  kind, 1                             3   u8  kind, 2
//   4   u32 number, counts up                   4   u32 number of the hand it answers
//   8   u32 clock of the arm, us                8   u32 clock of that, us
//   12  3 i32 position, 0.1 um                  12  3 i32 force, 0.1 mN
//   24  4 i16 quaternion x y z w, 1/32767       24  3 i32 torque, uN m
//   32  3 i32 velocity, um/s                    36  u16 deadline, ms
//   44  u32 buttons                             38  u8  enabled, 1
//   48  u8  flags: 1 ready, 2 senses            39  up to 63: 0
//           orientation, 4 gives torque
//   49  u8  0
//   50  u16 most force, mN
//   52  u16 most torque, 0.1 mN m
//   54  u16 stiffness it is rated for, N/m; 0: not told
//   56  up to 63: 0
#include "sim/device/arm/raw_arm.h"

#include <algorithm>
#include <cmath>

#include "sim/device/hid/device_driver.h"

namespace kerf {
namespace {

constexpr double kPlaceStep = 1e-4;    // mm
constexpr double kSpeedStep = 1e-3;    // mm/s
constexpr double kForceStep = 1e-4;    // N
constexpr double kTorqueStep = 1e-3;   // N mm
constexpr double kFarthestHand = 1e4;  // mm

using Bytes = std::span<const std::uint8_t>;

template <class Integer>
Integer get(Bytes bytes, std::size_t at) {
  std::uint32_t out = 0;
  for (std::size_t n = 0; n < sizeof(Integer); ++n) out |= std::uint32_t{bytes[at + n]} << (8 * n);
  return static_cast<Integer>(out);
}
void put(RawArmReport& out, std::size_t at, std::size_t size, std::uint32_t value) {
  for (std::size_t n = 0; n < size; ++n) out[at + n] = static_cast<std::uint8_t>(value >> (8 * n));
}
// In steps, clamped to the range.
std::uint32_t steps(double value, double step, double most) {
  const double n = std::isfinite(value) ? std::round(value / step) : 0;
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::clamp(n, -most, most)));
}
constexpr double kMostInt = 2147483647.0, kMostShort = 32767.0, kMostWord = 65535.0;

Vec3d vector(Bytes bytes, std::size_t at, double step) {
  return step * Vec3d(get<std::int32_t>(bytes, at), get<std::int32_t>(bytes, at + 4), get<std::int32_t>(bytes, at + 8));
}
void putVector(RawArmReport& out, std::size_t at, const Vec3d& v, double step) {
  for (int n = 0; n < 3; ++n) put(out, at + 4 * static_cast<std::size_t>(n), 4, steps(v[n], step, kMostInt));
}
RawArmReport begun(std::uint8_t kind) {
  RawArmReport out{};
  out[0] = 'K';
  out[1] = 'A';
  out[2] = kRawArmVersion;
  out[3] = kind;
  return out;
}
FrameFault faultOf(Bytes report, std::uint8_t kind) {
  if (report.size() != kRawArmSize) return FrameFault::kLength;
  if (report[0] != 'K' || report[1] != 'A') return FrameFault::kMagic;
  if (report[2] != kRawArmVersion) return FrameFault::kVersion;
  return report[3] == kind ? FrameFault::kNone : FrameFault::kKind;
}
std::uint32_t microseconds(std::uint64_t ns) { return static_cast<std::uint32_t>(ns / 1000); }

const char* nameOfRawArm(const HidInfo& info) {
  return info.usage_page == kRawArmPage && info.usage == kRawArmUsage ? "RawHID arm" : nullptr;
}

std::size_t writeRawForce(const ForceFrame& force, ArmReportBytes& out) noexcept {
  const RawArmReport report = encodeRawForce(force);
  out[0] = 0;
  std::copy(report.begin(), report.end(), out.begin() + 1);
  return 1 + kRawArmSize;
}

constexpr ArmDriver kRawArmReports{decodeRawHand, writeRawForce};

}  // namespace

RawArmReport encodeRawHand(const HandFrame& hand) noexcept {
  RawArmReport out = begun(1);
  put(out, 4, 4, static_cast<std::uint32_t>(hand.number));
  put(out, 8, 4, microseconds(hand.time_ns));
  putVector(out, 12, hand.pose.translation, kPlaceStep);
  const Eigen::Vector4d q = hand.pose.rotation.coeffs();
  for (int n = 0; n < 4; ++n)
    put(out, 24 + 2 * static_cast<std::size_t>(n), 2, steps(q[n], 1 / kMostShort, kMostShort));
  putVector(out, 32, hand.velocity, kSpeedStep);
  put(out, 44, 4, hand.buttons);
  out[48] = static_cast<std::uint8_t>((hand.is_ready ? 1 : 0) | (hand.senses_orientation ? 2 : 0) |
                                      (hand.gives_torque ? 4 : 0));
  put(out, 50, 2, steps(hand.most_force, 1e-3, kMostWord));
  put(out, 52, 2, steps(hand.most_torque, 0.1, kMostWord));
  put(out, 54, 2, steps(hand.most_stiffness, 1e-3, kMostWord));
  return out;
}

FrameFault decodeRawHand(Bytes report, HandFrame& out) noexcept {
  if (const FrameFault fault = faultOf(report, 1); fault != FrameFault::kNone) return fault;
  const auto part = [&](std::size_t n) { return get<std::int16_t>(report, 24 + 2 * n) / kMostShort; };
  const Eigen::Quaterniond q(part(3), part(0), part(1), part(2));
  if (std::abs(q.norm() - 1) > 1e-3) return FrameFault::kOutOfRange;
  const Vec3d place = vector(report, 12, kPlaceStep);
  if (place.cwiseAbs().maxCoeff() > kFarthestHand) return FrameFault::kOutOfRange;

  out.number = get<std::uint32_t>(report, 4);
  out.time_ns = 1000 * std::uint64_t{get<std::uint32_t>(report, 8)};
  out.pose = {q.normalized(), place};
  out.velocity = vector(report, 32, kSpeedStep);
  out.angular.setZero();
  out.buttons = get<std::uint32_t>(report, 44);
  out.is_ready = report[48] & 1;
  out.senses_orientation = report[48] & 2;
  out.gives_torque = report[48] & 4;
  out.most_force = 1e-3 * get<std::uint16_t>(report, 50);
  out.most_torque = 0.1 * get<std::uint16_t>(report, 52);
  out.most_stiffness = 1e-3 * get<std::uint16_t>(report, 54);
  return FrameFault::kNone;
}

RawArmReport encodeRawForce(const ForceFrame& force) noexcept {
  RawArmReport out = begun(2);
  put(out, 4, 4, static_cast<std::uint32_t>(force.hand_number));
  put(out, 8, 4, microseconds(force.hand_time_ns));
  const bool may = force.is_enabled && force.force.allFinite() && force.torque.allFinite();
  if (may) putVector(out, 12, force.force, kForceStep);
  if (may) putVector(out, 24, force.torque, kTorqueStep);
  put(out, 36, 2, std::min<std::uint32_t>(force.deadline_ms, 65535));
  out[38] = may ? 1 : 0;
  return out;
}

FrameFault decodeRawForce(Bytes report, ForceFrame& out) noexcept {
  if (const FrameFault fault = faultOf(report, 2); fault != FrameFault::kNone) return fault;
  out.hand_number = get<std::uint32_t>(report, 4);
  out.hand_time_ns = 1000 * std::uint64_t{get<std::uint32_t>(report, 8)};
  out.force = vector(report, 12, kForceStep);
  out.torque = vector(report, 24, kTorqueStep);
  out.deadline_ms = get<std::uint16_t>(report, 36);
  out.is_enabled = report[38] == 1;
  return FrameFault::kNone;
}

extern const DeviceDriver kRawArm;
const DeviceDriver kRawArm{"rawhid", "a force-feedback arm by Kerf's profile", nameOfRawArm, nullptr, &kRawArmReports};

}  // namespace kerf
