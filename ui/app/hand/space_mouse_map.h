// A SpaceMouse leads the tool or the view: effect of its axes and buttons.
//
//   leads the tool   push to a side, away   the tool goes to the right, up in the picture
//                    press down             drills: the deflection is the pedal
//                    turn                   turns the view
//   leads the view   push to a side, up     the object goes with it
//                    push away              the object becomes smaller
//                    turn                   the object turns with it; the horizon stays level
//   button 1         changes between the two
//   button 2         takes back a stroke
//
// Both by rate: speed grows with deflection. No device access: axes in, calls of the workbench out.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "ui/app/hand/pedal_hold.h"
#include "ui/app/settings/settings.h"

namespace kerf {

/// State of a SpaceMouse: DeviceReading::axes after its settings, and its buttons.
struct SpaceMouseState {
  std::array<double, 6> axes{};  ///< right, away, up, turning about them; -1 to 1
  std::uint64_t buttons = 0;
};

/// Requested motion since the previous state.
struct SpaceMouseWish {
  Eigen::Vector2d tool_mm = Eigen::Vector2d::Zero();  ///< right, up, in the picture
  Eigen::Vector2d orbit = Eigen::Vector2d::Zero();    ///< pixels, as orbit() takes them
  Eigen::Vector2d pan = Eigen::Vector2d::Zero();      ///< pixels, as pan() takes them
  double zoom = 1;                                    ///< as zoomBy() takes it
  double pedal = 0;                                   ///< 0 to 1
  bool undoes = false, changes = false;               ///< the button has just gone down
};

struct SpaceMouseLimits {
  static constexpr double kToolSpeed = 8;      ///< mm/s at most: as fast as the hand follows
  static constexpr double kViewHeights = 0.5;  ///< of the picture per second, fully pushed: tool and pan
  static constexpr double kOrbitSpeed = 240;   ///< pixels/s: 120 degrees a second
  static constexpr double kZoom = 1.1;         ///< e-folds a second
  static constexpr double kPedalRest = 0.3;    ///< deflection below which it does not drill: pushing sideways also
                                               ///< presses it down
  static constexpr double kLongest = 0.1;      ///< s: limits the step of a slow frame
};

/// Axes after inversion and dead band (no step at its edge), optionally the dominant axis only.
std::array<double, 6> settledAxes(const std::array<double, 6>& axes, const SpaceMouseSettings& settings);

/// @param camera, height  the tool speed scales with the picture, mm.   @param seconds  since `before`.
SpaceMouseWish wishOf(const SpaceMouseState& now, const SpaceMouseState& before, const SpaceMouseSettings& settings,
                      const Camera& camera, int height, double seconds);

/// Once a frame.
class SpaceMouseHand {
 public:
  /// @param now  none: no device, or it is not for this window. Ends its stroke.
  void update(AppContext& context, StrokePointer& pointer, const SpaceMouseSettings& settings,
              const std::optional<SpaceMouseState>& now, double seconds);
  /// It acted in the last update().
  bool isUsed() const { return is_used_; }

 private:
  SpaceMouseState before_;
  PedalHold pedal_;
  bool is_used_ = false;
};

}  // namespace kerf
