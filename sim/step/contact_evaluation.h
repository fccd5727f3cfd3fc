// One evaluation of contact: forces, erosion, and the tool's motion until the next evaluation. What the responses of
// sim/step/response.h return and share.
//
// All functions are @rt: no allocation, lock, exception or system call.
#pragma once

#include <algorithm>

#include "sim/step/step.h"

namespace kerf {

/// The part of a tick that one evaluation stands for.
struct Substep {
  double dt = kTick;          ///< s
  double longest_mm = 0;      ///< no part of the cutting head moves farther
  double device_way_mm = 0;   ///< how far the device takes the tool meanwhile; Attachment::kProxy looks that far ahead
  CouplingSettings coupling;  ///< of this tick
};

/// What one evaluation came to, world frame, about the tip.
struct ContactEvaluation {
  ContactSums sums;     ///< pressure and drag; those of sim/step/contact.h
  Wrench contact;       ///< on the tool, with drag
  bool is_free = true;  ///< nothing holds the tool, and it is where the hand wants it
  double removed_mm3 = 0, added_mm3 = 0;
  std::uint64_t objects_touched = 0;  ///< StepOutput::objects_touched
  int bricks_near = 0, bricks_cut = 0;
  std::uint32_t status = 0;  ///< StepStatus
};

/// While a material is added instead of cut (State::adds): the tool fills where it is and feels nothing.
/// @param fills  the pedal is pressed. @rt
ContactEvaluation evaluateAdding(const Model& model, State& state, const Substep& substep, bool fills) noexcept;

/// What an object's contact needs to know of tool and time; the tool where its body is. @rt
ContactInput contactInput(const Model& model, const State& state, const CutObject& object, double dt) noexcept;

/// Counts a cut and brings the object's shells up to date, also when memory ran out: what was cut must be felt. @rt
void finishCut(CutObject& object, const CutResult& cut, ContactEvaluation& out) noexcept;

/// The wrench on the tool that moves as `body` does: `pressed` and the drag of its own motion, less the drag along the
/// feed. @rt
Wrench contactWrench(const ToolBody& body, const Wrench& pressed, const Wrench& own_drag,
                     const Matrix6d& drag_matrix) noexcept;

/// What a point of contact may overlap under constraint and impulse, mm.
inline double contactSkin(double voxel) { return std::max(0.1 * voxel, 0.005); }

/// The relaxation x of an overlap that erodes, rate times time, from its mean over the evaluation:
/// g(x) = (1 - exp(-x)) / x = now / still.
/// @param now  the cutting load with erosion, N.   @param still  the same before erosion, N.
double relaxationRate(double now, double still) noexcept;

/// The factor s on rates, and so on the pressure, with which the mean cutting load becomes `load`: s still g(s rate) =
/// load. Where all of the overlap would not do, nearly all of it goes.
double erosionScale(double load, double rate, double still) noexcept;

}  // namespace kerf
