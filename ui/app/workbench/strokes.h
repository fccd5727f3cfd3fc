// Cutting by mouse, pedal, pad or SpaceMouse: push, depth, speed, spray, tilt, and the stroke itself.
//
// Rays are in the world's frame. A change of a value applies at once, also during a stroke.
#pragma once

#include <optional>

#include "geometry/base/error.h"
#include "sim/hand/mouse_hand.h"
#include "ui/app/document/part.h"
#include "ui/app/tool/stroke.h"
#include "ui/app/tool/tilt.h"
#include "ui/app/view/camera.h"

namespace kerf {

class Workbench;

/// Window thread only.
class Strokes final : public Part {
 public:
  explicit Strokes(Workbench& bench) : bench_(bench) {}

  double force = 1;       ///< N
  double depth_mm = 0.5;  ///< below the surface as loaded
  double irrigation = 1;  ///< 0 to 1
  double speed = 1;       ///< set speed of the spindle as a share of the nominal one, 0 to 1
  /// Least distance of a stroke to pulp or nerve canal, mm: it stops short of them. None: it may enter them, with a
  /// warning. A planned cut ignores it: Sawing::clearance() gives its distance.
  std::optional<double> stop_short_mm;
  /// Least distance of a stroke to neighbours, mm, as stop_short_mm. None: it may cut them, with a warning.
  std::optional<double> stop_short_beside_mm;
  /// Tilt of the tool before it touches, and of later strokes. A guided blade has no tilt.
  Tilt tilt;
  /// Axis of the tool for all strokes by mouse, pedal and pad, as of a path of insertion: unit, out of the tissue,
  /// world frame. It counts before the tilt. None: the axis follows the surface.
  const std::optional<Vec3d>& heldAxis() const { return held_axis_; }
  void holdAxis(const std::optional<Vec3d>& axis);
  static constexpr double kLeastForce = 0.1, kMostForce = 8, kMostDepth = 5;
  static constexpr double kMostShort = 5, kUsualShort = 0.5, kUsualShortBeside = 0.2;  ///< mm

  void setForce(double newtons);
  void setSpeed(double of_nominal);
  void setIrrigation(double of_full);
  void stopShort(std::optional<double> mm);
  void stopShortBeside(std::optional<double> mm);
  /// Changes the depth during a stroke or before it, mm; positive is deeper.
  void deepen(double mm);
  /// Deepest stroke, mm: along a guide right through a jaw.
  double mostDepth() const;
  /// Reverses the drive until another tool is taken. A one-way drive (air turbine, saw, piezo tip) gives an error with
  /// a remedy.
  Expected<void> setReversed(bool is_reversed);
  bool isReversed() const { return is_reversed_; }
  bool canReverse() const;

  /// The tool's pose over the surface there. None: the ray misses the object, or nothing is open.
  std::optional<ToolOverSurface> over(const Ray& ray) const;

  // ---- A stroke

  /// @return  false: nothing to cut there.
  bool press(const Ray& ray);
  void drag(const Ray& ray);
  /// Ends the stroke, mouse or pedal.
  void release();
  bool isPressed() const { return stroke_.has_value(); }
  /// Factor on the speed until the stroke ends: trigger travel, 0 to 1.
  void drill(double pedal);
  /// Factor on the force, until it is 1 again.
  void pushHarder(double factor);
  /// Moves the tool along its axis, mm, positive is in. It stays at that depth until the stroke ends or the depth is
  /// set. Range: from kClearance above the surface as loaded to the depth. Without a stroke: no effect.
  void moveAlong(double mm);
  /// Moves the stroke's pointer over the surface as loaded, in mm of the picture. Without a stroke: no effect.
  void nudge(const Camera& camera, double right_mm, double up_mm);
  /// A foot pedal holds the stroke: it needs no button, and the mouse does not lead it. Begins a stroke if there is
  /// none.
  /// @param at  pointing ray; none: the place of the last press or drag.
  /// @return  false: nothing to cut there.
  bool stepOnPedal(const std::optional<Ray>& at);
  bool isOnPedal() const { return is_on_pedal_; }
  /// Position of the stroke's pointer, world, mm.
  const Vec3d& pointer() const { return aim_.pointer; }
  /// Pose of the object as loaded at the press.
  const Rigid3& surfacePose() const { return aim_.T_world_surface; }
  /// Depth of the tool below the surface as loaded; none: no stroke.
  std::optional<double> depthNow() const;

  /// Another tool is in hand.
  void toolChanged() { is_reversed_ = false; }
  void opened(Opening how) override;

 private:
  void aim();
  void aimIfPressed();

  Workbench& bench_;
  std::optional<Stroke> stroke_;
  std::optional<Vec3d> held_axis_;
  std::optional<Ray> pointed_;   // last stroke ray
  std::optional<double> along_;  // depth set by moveAlong(), mm
  bool is_on_pedal_ = false, is_reversed_ = false;
  MouseAim aim_;
  double push_factor_ = 1, drill_ = 1;
};

}  // namespace kerf
