// The sound of the drive in hand, as samples for a loudspeaker: what is recorded of a run (sim/monitor/vibration.h),
// rendered while it is cut.
//
// Pitch is the drive's speed, and falls with load as a dentist hears it; level and hiss grow with load. What it is told
// comes some 60 times a second: speed and load follow within 20 ms, so that pitch glides. Start, stop and another tool
// fade within 30 ms: no sample jumps. Of no effect on what is cut, and in no log.
#pragma once

#include <span>

#include "geometry/tool/tool.h"
#include "sim/live/haptic_thread.h"
#include "sim/monitor/vibration.h"

namespace kerf {

/// What is to be heard now. A value: crosses threads by copy.
struct DrillSoundInput {
  VibrationSource source;  ///< of the tool: another one begins when the one before has faded
  VibrationInput now;
  double volume = 0;        ///< 0 to 1, as loud as it seems
  bool is_running = false;  ///< false: fades out
};

/// Of the newest tick.   @param volume  0 to 1.
DrillSoundInput drillSoundOf(const HapticReport& report, const Tool& tool, const ToolDrive& drive, double volume);

/// A value; belongs to the thread that renders.
class DrillSound {
 public:
  static constexpr double kFadeSeconds = 0.03, kFollowSeconds = 0.02;

  /// @param rate  samples per second, 8000 to 192000.
  explicit DrillSound(double rate);

  /// The next samples, each in [-1, 1]. Exactly 0 once it has faded out.   No allocation, no lock.
  /// @cost about 30 ns a sample; nothing while it is silent.
  void render(const DrillSoundInput& in, std::span<float> out) noexcept;
  /// Hz, of the drive as it is heard now.
  double frequency() const noexcept { return vibration_.frequency(); }
  bool isSilent() const noexcept { return gain_ == 0; }

 private:
  double rate_;
  Vibration vibration_;
  VibrationSource source_;       // that is heard
  double speed_ = 0, load_ = 0;  // as they are heard
  double gain_ = 0;
};

}  // namespace kerf
