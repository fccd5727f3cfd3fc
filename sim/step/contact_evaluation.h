// One evaluation of contact: forces, erosion, and the tool's motion until the next evaluation. Common data of the
// responses in sim/step/response.h.
//
// All functions are @rt: no allocation, lock, exception or system call.
#pragma once

#include <algorithm>

#include "sim/step/step.h"

namespace kerf {

/// The part of a tick covered by one evaluation.
struct Substep {
  double dt = kTick;          ///< s
  double longest_mm = 0;      ///< no part of the cutting head moves farther
  double device_way_mm = 0;   ///< motion of the tool by the device meanwhile; Attachment::kProxy looks that far ahead
  CouplingSettings coupling;  ///< of this tick
};

/// Result of one evaluation, world frame, about the tip.
struct ContactEvaluation {
  ContactSums sums;     ///< pressure and drag, as in sim/step/contact.h
  Wrench contact;       ///< on the tool, with drag
  bool is_free = true;  ///< nothing holds the tool, and it is at the hand's target
  double removed_mm3 = 0, added_mm3 = 0;
  std::uint64_t objects_touched = 0;  ///< StepOutput::objects_touched
  int bricks_near = 0, bricks_cut = 0;
  std::uint32_t status = 0;  ///< StepStatus
};

/// Evaluation during filling (State::adds): the tool adds material at its place and feels nothing.
/// @param fills  the pedal is pressed. @rt
ContactEvaluation evaluateAdding(const Model& model, State& state, const Substep& substep, bool fills) noexcept;

/// Contact input for one object; the tool is at its body's pose. @rt
ContactInput contactInput(const Model& model, const State& state, const CutObject& object, double dt) noexcept;

/// Counts a cut and updates the object's shells, also when memory ran out: the cut must be felt. @rt
void finishCut(CutObject& object, const CutResult& cut, ContactEvaluation& out) noexcept;

/// The wrench on a tool that moves as `body`: `pressed` plus the drag of its own motion, minus the drag along the feed.
/// @rt
Wrench contactWrench(const ToolBody& body, const Wrench& pressed, const Wrench& own_drag,
                     const Matrix6d& drag_matrix) noexcept;

/// Allowed overlap of a contact point under constraint and impulse, mm.
inline double contactSkin(double voxel) { return std::max(0.1 * voxel, 0.005); }

/// The relaxation x of an eroding overlap, rate times time, from its mean over the evaluation: g(x) = (1 - exp(-x)) / x
/// = now / still.
/// @param now  the cutting load with erosion, N.   @param still  the same before erosion, N.
double relaxationRate(double now, double still) noexcept;

/// The factor s on rates, and thus on the pressure, that makes the mean cutting load `load`: s still g(s rate) = load.
/// If the whole overlap is not enough, nearly all of it goes.
double erosionScale(double load, double rate, double still) noexcept;

}  // namespace kerf
