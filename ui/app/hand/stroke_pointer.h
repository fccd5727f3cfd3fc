// Mouse pointing of the tool, and the effect of mouse moves while a key is held.
//
//   hovering        the tool is at the cursor; with Alt it stays, and mouse moves tilt it
//   during a stroke the cursor's moves drag the tool from the start of the stroke; with Ctrl the tool goes along its
//                   axis instead, up is out and down is in
//   on the pedal    the mouse leads nothing; arrows nudge the stroke
//
// No window: pixels of the picture in, calls of the workbench out.
#pragma once

#include <optional>

#include "ui/app/commands/app_commands.h"
#include "ui/app/view/piece_gizmo.h"

namespace kerf {

/// Keys held while the mouse moves.
struct HeldKeys {
  bool alt = false, ctrl = false, shift = false;
};

class StrokePointer {
 public:
  static constexpr double kDoubleTap = 0.4;     ///< s between two taps on Alt that set the tool upright
  static constexpr double kAlongAPixel = 0.01;  ///< mm

  /// The pixel of the tool.
  const Pixel& at() const { return at_; }
  /// Follows the cursor.
  void move(AppContext& context, const Pixel& cursor, const HeldKeys& held);
  /// Handles the button press.   @return  false: nothing to cut there.
  bool press(AppContext& context, const Pixel& cursor);
  /// Handles the button release: ends the stroke, unless a pedal holds it.
  void release(AppContext& context);
  /// One step of a key: 0.1 mm, with Ctrl 0.01, with Shift 1.   @param direction  right, up, in.
  void nudge(AppContext& context, const Vec3d& direction, const HeldKeys& held);
  /// A stick leads the tool right and up in the picture, before and during a stroke, mm.
  void lead(AppContext& context, const Eigen::Vector2d& mm);
  /// Handles a trigger: begins a stroke at the tool.   @return  false: nothing to cut there.
  bool pressThere(AppContext& context);
  /// Keeps the tool in place when the camera moves during a stroke.
  void viewHasTurned(const AppContext& context);
  /// Handles a press of Alt.   @param now  s, of any clock.
  void tapAlt(AppContext& context, double now);

 private:
  Pixel at_ = Pixel::Zero(), cursor_ = Pixel::Zero();
  std::optional<double> tapped_;  // last press of Alt; none: it has tilted since
};

}  // namespace kerf
