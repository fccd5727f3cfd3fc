#include "sim/device/frame/device_frame.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace kerf {
namespace {

constexpr std::uint16_t kFromHand = 1, kToHand = 2;
constexpr double kMm = 1000;            // in a m
constexpr double kFarthest = 10 * kMm;  // mm
constexpr std::uint32_t kReady = 1, kOrientation = 2, kTorque = 4;

class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> bytes) : bytes_(bytes) {}
  template <class Whole>
  void whole(Whole value) noexcept {
    for (std::size_t n = 0; n < sizeof value; ++n) bytes_[at_++] = static_cast<std::uint8_t>(value >> (8 * n));
  }
  void number(double value) noexcept { whole(std::bit_cast<std::uint64_t>(value)); }
  void small(double value) noexcept { whole(std::bit_cast<std::uint32_t>(static_cast<float>(value))); }
  void vector(const Vec3d& v, double scale) noexcept {
    for (int n = 0; n < 3; ++n) number(v[n] * scale);
  }
  void head(std::uint16_t kind) noexcept {
    whole(kFrameMagic);
    whole(kFrameVersion);
    whole(kind);
  }

 private:
  std::span<std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  template <class Whole>
  Whole whole() noexcept {
    Whole value = 0;
    for (std::size_t n = 0; n < sizeof value; ++n)
      value = static_cast<Whole>(value | static_cast<Whole>(bytes_[at_++]) << (8 * n));
    return value;
  }
  double number() noexcept { return finite(std::bit_cast<double>(whole<std::uint64_t>())); }
  double small() noexcept { return finite(std::bit_cast<float>(whole<std::uint32_t>())); }
  Vec3d vector(double scale) noexcept {
    const double x = number(), y = number(), z = number();
    const Vec3d scaled = scale * Vec3d(x, y, z);
    is_finite_ = is_finite_ && scaled.allFinite();  // a huge number may overflow in mm
    return scaled;
  }
  bool isFinite() const noexcept { return is_finite_; }
  FrameFault head(std::uint16_t kind) noexcept {
    if (whole<std::uint32_t>() != kFrameMagic) return FrameFault::kMagic;
    if (whole<std::uint16_t>() != kFrameVersion) return FrameFault::kVersion;
    return whole<std::uint16_t>() == kind ? FrameFault::kNone : FrameFault::kKind;
  }

 private:
  double finite(double value) noexcept {
    is_finite_ = is_finite_ && std::isfinite(value);
    return value;
  }
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool is_finite_ = true;
};

}  // namespace

const char* nameOf(FrameFault fault) noexcept {
  switch (fault) {
    case FrameFault::kNone:
      return "nothing";
    case FrameFault::kLength:
      return "its length";
    case FrameFault::kMagic:
      return "its first four bytes";
    case FrameFault::kVersion:
      return "its version";
    case FrameFault::kKind:
      return "its kind";
    case FrameFault::kNotFinite:
      return "a number that is not finite";
    case FrameFault::kOutOfRange:
      break;
  }
  return "a number out of range";
}

std::array<std::uint8_t, kHandFrameSize> encode(const HandFrame& f) noexcept {
  std::array<std::uint8_t, kHandFrameSize> bytes{};
  Writer out(bytes);
  out.head(kFromHand);
  out.whole(f.number);
  out.whole(f.time_ns);
  out.vector(f.pose.translation, 1 / kMm);
  for (int n = 0; n < 4; ++n) out.number(f.pose.rotation.coeffs()[n]);
  out.vector(f.velocity, 1 / kMm);
  out.vector(f.angular, 1);
  out.whole(f.buttons);
  out.whole((f.is_ready ? kReady : 0) | (f.senses_orientation ? kOrientation : 0) | (f.gives_torque ? kTorque : 0));
  out.small(f.most_force);
  out.small(f.most_torque / kMm);
  out.small(f.most_stiffness * kMm);
  out.small(0);
  return bytes;
}

FrameFault decode(std::span<const std::uint8_t> bytes, HandFrame& out) noexcept {
  if (bytes.size() != kHandFrameSize) return FrameFault::kLength;
  Reader in(bytes);
  if (const FrameFault fault = in.head(kFromHand); fault != FrameFault::kNone) return fault;
  HandFrame f;
  f.number = in.whole<std::uint64_t>();
  f.time_ns = in.whole<std::uint64_t>();
  f.pose.translation = in.vector(kMm);
  for (int n = 0; n < 4; ++n) f.pose.rotation.coeffs()[n] = in.number();
  f.velocity = in.vector(kMm);
  f.angular = in.vector(1);
  f.buttons = in.whole<std::uint32_t>();
  const auto flags = in.whole<std::uint32_t>();
  f.is_ready = flags & kReady;
  f.senses_orientation = flags & kOrientation;
  f.gives_torque = flags & kTorque;
  f.most_force = in.small();
  f.most_torque = in.small() * kMm;
  f.most_stiffness = in.small() / kMm;

  if (!in.isFinite()) return FrameFault::kNotFinite;
  const double length = f.pose.rotation.norm();
  const bool is_near = f.pose.translation.cwiseAbs().maxCoeff() <= kFarthest;
  if (!is_near || !(std::abs(length - 1) <= 1e-3) || f.most_force < 0 || f.most_torque < 0 || f.most_stiffness < 0)
    return FrameFault::kOutOfRange;
  f.pose.rotation.normalize();
  out = f;
  return FrameFault::kNone;
}

std::array<std::uint8_t, kForceFrameSize> encode(const ForceFrame& f) noexcept {
  std::array<std::uint8_t, kForceFrameSize> bytes{};
  Writer out(bytes);
  out.head(kToHand);
  out.whole(f.number);
  out.whole(f.hand_number);
  out.whole(f.hand_time_ns);
  out.vector(f.force, 1);
  out.vector(f.torque, 1 / kMm);
  out.whole(std::uint32_t{f.is_enabled});
  out.whole(f.deadline_ms);
  return bytes;
}

FrameFault decode(std::span<const std::uint8_t> bytes, ForceFrame& out) noexcept {
  if (bytes.size() != kForceFrameSize) return FrameFault::kLength;
  Reader in(bytes);
  if (const FrameFault fault = in.head(kToHand); fault != FrameFault::kNone) return fault;
  ForceFrame f;
  f.number = in.whole<std::uint64_t>();
  f.hand_number = in.whole<std::uint64_t>();
  f.hand_time_ns = in.whole<std::uint64_t>();
  f.force = in.vector(1);
  f.torque = in.vector(kMm);
  f.is_enabled = in.whole<std::uint32_t>() == 1;
  f.deadline_ms = in.whole<std::uint32_t>();
  if (!in.isFinite()) return FrameFault::kNotFinite;
  out = f;
  return FrameFault::kNone;
}

}  // namespace kerf
