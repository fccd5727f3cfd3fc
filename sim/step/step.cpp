#include "sim/step/step.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

#include "sim/step/response.h"

namespace kerf {
namespace {

// Denormal numbers cost a hundred times as much as others, at unforeseeable moments. The mode belongs to the step, so
// that it computes the same wherever it is called.
class FlushDenormals {
 public:
#if defined(__SSE2__)
  FlushDenormals() noexcept : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040u); }
  ~FlushDenormals() { _mm_setcsr(before_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned before_;
#endif
};

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
  return is_valid == 1 && T_world_device.translation.allFinite() && T_world_device.rotation.coeffs().allFinite() &&
         std::abs(T_world_device.rotation.norm() - 1) < 1e-6 && T_world_device.translation.norm() < 1e5 && pedal >= 0 &&
         pedal <= 1 && irrigation >= 0 && irrigation <= 1;
}

double longestSubstep(const ToolModel& tool, double voxel) noexcept {
  return std::min(0.5 * tool.finest_mm, std::sqrt(0.4 * voxel * tool.smallest_radius_mm));
}

void State::place(const Rigid3& T_world_tool) noexcept {
  body = {T_world_tool, Vec3d::Zero(), Vec3d::Zero()};
  device = {T_world_tool, Vec3d::Zero(), Vec3d::Zero()};
  last_force = {};
  speed = 0;
  ramp = 0;
  for (CutObject& object : objects) object.wake();
  has_device = true;
}

void State::selectTool(std::size_t index) noexcept {
  tool = index;
  speed = 0;
  for (CutObject& object : objects) object.wake();
}

std::uint64_t State::hash() const {
  return hashOf(*this, [](const CutObject& object) { return object.stateHash(); });
}

std::uint64_t State::hashNow() noexcept {
  return hashOf(*this, [](CutObject& object) { return object.hashNow(); });
}

void step(const Model& model, State& state, const DeviceSample& input, StepOutput& output) noexcept {
  const FlushDenormals flush;
  output = StepOutput{};
  const StepSettings& settings = model.settings;
  if (!input.isUsable()) state.is_latched = true;
  if (state.is_latched) {
    // Zero, and stays zero: a hand that comes back to a pressed tool must not be struck.
    state.last_force = {};
    state.has_device = false;
    state.ramp = 0;
    state.speed = 0;
    state.body.velocity.setZero();
    state.body.angular.setZero();
    output.T_world_tool = state.body.pose;
    output.status = kStepBadSample;
    ++state.tick;
    return;
  }
  const ToolModel& tool = model.tools[state.tool];
  const Rigid3 before = state.body.pose;
  const bool is_first = !state.has_device;  // at the start, and when the device is back after a fault
  const Rigid3 device_before = is_first ? input.T_world_device : state.device.pose;
  filterDevice(state, input, settings.coupling);
  state.ramp = settings.ramp_s > 0 ? std::min(1.0, state.ramp + kTick / settings.ramp_s) : 1;

  double longest = 0.5 * tool.finest_mm;
  for (const CutObject& object : state.objects) {
    longest = std::min(longest, longestSubstep(tool, object.voxel()));
    if (object.isFrozen()) output.status |= kStepFrozen;
  }
  const double reach = tool.cut.reach();
  const bool is_penalty = settings.response == Response::kPenalty || settings.rendering == Rendering::kRigid;
  const bool is_coupled = settings.rendering == Rendering::kCoupled || !is_penalty;  // a body of its own
  const bool is_proxy = !is_penalty && settings.response == Response::kConstraint;
  if (is_first && !is_coupled) {  // it is where the device is: nothing was swept on the way there
    state.body.pose = state.device.pose;
    for (CutObject& object : state.objects) object.wake();
  }

  // How many looks this tick needs: by where the path leads, or by how fast the coupled tool may become.
  double motion = 0;
  if (is_proxy) {
    motion = (state.device.pose.translation - device_before.translation).norm() +
             reach * rotationBetween(device_before.rotation, state.device.pose.rotation).norm();
  } else if (is_coupled) {
    ToolBody free = state.body;
    advance(free, state.device, ContactSums{}, Wrench{}, settings.coupling, reach, 1e9, kTick);
    motion = kTick * std::max(free.velocity.norm() + reach * free.angular.norm(),
                              state.body.velocity.norm() + reach * state.body.angular.norm());
  } else if (!is_first) {
    motion = (state.device.pose.translation - before.translation).norm() +
             reach * rotationBetween(before.rotation, state.device.pose.rotation).norm();
  }
  int substeps = static_cast<int>(std::min(std::ceil(motion / longest), 1e6));
  substeps = std::max(substeps, 1);
  if (substeps > settings.most_substeps) {
    // A machine's path is followed to its end all the same, in steps as short as they must be.
    if (settings.rendering != Rendering::kRigid) substeps = settings.most_substeps;
    output.status |= kStepTooFast;
  }
  const double dt = kTick / substeps;

  const bool is_adding = state.adds != Material::kNone;
  const double wanted_speed = is_adding ? 0 : input.pedal * tool.drive.speed;
  bool is_free = true;  // the proxy, at the last look
  for (int n = 1; n <= substeps; ++n) {
    Rigid3 last = state.body.pose;
    if (!is_coupled) {
      const double s = static_cast<double>(n) / substeps;
      Rigid3 pose = state.device.pose;
      if (n < substeps)
        pose = {before.rotation.slerp(s, state.device.pose.rotation),
                before.translation + s * (state.device.pose.translation - before.translation)};
      state.body.velocity = (pose.translation - last.translation) / dt;
      state.body.angular = rotationBetween(last.rotation, pose.rotation) / dt;
      state.body.pose = pose;
      const double moved = (pose.translation - last.translation).norm() +
                           tool.reach_mm * rotationBetween(last.rotation, pose.rotation).norm();
      for (CutObject& object : state.objects) object.odometer += moved;
    }
    Look look;
    if (is_penalty || is_adding) {
      for (CutObject& object : state.objects) {
        const ContactInput in = contactInput(model, state, object, dt);
        CutResult cut;
        if (!is_adding) {
          if (!state.near.find(object, tool, in.T_object_tool)) look.status |= kStepNearRanOut;
          ContactSums sums;
          sumContact(object, state.near, in, sums);
          if (sums.touching > 0)
            look.objects_touched |= objectBit(static_cast<std::size_t>(&object - state.objects.data()));
          look.sums.add(sums.rotated(object.T_world_object.rotation.toRotationMatrix()));
          cut = erode(object, state.near, in);
          look.bricks_near += static_cast<int>(state.near.size());
        } else if (input.pedal > 0 && &object - state.objects.data() == static_cast<std::ptrdiff_t>(state.adds_to)) {
          const FillResult added = fill(object, in, state.adds);
          output.added_mm3 += added.added_mm3;
          cut.bricks = added.bricks;
          cut.pool_ran_out = added.pool_ran_out;
          if (added.is_clipped) look.status |= kStepFillClipped;
        }
        const bool is_repaired = object.repair();  // also when room ran out: what was cut must be felt
        look.removed_mm3 += cut.removed_mm3;
        look.bricks_cut += cut.bricks;
        if (cut.pool_ran_out || !is_repaired) look.status |= kStepBricksRanOut;
      }
      const Wrench own = ownDrag(tool, state.body.pose, state.speed, look.sums);
      if (is_coupled) {
        advance(state.body, state.device, look.sums, own, settings.coupling, reach, longest, dt);
        const double moved = dt * (state.body.velocity.norm() + tool.reach_mm * state.body.angular.norm()) + 1e-9;
        for (CutObject& object : state.objects) object.odometer += moved;
      }
      Vector6d twist;
      twist.head<3>() = state.body.velocity;
      twist.tail<3>() = state.body.angular;
      const Vector6d feed_drag = look.sums.dragMatrix() * twist;
      look.contact.force = look.sums.force + own.force - feed_drag.head<3>();
      look.contact.torque = look.sums.torque + own.torque - feed_drag.tail<3>();
    } else {
      look = respond(model, state, dt, longest, motion / substeps);
      is_free = look.is_free;
    }
    const double share = 1.0 / substeps;
    const ContactSums& world = look.sums;
    output.contact.force += share * look.contact.force;
    output.contact.torque += share * look.contact.torque;
    output.normal_load += share * world.normal_load;
    output.cutting_load += share * world.cutting_load;
    output.drive_load += share * world.drive_load;
    output.power += share * world.power;
    output.area = std::max(output.area, world.area);
    output.deepest = std::max(output.deepest, world.deepest);
    if (world.touching > 0) output.material = static_cast<Material>(world.material);
    output.tested += world.tested;
    output.touching += world.touching;
    output.objects_touched |= look.objects_touched;
    output.removed_mm3 += look.removed_mm3;
    output.bricks_near += look.bricks_near;
    output.bricks_cut += look.bricks_cut;
    output.status |= look.status;
  }
  output.substeps = substeps;

  // Free speed falls with the load in proportion; the drive follows with its time constant.
  const double sag = tool.drive.stall_load > 0 ? std::max(0.0, 1 - output.drive_load / tool.drive.stall_load) : 1;
  const double follow = tool.drive.time_constant > 0 ? 1 - std::exp(-kTick / tool.drive.time_constant) : 1;
  state.speed += follow * (wanted_speed * sag - state.speed);

  Wrench wanted;
  if (is_proxy) {
    // Where the hand wants it there is no force, not even of rounding.
    CouplingSettings seen = settings.coupling;
    if (settings.rendering == Rendering::kDirect) seen.damping = seen.turn_damping = 0;
    if (!is_free) wanted = couplingWrench(state.body, state.device, seen);
  } else if (settings.rendering == Rendering::kCoupled) {
    wanted = couplingWrench(state.body, state.device, settings.coupling);
  } else if (settings.rendering == Rendering::kDirect) {
    wanted = output.contact;
  }
  wanted.force *= state.ramp;
  wanted.torque *= state.ramp;
  output.force = clamped(wanted, state.last_force, settings.coupling, kTick);
  if ((output.force.force - wanted.force).norm() > 1e-9 || (output.force.torque - wanted.torque).norm() > 1e-9)
    output.status |= kStepForceClamped;
  state.last_force = output.force;
  output.T_world_tool = state.body.pose;
  output.speed = state.speed;
  ++state.tick;
}

}  // namespace kerf
