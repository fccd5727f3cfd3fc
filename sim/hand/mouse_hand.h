// A hand for people without a force-feedback device: mouse, pen, trackpad. The pointer is a target. The hand moves
// there with a bounded force and a bounded speed, and the coupling does the rest.
//
// A stroke is anchored where the button went down: a line along the tool's axis and the surface as loaded. The hand
// pushes along the axis with a force; sideways it follows the pointer. It never passes a depth below the surface as
// loaded, measured along the axis at the tool's place: the volume removed meanwhile does not draw it deeper.
//
//   along the axis   v = g (wanted - felt), at most kApproach; wanted is the force, and falls within 0.05 mm of the
//                    depth of the tool, which is the hand's less felt / K
//   sideways         v = kFollow (pointer - hand), at most kSideways, less as the side force felt nears its limit
//   surface          as loaded: followed under the hand tick by tick, found under the tool; the higher one counts
//   at its place     the hand of an upright tool stands kFirm (place - tool) beside it: a finger rest, which holds it
//                    with 1 + kFirm times the coupling's stiffness, and with at most twice the force
//   kept parts       l = distance of the tool to pulp, nerve or neighbour, less the margin to keep; the way to the
//                    depth is l at most. Sideways the hand nears them no faster than kBrake l, and draws the tool
//                    towards them with a force that falls within 0.05 mm of l
//   a tilted tool    is led sideways by slant x its depth below the pointer, so that it goes in along its own axis
//
// Force, depth and surface follow the normal of the surface, also for a tilted tool: it presses no harder, and its
// deepest point stops at the depth. Its attitude is held against the torque, as by a hand.
//
// The finger rest needs the tool's place, which a hand does not read. It follows from the force of the coupling,
// K (tool - hand) + B (their speeds' difference): force / K alone is early by B / K = 2 ms, and the tool circles in its
// hole. A ball of radius r under a load N slides off the stub that its slow tip leaves with N / r, and drag turns it:
// at 1 N, softer than N / r = 4 N/mm for the smallest bur, every bur cuts a bowl.
//
// The samples are in the session log like any device's: a replay gives the same bits without a mouse.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/field/brick_field.h"
#include "sim/hand/device_source.h"
#include "sim/hand/tool_lean.h"
#include "sim/hand/triple_buffer.h"
#include "sim/monitor/structures.h"
#include "sim/step/coupling.h"

namespace kerf {

/// The person's target. World frame, mm, N.
struct MouseAim {
  std::uint64_t stroke = 0;       ///< rises with every stroke: an aim counts once the tool was placed for its stroke
  bool is_pressed = false;        ///< the button is down: the spindle turns and the hand pushes
  Vec3d pointer = Vec3d::Zero();  ///< on the surface as loaded, or on the plane of the stroke: target of the tip
  Vec3d anchor = Vec3d::Zero();   ///< on the surface as loaded, where the stroke began
  Vec3d into = -Vec3d::UnitZ();   ///< the axis: unit, into the tissue, against its normal
  Rigid3 T_world_surface;         ///< of the surface as loaded: a piece may have been moved
  double reach = 0;               ///< from the tip along the axis to the tool's leading point, mm: a disc's radius
  double force = 1;               ///< along the axis, 0 to 8
  double depth = 0.5;             ///< below the surface as loaded, along the axis, that the tool may reach
                                  ///< (negative: above it), at least -kClearance
  double pedal = 1;               ///< of the nominal speed, 0 to 1; negative: backwards
  double irrigation = 1;          ///< 0 to 1
  /// From the tip to the point of the tool that follows pointer and surface, square to the axis, mm: the middle of a
  /// saw's teeth, the contact point of a tilted tool.
  Vec3d front = Vec3d::Zero();
  /// For a tilted tool: sideways motion for each mm of depth, square to the axis, at most kMostSlant. Zero: it plunges
  /// along the axis.
  Vec3d slant = Vec3d::Zero();
  /// The hand turns against torques, as for a tilted tool.
  bool is_attitude_held = false;
  /// Normal of a cutting guide's plane, from where the tool was placed: unit, square to the axis. The pointer then
  /// moves the tool within that plane alone, and no force turns it out of it. Zero: no guide.
  Vec3d guide = Vec3d::Zero();
  /// Margin between the tool and any of the structures to keep, mm; negative: all may be cut.
  double keep = -1;
  /// The same for neighbours of the object.
  double keep_beside = -1;
  /// Points of the tool for both; null: all may be cut. They must outlive the hand.
  const ToolSamples* samples = nullptr;
};

/// The window's thread aims, the haptic thread reads. Before a stroke the window sends PlaceTool with the pose above
/// the anchor: this hand waits there and keeps that attitude.
class MouseHand final : public DeviceSource {
 public:
  static constexpr double kApproach = 15;  ///< mm/s, along the axis
  static constexpr double kSideways = 8;   ///< mm/s
  static constexpr double kMostSlant = 4;  ///< a tilt of 76 degrees
  static constexpr double kLeast = 0.3;    ///< N: side force that is always allowed
  static constexpr double kFirm = 9;       ///< mm that it stands beside its place for each mm of the tool
  static constexpr double kClearance = 1;  ///< mm above the surface as loaded, with the button up

