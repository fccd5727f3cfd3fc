// Where a mouse points the tool, and what its moves mean while a key is held.
//
//   hovering        the tool is where the cursor is; with Alt it stays, and the moves tilt it
//   during a stroke the tool is dragged by what the cursor moves, from where the stroke began; with Ctrl it goes along
//                   its axis instead, up is out and down is in
//   on the pedal    the mouse leads nothing; arrows nudge the stroke
//
// No window: pixels of the picture in, calls of the workbench out.
#pragma once

#include <optional>

#include "ui/app/app_commands.h"
#include "ui/app/piece_gizmo.h"

namespace kerf {

/// Keys that are held while the mouse moves.
struct HeldKeys {
  bool alt = false, ctrl = false, shift = false;
};

class StrokePointer {
 public:
  static constexpr double kDoubleTap = 0.4;     ///< s between two taps on Alt that set the tool upright
  static constexpr double kAlongAPixel = 0.01;  ///< mm

  /// The pixel that the tool is pointed at.
  const Pixel& at() const { return at_; }
  /// The cursor is there now.
  void move(AppContext& context, const Pixel& cursor, const HeldKeys& held);
  /// The button went down.   @return  false: there is nothing there to cut.
  bool press(AppContext& context, const Pixel& cursor);
  /// The button went up: the stroke ends, unless a pedal holds it.
  void release(AppContext& context);
  /// One step of a key: 0.1 mm, with Ctrl 0.01, with Shift 1.   @param direction  right, up, in.
  void nudge(AppContext& context, const Vec3d& direction, const HeldKeys& held);
  /// A stick leads the tool to the right and up in the picture, before and during a stroke, mm.
  void lead(AppContext& context, const Eigen::Vector2d& mm);
  /// A trigger was pulled: a stroke begins where the tool is.   @return  false: there is nothing there to cut.
  bool pressThere(AppContext& context);
  /// The camera moved during a stroke: the tool stays where it is.
  void viewHasTurned(const AppContext& context);
  /// Alt went down.   @param now  s, of any clock.
  void tapAlt(AppContext& context, double now);

 private:
  Pixel at_ = Pixel::Zero(), cursor_ = Pixel::Zero();
  std::optional<double> tapped_;  // when Alt last went down; none: it has tilted since
};

}  // namespace kerf
