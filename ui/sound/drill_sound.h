// The sound of the drive in hand, as samples for a loudspeaker: the vibration recorded of a run
// (sim/monitor/vibration.h), rendered live.
//
// Pitch is the drive's speed and falls with load, as a dentist hears it. Level and hiss grow with load. Input comes
// some 60 times a second; speed and load follow within 20 ms, so pitch glides. Start, stop and another tool fade within
// 30 ms: no sample jumps. No effect on the cut or on any log.
#pragma once

#include <span>

#include "geometry/tool/tool.h"
#include "sim/live/haptic_thread.h"
#include "sim/monitor/vibration.h"

namespace kerf {

/// Present target of the sound. A value: crosses threads by copy.
struct DrillSoundInput {
  VibrationSource source;  ///< of the tool; a new one begins after the previous one has faded
  VibrationInput now;
  double volume = 0;        ///< 0 to 1, in perceived loudness
  bool is_running = false;  ///< false: fades out
};

/// State at the newest tick.   @param volume  0 to 1.
DrillSoundInput drillSoundOf(const HapticReport& report, const Tool& tool, const ToolDrive& drive, double volume);

/// A value, owned by the rendering thread.
class DrillSound {
 public:
  static constexpr double kFadeSeconds = 0.03, kFollowSeconds = 0.02;

  /// @param rate  samples per second, 8000 to 192000.
  explicit DrillSound(double rate);

  /// The next samples, each in [-1, 1]. Exactly 0 once it has faded out.   No allocation, no lock.
  /// @cost about 30 ns a sample; none in silence.
  void render(const DrillSoundInput& in, std::span<float> out) noexcept;
  /// Present audible pitch of the drive, Hz.
  double frequency() const noexcept { return vibration_.frequency(); }
  bool isSilent() const noexcept { return gain_ == 0; }

 private:
  double rate_;
  Vibration vibration_;
  VibrationSource source_;       // now audible
  double speed_ = 0, load_ = 0;  // now audible
  double gain_ = 0;
};

}  // namespace kerf
