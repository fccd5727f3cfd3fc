#include "sim/step/contact_evaluation.h"

#include <cmath>

#include "sim/step/contact_turns.h"
#include "sim/step/erosion_rates.h"

namespace kerf {
namespace {

constexpr double kMostRelaxed = 4;  // rate times time at which all but 2 % of an overlap is gone

// Counts the cut of a turn. The next turn repairs the shells of its groups before the force.
void finishTurn(const CutResult& cut, ContactEvaluation& out) {
  out.removed_mm3 += cut.removed_mm3;
  out.bricks_cut += cut.bricks;
  if (cut.pool_ran_out) out.status |= kStepBricksRanOut;
}

constexpr double kSlow = 0.1;  // of a drive's free speed

// A drill's lips have a law of feed and thrust, not of work. A tool that turns the wrong way cuts nothing.
bool paysByWork(const ContactInput& in) {
  return !in.geometry_only && !in.tool->lips.areThere() && in.tool->drive.speed > 0 && !internal::onlyRubs(in);
}

// Corrects the areas of cut nodes, as far as there was a recent cut and the drive turns. At rest a tool presses by the
// plain areas, and the force must not jump when a drive comes to rest.
void correctAreas(const CutObject& object, ContactInput& in) {
  if (!paysByWork(in)) return;
  const double h = object.voxel();
  in.cut_share = object.cut_area.share(h) * std::min(1.0, std::abs(in.speed) / (kSlow * in.tool->drive.speed));
  in.area_scale = 1 + in.cut_share * (object.cut_area.scale(h) - 1);
}

// Compares the removed volume with the areas of the shell. The load of the core erodes too: beside the shell's, in
// proportion. Does not blame the areas if the cut was prevented, or if the core's load asked for more overlap than
// there was.
void learnArea(CutObject& object, const ContactInput& in, const ContactSums& sums, const CutResult& cut) {
  if (in.geometry_only || cut.pool_ran_out) return;
  const bool is_slow = std::abs(in.speed) < kSlow * in.tool->drive.speed;
  if (!paysByWork(in) || is_slow || object.isFrozen() || !(sums.cut_by_shell > 0)) {
    object.cut_area.fade(in.dt);
    return;
  }

  // The sums include the core's load: shareCoreLoad().
  const double core = object.core_load, shell = sums.cutting_load - core;
  const bool is_shared = core > 0 && sums.bare_load > 0 && shell > 0;
  const double removed = is_shared ? cut.removed_mm3 * sums.bare_load / (sums.bare_load + core) : cut.removed_mm3;
  const double paid = object.cut_area.scale(object.voxel()) * sums.cut_by_shell * (is_shared ? 1 + core / shell : 1);
  const bool took_all =
      is_shared && in.load_scale * relaxationRate(sums.bare_load, sums.bare_erodible) > 0.99 * kMostRelaxed;
  object.cut_area.add(removed, sums.cut_by_shell, took_all ? 0 : cut.removed_mm3 - paid, in.dt);
}

// Force, then erosion: both see the same pose and the same field. A contact too large for a tick takes turns.
void touchAndCut(const Model& model, State& state, const Substep& substep, std::size_t number, ContactInput& in,
                 ContactEvaluation& out) {
  CutObject& object = state.objects[number];
  ContactTurns& turns = state.turns[number];
  const bool may_take_turns = model.settings.takes_turns && !model.settings.geometry_only;
  const bool by_turns = turns.begin(object.contactEpoch()) && may_take_turns;
  ContactSums sums;
  std::uint32_t groups = 0;
  correctAreas(object, in);
  if (by_turns) {
    groups =
        turns.sum(object, state.near, state.near_in_turn, in, std::min(substep.longest_mm, 0.5 * object.voxel()), sums);
  } else {
    if (object.dirtyCount() > 0) static_cast<void>(object.repair());  // remains of turns, or of a lack of memory
    sumContact(object, state.near, in, sums);
  }

  if (sums.touching > 0) out.objects_touched |= objectBit(number);
  in.load_scale = shareCoreLoad(object.core_load, state.speed, sums);
  out.sums.add(sums.rotated(object.T_world_object.rotation.toRotationMatrix()));

  const CutResult cut =
      by_turns ? turns.erode(object, state.near, state.near_in_turn, in, groups) : erode(object, state.near, in);
  learnArea(object, in, sums, cut);
  if (by_turns) {
    finishTurn(cut, out);
    return;
  }
  finishCut(object, cut, out);
  if (may_take_turns) turns.weigh(ContactTurns::workOf(sums.touching, cut.bricks));
}

// Penalty law and adding: the sums and the tool's own drag act on the tool. They move a body on the coupling; the
// device has moved a fixed tool already.
void moveByContact(const Model& model, State& state, const Substep& substep, CoreContact& core,
                   ContactEvaluation& out) {
  const ToolModel& tool = model.tools[state.tool];
  const Wrench own = ownDrag(tool, state.body.pose, state.speed, out.sums);
  if (!isAtRest(tool, state.speed)) state.grip.setZero();

  if (model.settings.attachment() == Attachment::kFixed) {
    out.contact = contactWrench(state.body, {out.sums.force, out.sums.torque}, own, out.sums.dragMatrix());
  } else {
    out.contact = advance(state.body, state.device, out.sums, own, substep.coupling, tool.cut.reach(),
                          substep.longest_mm, substep.dt, &core, &state.grip);
    out.objects_touched |= core.countTouched(out.sums);
    const double moved = substep.dt * (state.body.velocity.norm() + tool.reach_mm * state.body.angular.norm()) + 1e-9;
    for (CutObject& object : state.objects) object.odometer += moved;
  }

  state.core_drag = core.drag(state.body);
  for (std::size_t n = 0; n < state.objects.size(); ++n)
    state.objects[n].core_load = std::min(core.cuttingLoad(n), kMostCoreLoad);
}

}  // namespace

ContactInput contactInput(const Model& model, const State& state, const CutObject& object, double dt) noexcept {
  const Rigid3 T_object_world = object.T_world_object.inverse();
  ContactInput in;
  in.tool = &model.tools[state.tool];
  in.tissues = &model.tissues;
  in.T_object_tool = T_object_world * state.body.pose;
  in.speed = state.speed;
  in.dt = dt;
  in.geometry_only = model.settings.geometry_only;
  in.velocity = T_object_world.rotation * state.body.velocity;
  in.angular = T_object_world.rotation * state.body.angular;
  return in;
}

void finishCut(CutObject& object, const CutResult& cut, ContactEvaluation& out) noexcept {
  const bool is_repaired = object.repair();
  out.removed_mm3 += cut.removed_mm3;
  out.bricks_cut += cut.bricks;
  if (cut.pool_ran_out || !is_repaired) out.status |= kStepBricksRanOut;
}

Wrench contactWrench(const ToolBody& body, const Wrench& pressed, const Wrench& own_drag,
                     const Matrix6d& drag_matrix) noexcept {
  Vector6d twist;
  twist << body.velocity, body.angular;
  const Vector6d feed_drag = drag_matrix * twist;
  return {pressed.force + own_drag.force - feed_drag.head<3>(), pressed.torque + own_drag.torque - feed_drag.tail<3>()};
}

ContactEvaluation evaluatePenalty(const Model& model, State& state, const Substep& substep) noexcept {
  const ToolModel& tool = model.tools[state.tool];
  const bool has_body = model.settings.attachment() != Attachment::kFixed;
  ContactEvaluation out;
  CoreContact core;

  for (std::size_t n = 0; n < state.objects.size(); ++n) {
    CutObject& object = state.objects[n];
    ContactInput in = contactInput(model, state, object, substep.dt);
    if (!state.near.find(object, tool, in.T_object_tool)) out.status |= kStepNearRanOut;
    out.bricks_near += static_cast<int>(state.near.size());

    touchAndCut(model, state, substep, n, in, out);
    if (has_body && state.near.size() > 0) core.gather(object, n, in, substep.longest_mm);
  }

  state.core_drag.addTo(out.sums);
  moveByContact(model, state, substep, core, out);
  return out;
}

ContactEvaluation evaluateAdding(const Model& model, State& state, const Substep& substep, bool fills) noexcept {
  ContactEvaluation out;

  for (std::size_t n = 0; n < state.objects.size(); ++n) {
    CutObject& object = state.objects[n];
    FillResult added;
    object.forgetCore();  // the added material may close around the tool
    if (fills && n == state.adds_to) added = fill(object, contactInput(model, state, object, substep.dt), state.adds);

    out.added_mm3 += added.added_mm3;
    if (added.is_clipped) out.status |= kStepFillClipped;
    finishCut(object, {.bricks = added.bricks, .pool_ran_out = added.pool_ran_out}, out);
  }

  CoreContact no_core;
  moveByContact(model, state, substep, no_core, out);
  return out;
}

double relaxationRate(double now, double still) noexcept {
  if (!(now > 0 && still > 0)) return 0;
  // g(x) = (1 - exp(-x)) / x falls and is convex: Newton from the left climbs to the root without passing it.
  const double g = std::min(now / still, 1.0);
  double x = 0;
  for (int n = 0; n < 30 && g < 1 - 1e-9; ++n) {
    const double part = -std::expm1(-x);
    const double value = x > 1e-6 ? part / x : 1 - 0.5 * x;
    const double slope = x > 1e-3 ? ((1 - part) - value) / x : -0.5 + x / 3;
    const double step = (g - value) / slope;
    x += step;
    if (step < 1e-12 * (1 + x)) break;
  }
  return x;
}

double erosionScale(double load, double rate, double still) noexcept {
  if (!(load > 0 && still > 0)) return 0;
  if (rate < 1e-9) return load / still;
  const double wanted = load * rate / still;
  return (wanted < -std::expm1(-kMostRelaxed) ? -std::log1p(-wanted) : kMostRelaxed) / rate;
}

}  // namespace kerf
