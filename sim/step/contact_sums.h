// The sums over nodes in contact, with the processor's vector instructions.
#pragma once

#include <array>

#include "sim/step/erode_brick.h"

namespace kerf::internal {

/// Nodes in contact, one array per number. Entries from `count` up to the next multiple of 8 must have a stiffness of 0
/// and finite numbers.
struct TouchingNodes {
  static constexpr int kMost = 64;
  using Row = std::array<float, kMost>;
  alignas(32) Row overlap, into_cut, slope;  ///< mm, mm, d tau / d(inwards normal)
  alignas(32) Row normal[3], area;           ///< outward unit normal, object axes; mm^2
  alignas(32) Row from_tip[3];               ///< object axes, mm
  alignas(32) Row in_tool[3];                ///< tool frame, mm
  /// Only read if TouchingTool::cut_share > 0: where the normal meets the surface, tool frame, mm; and the distance of
  /// the cutting part at TouchingTool::beyond farther along the normal, inside the tool, mm.
  alignas(32) Row foot[3], tau_beyond;
  alignas(32) Row stiffness, friction, rate;  ///< N/mm^3; with the tool's factor; c dt over the lever
  alignas(32) Row lip_rate;                   ///< for a tool with lips: ErosionRates::at_lips
  int count = 0;
};

/// Places at which the tool's distance is looked up for the nodes; tool frame, mm.
struct TouchingPlaces {
  using Row = TouchingNodes::Row;
  alignas(32) Row inwards[3];  ///< one step further inwards, for the slope
  alignas(32) Row beyond[3];   ///< TouchingNodes::tau_beyond; only set on request
};

/// Values common to all nodes.
struct TouchingTool {
  Lever lever;
  LipLever lips;
  float speed = 0;          ///< of the drive, not negative
  float still_speed = 0;    ///< mm/s: slower sliding has the drag of this speed
  bool body_spins = false;  ///< the body moves like the cutting part
  bool geometry_only = false;
  bool is_at_rest = false;            ///< isAtRest()
  float area_scale = 1;               ///< of cut nodes
  float cut_share = 0;                ///< ContactInput::cut_share
  float beyond = 1;                   ///< mm: see TouchingNodes::tau_beyond
  bool is_blade = false;              ///< with flanks `across`
  float across[3]{};                  ///< unit normal of the flanks, object axes
  float velocity[3]{}, angular[3]{};  ///< of the tip, object axes
};

/// Sums, in this order; stiffness, drag_second and normal_drag are lower triangles, row by row.
struct TouchingSums {
  enum : int {
    kForce = 0,
    kTorque = 3,
    kForceNext = 6,
    kTorqueNext = 9,
    kStiffness = 12,
    kNormalLoad = 33,
    kCuttingLoad,
    kDriveLoad,
    kPower,
    kDrag,
    kDragMoment,
    kDragSecond = kDragMoment + 3,
    kArea = kDragSecond + 6,
    kCount,
    kErodibleLoad,
    kBareLoad,
    kBareErodible,
    kBareDriveLoad,
    kCutByShell,
    kLipTorque,
    kLoadNext,
    kLoadSlope,
    kNormalDrag = kLoadSlope + 6,  ///< only with TouchingTool::is_at_rest
    kSums = kNormalDrag + 21
  };
  std::array<double, kSums> value{};
  float deepest = 0;
};

/// Turns the area vectors in `normal` (mm^2, their length `area`) into unit normals, and sets places.inwards. If
/// `beyond` is positive, also sets `foot` and places.beyond.   @param phi  of the nodes, mm.
/// @param to_tool  by rows: from object axes to the tool's.   @param inwards, beyond  steps to the places, mm.
/// The same bits with any instruction set.
void turnTouching(const TouchingNodes::Row& phi, const float to_tool[3][3], float inwards, float beyond,
                  TouchingNodes& nodes, TouchingPlaces& places) noexcept;

/// Adds the nodes' share. Sums each of eight lanes by itself, then the lanes in order: the same bits with any
/// instruction set. Formulas: sim/step/contact.h. @cost about 10 ns a node.
void sumTouching(const TouchingNodes& nodes, const TouchingTool& tool, TouchingSums& sums) noexcept;

}  // namespace kerf::internal