  /// @param surface  the field as loaded (mm, negative inside), kept. Null: the plane through the anchor.
  /// @param start  pose of the tool.   @param coupling  of the session.
  MouseHand(std::shared_ptr<const BrickField> surface, const Rigid3& start, const CouplingSettings& coupling = {});

  /// Structures of MouseAim::keep, in the frame of the surface as loaded. Before the first read().
  void keepAwayFrom(std::shared_ptr<const Structures> structures) { structures_ = std::move(structures); }

  /// Neighbours of MouseAim::keep_beside, at their place as loaded: they do not move. Before the first read().
  void keepAwayFromBeside(std::vector<std::shared_ptr<const KeepOut>> beside) { beside_ = std::move(beside); }

  /// The newest aim. One thread.
  void aim(const MouseAim& aim) noexcept;

  /// @rt  @cost  4 to 18 trilinear samples of the field; near a structure to keep up to 60 us more for each.
  DeviceSample read() noexcept override;
  void write(const DeviceForce& force) noexcept override {
    felt_ = force.force;
    torque_ = force.torque;
  }
  void placed(const Rigid3& T_world_tool) noexcept override;
  bool isAtRest() const noexcept override { return !aim_.is_pressed; }

 private:
  void takeNewestAim() noexcept;
  void followSurface() noexcept;
  void moveSideways() noexcept;
  void moveAlong(bool is_pressed) noexcept;
  void holdAttitude() noexcept;
  void holdAtPlace(bool is_pressed) noexcept;
  DeviceSample send(bool is_pressed) noexcept;
  std::optional<double> leftToKept(const Vec3d& ahead) const noexcept;
  void feelKept(bool is_pressed) noexcept;
  Vec3d sidewaysToKept() const noexcept;
  void holdBackFromKept(const Vec3d& towards) noexcept;
  Vec3d front() const noexcept { return pose_.translation + front_; }
  bool isTilted() const noexcept { return !aim_.slant.isZero(0); }
  bool isHeldInAttitude() const noexcept { return isTilted() || aim_.is_attitude_held || !aim_.guide.isZero(0); }
  Vec3d givesWay() const noexcept;

  std::shared_ptr<const BrickField> surface_;
  std::shared_ptr<const Structures> structures_;        // null: none
  std::vector<std::shared_ptr<const KeepOut>> beside_;  // world frame
  double stiffness_, turn_stiffness_;                   // of the coupling, N/mm and N mm/rad
  double early_;                                        // s by which its force gives the place too early
  double gain_;                                         // of its filter, a tick
  TripleBuffer<MouseAim> aims_;
  MouseAim aim_;                         // newest
  Rigid3 to_surface_;                    // from the world
  std::uint64_t placed_for_ = 0;         // stroke
  Rigid3 pose_;                          // of the hand
  Vec3d axis_ = -Vec3d::UnitZ();         // of the stroke, into the tissue
  double reach_ = 0;                     // of the tool along it, mm
  double height_ = 0;                    // of the surface as loaded, along the axis, at the hand, mm
  std::optional<double> left_;           // of the tool's way to the depth, mm
  double speed_ = 0;                     // rate of decrease of left_, mm/s
  double kept_speed_ = 0;                // rate of decrease of kept_, mm/s
  std::optional<double> kept_;           // mm left to the structures to keep; none: far from them, or no margin set
  Vec3d felt_ = Vec3d::Zero();           // N, of the last tick
  Vec3d torque_ = Vec3d::Zero();         // N mm
  Vec3d front_ = Vec3d::Zero();          // of the tool, see MouseAim
  Vec3d held_ = Vec3d::Zero();           // of the hand beside its place, square to the axis, mm
  Vec3d tool_ = Vec3d::Zero();           // place of the tool, by the force
  Vec3d sent_ = Vec3d::Zero();           // last reported place of the hand
  Vec3d speed_of_sent_ = Vec3d::Zero();  // as the coupling filters it, mm/s
  double aside_ = 0;                     // of the hand beside the guide's plane, mm: offsets the coupling's give
  ToolLean lean_;
};

}  // namespace kerf
