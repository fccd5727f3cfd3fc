// Forces and cutting of the last 20 s, for plots: a ring of fixed size, 60 values a second.
//
// Each value covers one sixtieth of a second of the session's clock. A gap between two reports takes the later report's
// value. On the window's thread; no allocation, no clock of its own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace kerf {

/// Values of one report.
struct TraceInput {
  std::uint64_t tick = 0;
  double force = 0;         ///< on the hand, N
  double torque = 0;        ///< on the hand, N mm
  double load = 0;          ///< of the drive, % of its stall load
  double spindle = 0;       ///< of the drive's free speed, %
  double depth = 0;         ///< below the surface as loaded, mm
  double penetration = 0;   ///< of the tool into tissue, um: source of the push-back force
  double temperature = 37;  ///< of the tissue under the tool, C
  double removed_mm3 = 0;   ///< since the session began
  std::uint64_t jumps = 0;  ///< increases when undo or redo changes removed_mm3: that is no cut
};

class Trace {
 public:
  enum class Channel : std::uint8_t { kForce, kTorque, kLoad, kSpindle, kDepth, kPenetration, kRate, kTemperature };
  struct About {
    Channel channel;
    const char* name;
    const char* unit;
    double least_top;  ///< least end of the scale: noise at rest looks small
  };
  static constexpr std::array<About, 8> kChannels{{{Channel::kForce, "Force", "N", 1},
                                                   {Channel::kTorque, "Torque", "N mm", 1},
                                                   {Channel::kLoad, "Drive load", "%", 100},
                                                   {Channel::kSpindle, "Spindle", "%", 100},
                                                   {Channel::kDepth, "Depth", "mm", 0.5},
                                                   {Channel::kPenetration, "Penetration", "um", 50},
                                                   {Channel::kRate, "Volume rate", "mm3/s", 0.1},
                                                   {Channel::kTemperature, "Temperature", "°C", 50}}};
  static constexpr std::size_t kPerSecond = 60, kSeconds = 20, kCount = kPerSecond * kSeconds;

  void clear() { *this = {}; }
  /// A tick before the last one clears the trace. Within one sixtieth of a second it keeps only the first value.
  void add(const TraceInput& input);

  /// kCount values of a ring, 0 before the session began.
  const std::array<float, kCount>& values(Channel channel) const { return values_[indexOf(channel)]; }
  /// Index of the oldest value in the ring.
  std::size_t oldest() const { return next_; }
  float newest(Channel channel) const { return values(channel)[(next_ + kCount - 1) % kCount]; }
  float largest(Channel channel) const;
  /// End of a scale from 0: 1, 2 or 5 times a power of ten above the largest value.
  double scaleTop(const About& channel) const;

 private:
  static constexpr std::size_t indexOf(Channel channel) { return static_cast<std::size_t>(channel); }

  std::array<std::array<float, kCount>, kChannels.size()> values_{};
  std::size_t next_ = 0;
  bool is_begun_ = false;
  TraceInput last_;
};

}  // namespace kerf
