#include "sim/step/step.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "sim/step/contact_evaluation.h"
#include "sim/step/drive.h"
#include "sim/step/flush_denormals.h"

namespace kerf {
namespace {

/// Bricks sleep until the tool has moved far enough to reach them. After a jump none may sleep: see
/// CutObject::odometer.
void wakeAll(State& state) {
  for (CutObject& object : state.objects) object.wake();
}

/// How the tool moves in one tick.
struct Motion {
  Attachment attachment = Attachment::kBody;
  Rigid3 tool_before;  ///< T_world_tool at the start of the tick
  CouplingSettings coupling;
  double longest_mm = 0;  ///< between two contact evaluations
  double length_mm = 0;   ///< upper bound for any part of the cutting head
  int evaluations = 1;    ///< of contact
  double dt = kTick;      ///< between two of them, s
};

// Upper bound of the motion of a part of the cutting head between two poses.
double wayBetween(const Rigid3& from, const Rigid3& to, double reach_mm) {
  return (to.translation - from.translation).norm() + reach_mm * rotationBetween(from.rotation, to.rotation).norm();
}

// Phase 1. The force is zero and stays zero: it must not strike a hand that comes back to a pressed tool.
bool latchIfUnusable(State& state, const DeviceSample& input, StepOutput& output) {
  if (!input.isUsable()) state.is_latched = true;
  if (!state.is_latched) return false;

  state.last_force = {};
  state.has_device = false;
  state.ramp = 0;
  state.speed = 0;
  state.body.velocity.setZero();
  state.body.angular.setZero();
  state.forgetCore();
  output.T_world_tool = state.body.pose;
  output.status = kStepBadSample;
  return true;
}

// Reports frozen objects, which erosion and filling skip.
void reportFrozen(const State& state, StepOutput& output) {
  for (const CutObject& object : state.objects)
    if (object.isFrozen()) output.status |= kStepFrozen;
}

// The device's pose, and its velocity through a first-order low pass. The first sample has no velocity.
void filterDevice(State& state, const DeviceSample& input, const CouplingSettings& settings) {
  if (!state.has_device) {
    state.device = {input.T_world_device, Vec3d::Zero(), Vec3d::Zero()};
    if (state.tick == 0) state.body.pose = input.T_world_device;
    state.has_device = true;
    return;
  }
  const double a = 1 - std::exp(-2 * std::numbers::pi * settings.filter_hz * kTick);
  const Vec3d v = (input.T_world_device.translation - state.device.pose.translation) / kTick;
  const Vec3d w = rotationBetween(state.device.pose.rotation, input.T_world_device.rotation) / kTick;
  state.device.velocity += a * (v - state.device.velocity);
  state.device.angular += a * (w - state.device.angular);
  state.device.pose = input.T_world_device;
}

// How far the coupling may move a body in this tick: at its current speed, or at the speed it would reach if contact
// held it as in the last tick. If a body comes free and the whole coupling pulls it at once, travel() slows it for that
// tick.
double wayOfBody(const State& state, const CouplingSettings& coupling, double reach_mm) {
  constexpr double kUnlimited = 1e9;  // mm
  ToolBody free = state.body;
  advance(free, state.device, ContactSums{}, state.last_force, coupling, reach_mm, kUnlimited, kTick);
  return kTick * std::max(free.velocity.norm() + reach_mm * free.angular.norm(),
                          state.body.velocity.norm() + reach_mm * state.body.angular.norm());
}

// Divides the tick so that no part of the motion is longer than motion.longest_mm.
void divideTick(const StepSettings& settings, Motion& motion, StepOutput& output) {
  motion.evaluations = static_cast<int>(std::min(std::ceil(motion.length_mm / motion.longest_mm), 1e6));
  motion.evaluations = std::max(motion.evaluations, 1);
  if (motion.evaluations > settings.most_substeps) {
    // A machine follows its path to the end, in steps as short as necessary.
    if (settings.rendering != Rendering::kRigid) motion.evaluations = settings.most_substeps;
    output.status |= kStepTooFast;
  }
  motion.dt = kTick / motion.evaluations;
  output.substeps = motion.evaluations;
}

// Phase 2.
Motion followDevice(const Model& model, State& state, const DeviceSample& input, StepOutput& output) {
  const StepSettings& settings = model.settings;
  const ToolModel& tool = model.tools[state.tool];
  const double reach = tool.cut.reach();
  Motion motion;
  motion.attachment = settings.attachment();
  motion.tool_before = state.body.pose;
  motion.coupling = settings.coupling.at(std::abs(state.speed) > kAtRest * tool.drive.speed);

  const bool is_first = !state.has_device;  // at the start, and when the device is back after a fault
  const Rigid3 device_before = is_first ? input.T_world_device : state.device.pose;
  filterDevice(state, input, motion.coupling);
  state.ramp = settings.ramp_s > 0 ? std::min(1.0, state.ramp + kTick / settings.ramp_s) : 1;

  motion.longest_mm = 0.5 * tool.finest_mm;
  for (const CutObject& object : state.objects)
    motion.longest_mm = std::min(motion.longest_mm, longestSubstep(tool, object.voxel()));

  switch (motion.attachment) {
    case Attachment::kFixed:
      if (is_first) {  // the tool is at the device: no sweep on the way there
        state.body.pose = state.device.pose;
        wakeAll(state);
      } else {
        motion.length_mm = wayBetween(motion.tool_before, state.device.pose, reach);
      }
      break;
    case Attachment::kBody:
      motion.length_mm = wayOfBody(state, motion.coupling, reach);
      break;
    case Attachment::kProxy:
      motion.length_mm = wayBetween(device_before, state.device.pose, reach);
      break;
  }

  divideTick(settings, motion, output);
  return motion;
}

// Moves a tool that is fixed to the device to the end of part n (from 0) of the motion.
void moveWithDevice(const ToolModel& tool, State& state, const Motion& motion, int n) {
  const Rigid3 last = state.body.pose;
  Rigid3 pose = state.device.pose;
  if (n + 1 < motion.evaluations) {
    const double s = static_cast<double>(n + 1) / motion.evaluations;
    const Rigid3& from = motion.tool_before;
    pose = {from.rotation.slerp(s, state.device.pose.rotation),
            from.translation + s * (state.device.pose.translation - from.translation)};
  }
  state.body.velocity = (pose.translation - last.translation) / motion.dt;
  state.body.angular = rotationBetween(last.rotation, pose.rotation) / motion.dt;
  state.body.pose = pose;

  const double moved = wayBetween(last, pose, tool.reach_mm);
  for (CutObject& object : state.objects) object.odometer += moved;
}

// Phase 3, once: part n (from 0) of the motion.
ContactEvaluation evaluateContact(const Model& model, State& state, const DeviceSample& input, const Motion& motion,
                                  int n) {
  if (motion.attachment == Attachment::kFixed) moveWithDevice(model.tools[state.tool], state, motion, n);
  const Substep substep{motion.dt, motion.longest_mm, motion.length_mm / motion.evaluations, motion.coupling};
  if (state.adds != Material::kNone) return evaluateAdding(model, state, substep, input.pedal != 0);
  return rowOf(model.settings.effectiveResponse()).evaluate(model, state, substep);
}

// Forces, loads and power are means over the tick; volumes and counts are sums; area and depth the largest.
void addTo(StepOutput& output, const ContactEvaluation& contact, double share) {
  const ContactSums& sums = contact.sums;
  output.contact.force += share * contact.contact.force;
  output.contact.torque += share * contact.contact.torque;
  output.normal_load += share * sums.normal_load;
  output.cutting_load += share * sums.cutting_load;
  output.drive_load += share * sums.drive_load;
  output.power += share * sums.power;

  output.area = std::max(output.area, sums.area);
  output.deepest = std::max(output.deepest, sums.deepest);
  if (sums.touching > 0) output.material = static_cast<Material>(sums.material);
  output.tested += sums.tested;
  output.touching += sums.touching;
  output.objects_touched |= contact.objects_touched;

  output.removed_mm3 += contact.removed_mm3;
  output.added_mm3 += contact.added_mm3;
  output.bricks_near += contact.bricks_near;
  output.bricks_cut += contact.bricks_cut;
  output.status |= contact.status;
}

// Phase 4.
void runDrive(const Model& model, State& state, const DeviceSample& input, StepOutput& output) {
  const ToolDrive& drive = model.tools[state.tool].drive;
  const double pedal = state.adds != Material::kNone ? 0 : input.pedal;
  const double load = drive.stall_load > 0 ? output.drive_load / drive.stall_load : 0;
  state.speed = speedAfterTick(drive, state.speed, pedal, load);
  output.speed = state.speed;
}

// Wrench for the hand, before fade-in and limits.
// @param coupling  of this tick: it moved the tool.
// @param is_free  nothing holds the tool: a proxy is at the hand's target, and makes no force, not even from rounding.
Wrench wrenchOnHand(const StepSettings& settings, const CouplingSettings& coupling, const State& state,
                    const Wrench& contact, bool is_free) {
  const bool is_proxy = settings.attachment() == Attachment::kProxy;
  if (is_proxy && is_free) return {};

  switch (settings.rendering) {
    case Rendering::kCoupled:
      return couplingWrench(state.body, state.device, coupling);
    case Rendering::kDirect: {
      if (!is_proxy) return contact;
      CouplingSettings undamped = coupling;
      undamped.damping = undamped.turn_damping = 0;
      return couplingWrench(state.body, state.device, undamped);
    }
    case Rendering::kRigid:
      break;
  }
  return {};
}

// Phase 5.
// @param coupling  of this tick.
void renderToHand(const StepSettings& settings, const CouplingSettings& coupling, State& state, bool is_free,
                  StepOutput& output) {
  Wrench wanted = wrenchOnHand(settings, coupling, state, output.contact, is_free);
  wanted.force *= state.ramp;
  wanted.torque *= state.ramp;

  output.force = clamped(wanted, state.last_force, coupling, kTick);
  if ((output.force.force - wanted.force).norm() > 1e-9 || (output.force.torque - wanted.torque).norm() > 1e-9)
    output.status |= kStepForceClamped;
  state.last_force = output.force;
  output.T_world_tool = state.body.pose;
}

template <class AState, class HashOfObject>
std::uint64_t hashOf(AState& state, const HashOfObject& hash_of_object) {
  std::uint64_t h = 0x6b657266;
  const auto mix = [&h](std::uint64_t v) {
    h = (h ^ v) * 0x9e3779b97f4a7c15ull;
    h ^= h >> 29;
  };
  for (auto& object : state.objects) mix(hash_of_object(object));
  const auto add = [&](const auto& vector) {
    for (Eigen::Index n = 0; n < vector.size(); ++n) mix(std::bit_cast<std::uint64_t>(double(vector[n])));
  };
  add(state.body.pose.translation);
  add(state.body.pose.rotation.coeffs());
  add(state.body.velocity);
  add(state.body.angular);
  add(state.last_force.force);
  add(state.last_force.torque);
  if (!state.core_drag.isZero()) {
    mix(std::bit_cast<std::uint64_t>(state.core_drag.drag));
    add(state.core_drag.moment);
    add(state.core_drag.second.reshaped());
    if (!state.core_drag.normal.isZero(0)) add(state.core_drag.normal.reshaped());
    for (const auto& object : state.objects) mix(std::bit_cast<std::uint64_t>(object.core_load));
  }
  if (!state.grip.isZero(0)) add(state.grip);
  for (const auto& object : state.objects) {
    if (!(object.cut_area.byShell() > 0)) continue;
    mix(std::bit_cast<std::uint64_t>(object.cut_area.byLedger()));
    mix(std::bit_cast<std::uint64_t>(object.cut_area.byShell()));
  }
  for (std::size_t n = 0; n < state.objects.size(); ++n) {
    if (!state.turns[n].isActiveFor(state.objects[n])) continue;
    ContactTurns turns = state.turns[n];
    turns.forEachNumber([&](double& number) { mix(std::bit_cast<std::uint64_t>(number)); });
  }
  mix(std::bit_cast<std::uint64_t>(state.speed));
  mix(state.tool);
  mix(state.tick);
  if (state.adds != Material::kNone) {
    mix(static_cast<std::uint64_t>(state.adds));
    mix(state.adds_to);
  }
  return h;
}

}  // namespace

bool DeviceSample::isUsable() const {
  return is_valid == 1 && T_world_device.isUsable() && std::abs(pedal) <= 1 && irrigation >= 0 && irrigation <= 1;
}

double longestSubstep(const ToolModel& tool, double voxel) noexcept {
  return std::min(0.5 * tool.finest_mm, std::sqrt(0.4 * voxel * tool.smallest_radius_mm));
}

void State::place(const Rigid3& T_world_tool) noexcept {
  moveTool(T_world_tool);
  speed = 0;
  ramp = 0;
}

void State::moveTool(const Rigid3& T_world_tool) noexcept {
  body = {T_world_tool, Vec3d::Zero(), Vec3d::Zero()};
  device = {T_world_tool, Vec3d::Zero(), Vec3d::Zero()};
  last_force = {};
  has_device = true;
  forgetCore();
  wakeAll(*this);
}

void State::selectTool(std::size_t index) noexcept {
  tool = index;
  speed = 0;
  forgetCore();
  wakeAll(*this);
}

std::uint64_t State::hash() const {
  return hashOf(*this, [](const CutObject& object) { return object.stateHash(); });
}

std::uint64_t State::hashNow() noexcept {
  return hashOf(*this, [](CutObject& object) { return object.hashNow(); });
}

void step(const Model& model, State& state, const DeviceSample& input, StepOutput& output) noexcept {
  const FlushDenormals flush;  // here, so that it computes the same for any caller
  output = StepOutput{};
  if (latchIfUnusable(state, input, output)) {
    ++state.tick;
    return;
  }

  reportFrozen(state, output);
  const Motion motion = followDevice(model, state, input, output);

  bool is_free = true;
  for (int n = 0; n < motion.evaluations; ++n) {
    const ContactEvaluation contact = evaluateContact(model, state, input, motion, n);
    addTo(output, contact, 1.0 / motion.evaluations);
    is_free = contact.is_free;
  }

  runDrive(model, state, input, output);
  renderToHand(model.settings, motion.coupling, state, is_free, output);
  ++state.tick;
}

}  // namespace kerf
