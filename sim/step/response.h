// One look at contact by constraints or by impulses, beside the penalty law of sim/step/step.cpp.
//
// Both reduce the contact to a few points (sim/step/contact_points.h) and solve for the loads that hold them apart. The
// tool may overlap the tissue by a skin, so that contact neither flickers nor ends what erosion lives on:
// - constraint (god-object: Zilles & Salisbury, IROS 1995; Ruspini, Kolarov & Khatib, SIGGRAPH 1997; in six degrees of
//   freedom: Ortega, Redon & Coquillart, TVCG 2007): the tool, without mass, goes to the pose nearest to the device in
//   the metric of the coupling's stiffness, with its damping when coupled, among those without overlap. Points are
//   gathered where it would go if nothing was there: walls are met before they are passed;
// - impulse (Mirtich & Canny, I3D 1995; Baraff, SIGGRAPH 1989): the tool is a body on the coupling; points it would
// meet
//   get impulses until none comes nearer than the skin in this look, or leaves slower than restitution wants.
// What overlaps beyond the skin is taken back a part at a time, without load or velocity: walls on both sides would
// otherwise press as hard as they like.
//
// Erosion and drag: where and in which proportion the overlap says (the penalty law's pressure), how much the solved
// load N says. Rates are scaled until the pressure, mean over the look, integrates to N: removal is mu N v_s / u_s, as
// long as there is that much overlap to remove. A part that cuts is allowed to overlap, up to 0.1 mm, so that there is.
#pragma once

#include <algorithm>

#include "sim/step/step.h"

namespace kerf {

/// What a point of contact may overlap, mm.
inline double contactSkin(double voxel) { return std::max(0.1 * voxel, 0.005); }

/// What a look came to, world frame, about the tip.
struct Look {
  ContactSums sums;     ///< pressure and drag; those of sim/step/contact.h
  Wrench contact;       ///< on the tool, with drag
  bool is_free = true;  ///< nothing holds it, and it is where the hand wants it
  double removed_mm3 = 0;
  std::uint64_t objects_touched = 0;  ///< StepOutput::objects_touched
  int bricks_near = 0, bricks_cut = 0;
  std::uint32_t status = 0;  ///< StepStatus
};

/// What an object's contact needs to know of tool and time; the tool where its body is. @rt
ContactInput contactInput(const Model& model, const State& state, const CutObject& object, double dt) noexcept;

/// Rate times time, x, of the pressure's mean over a look: g(x) = (1 - exp(-x)) / x = now / still, both cutting loads
/// in N, `still` before erosion.
double relaxationRate(double now, double still) noexcept;
/// The factor s on rates, and so on the pressure, with which the mean cutting load becomes `load`: s still g(s rate) =
/// load. Where all of the overlap would not do, nearly all of it goes.
double erosionScale(double load, double rate, double still) noexcept;

/// Moves the tool by StepSettings::response, which is kConstraint or kImpulse; erodes where it was. @rt
/// @param longest_mm  no part of the cutting head moves farther.   @param device_way_mm  how far the device takes it.
///   @cost twice that of the penalty law's look
Look respond(const Model& model, State& state, double dt, double longest_mm, double device_way_mm) noexcept;

}  // namespace kerf
