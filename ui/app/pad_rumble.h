// The gamepad that drills shakes: the drive as a fine trembling, contact as a heavy one. No GLFW.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "sim/device/rumble_pad.h"
#include "sim/live/haptic_thread.h"

namespace kerf {

/// Which pad GLFW reads: ids of USB.
struct PadId {
  std::uint16_t vendor = 0, product = 0;
  bool operator==(const PadId&) const = default;
};
/// From the GUID that GLFW gives, 32 hexadecimal digits as SDL writes them. None: it has no ids.
std::optional<PadId> padIdOf(const std::string& guid);

/// @param drive_share  speed of the drive, of its free speed, 0 to 1.
Rumble rumbleOf(const HapticReport& report, double drive_share);

/// Opens the pad that is in use when there is something to shake for, and tells it once a frame. One thread.
class PadRumble {
 public:
  /// @param pad  in use; none: there is none.   @param wanted  zero: at rest, as when paused or out of focus.
  /// @return  a sentence when a pad that could shake may not be opened; once.
  std::optional<std::string> update(const std::optional<PadId>& pad, const Rumble& wanted);

 private:
  std::unique_ptr<RumblePad> pad_;
  std::optional<PadId> of_;  // that was opened or tried
  bool has_told_ = false;
};

}  // namespace kerf
