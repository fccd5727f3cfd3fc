#include "sim/hand/mouse_hand.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

constexpr double kGives = 70;          // mm/s per N of missing or excess force
constexpr double kSoftly = 0.05;       // mm above the depth where the force begins to fall
constexpr double kAhead = 0.02;        // s: looks ahead by this
constexpr double kSmooth = 0.1;        // of that speed, a tick
constexpr double kFollow = 20;         // 1/s
constexpr double kBrake = 30;          // 1/s: of the way to the depth
constexpr double kMouseLetsGo = 200;   // mm/s, back
constexpr double kSurfaceStep = 0.05;  // mm a tick
constexpr double kRestYields = 2;      // times the force: limit of the finger rest
constexpr double kRestSpeed = 30;      // mm/s: a hand that is faster shakes the tool
constexpr double kAround = 1;          // mm: range of the surface search beyond anchor and pointer
constexpr double kMostAside = 1;       // mm, against forces that push a tool out of its guide
constexpr double kFeeler = 0.05;       // mm ahead, to probe for kept parts
constexpr double kSteepest = 0.15;     // of a slope: along a wall there is no height

// From a height along the axis to the surface, along the line through a place: one step of Newton's method, mm.
double stepToSurface(const BrickField& surface, const Rigid3& to_surface, const Vec3d& axis, const Vec3d& through,
                     double height) noexcept {
  const Vec3d foot = through - axis.dot(through) * axis;
  const double voxel = surface.voxel();

  const double here = surface.sample(to_surface * (foot + height * axis));
  const double before = surface.sample(to_surface * (foot + (height - voxel) * axis));
  const double falls = (before - here) / voxel;
  const bool is_near = std::abs(here) < 0.9 * static_cast<double>(surface.background());
  return is_near && falls > kSteepest ? here / falls : here;
}

// The height of the surface at a place. Along a wall, which has none, the starting height.
double heightAt(const BrickField& surface, const Rigid3& to_surface, const Vec3d& axis, const Vec3d& through,
                double from) noexcept {
  constexpr int kSteps = 8;
  constexpr double kFound = 0.01;  // mm
  double height = from, step = 0;
  for (int n = 0; n < kSteps; ++n) {
    step = stepToSurface(surface, to_surface, axis, through, height);
    height += std::clamp(step, -kAround, kAround);
    if (std::abs(step) < kFound) return height;
  }
  return from;
}

// Stays close to anchor and pointer: excludes a cliff beside the stroke.
double nearStroke(const MouseAim& aim, const Vec3d& axis, double height) noexcept {
  const double anchor = axis.dot(aim.anchor), pointer = axis.dot(aim.pointer);
  return std::clamp(height, std::min(anchor, pointer) - kAround, std::max(anchor, pointer) + kAround);
}

}  // namespace

MouseHand::MouseHand(std::shared_ptr<const BrickField> surface, const Rigid3& start, const CouplingSettings& coupling)
    : surface_(std::move(surface)),
      stiffness_(coupling.stiffness),
      turn_stiffness_(coupling.turn_stiffness),
      early_(coupling.running_damping / coupling.stiffness),
      gain_(1 - std::exp(-2 * std::numbers::pi * coupling.filter_hz * kTick)),
      pose_(start) {}

void MouseHand::aim(const MouseAim& aim) noexcept {
  aims_.back() = aim;
  aims_.publish();
}

void MouseHand::takeNewestAim() noexcept {
  if (!aims_.update()) return;
  aim_ = aims_.front();
  to_surface_ = aim_.T_world_surface.inverse();
}

void MouseHand::placed(const Rigid3& T_world_tool) noexcept {
  takeNewestAim();
  placed_for_ = aim_.stroke;
  pose_ = T_world_tool;
  axis_ = aim_.into;
  reach_ = aim_.reach;
  front_ = aim_.front;
  aside_ = 0;
  held_.setZero();
  tool_ = sent_ = pose_.translation;
  speed_of_sent_.setZero();
  lean_ = {};
  height_ = axis_.dot(aim_.anchor);
  felt_.setZero();
  torque_.setZero();
  left_.reset();
  kept_.reset();
  kept_speed_ = 0;
  speed_ = 0;
}

DeviceSample MouseHand::read() noexcept {
  takeNewestAim();
  const bool is_pressed = aim_.is_pressed && aim_.stroke == placed_for_;

  feelKept(is_pressed);
  if (is_pressed) moveSideways();
  followSurface();
  moveAlong(is_pressed);
  holdAttitude();
  holdAtPlace(is_pressed);
  return send(is_pressed);
}

DeviceSample MouseHand::send(bool is_pressed) noexcept {
  DeviceSample out;
  out.T_world_device = pose_;
  if (isHeldInAttitude()) out.T_world_device.rotation = lean_.of(pose_.rotation);
  out.T_world_device.translation += held_ + aside_ * aim_.guide;
  out.pedal = is_pressed ? aim_.pedal : 0;
  out.irrigation = aim_.irrigation;

  const Vec3d& to = out.T_world_device.translation;
  speed_of_sent_ += gain_ * ((to - sent_) / kTick - speed_of_sent_);
  sent_ = to;
  return out;
}

// A finger rest: stiff sideways. Not with a guide, which is stiff itself, nor for a tilted tool, which goes sideways as
// it goes down.
void MouseHand::holdAtPlace(bool is_pressed) noexcept {
  const Vec3d was = tool_;
  tool_ = sent_ + felt_ / stiffness_ + early_ * speed_of_sent_;  // and early_ times its own speed
  tool_ = (kTick * tool_ + early_ * was) / (kTick + early_);

  Vec3d wanted = Vec3d::Zero();
  if (is_pressed && aim_.guide.isZero(0) && !isTilted()) wanted = -kFirm * (2 * tool_ - was - pose_.translation);
  wanted -= axis_.dot(wanted) * axis_;
  const double most = kRestYields * std::max(kLeast, aim_.force) / stiffness_;
  if (const double size = wanted.norm(); size > most) wanted *= most / size;

  const Vec3d way = wanted - held_;
  held_ += std::min(1.0, kRestSpeed * kTick / std::max(way.norm(), 1e-9)) * way;
}

// Of the tool, moved ahead by this.
std::optional<double> MouseHand::leftToKept(const Vec3d& ahead) const noexcept {
  if (!aim_.samples || aim_.samples->isEmpty()) return {};
  const Rigid3 tool{pose_.rotation, pose_.translation + held_ + felt_ / stiffness_ + ahead};
  std::optional<double> out;
  if (structures_ && !structures_->isEmpty() && aim_.keep >= 0) {
    const KeepOut::Reading nearest = structures_->nearest(*aim_.samples, to_surface_ * tool).reading;
    if (!nearest.is_far) out = nearest.distance - aim_.keep;
  }
  if (aim_.keep_beside < 0) return out;
  for (const auto& field : beside_) {
    const KeepOut::Reading nearest = field->read(*aim_.samples, tool);
    if (nearest.is_far) continue;
    out = std::min(out.value_or(nearest.distance - aim_.keep_beside), nearest.distance - aim_.keep_beside);
  }
  return out;
}

void MouseHand::feelKept(bool is_pressed) noexcept {
  const auto left = is_pressed ? leftToKept(Vec3d::Zero()) : std::nullopt;
  kept_speed_ = left && kept_ ? kept_speed_ + kSmooth * ((*kept_ - *left) / kTick - kept_speed_) : 0;
  kept_ = left;
}

// The direction, square to the axis, in which the tool nears a kept part: unit. Zero: far, or straight ahead.
Vec3d MouseHand::sidewaysToKept() const noexcept {
  constexpr double kLevel = 0.05;  // mm nearer on a mm of the way: less than that is along it
  if (!kept_ || *kept_ > kSideways / kBrake) return Vec3d::Zero();
  Vec3d out = Vec3d::Zero();
  const Vec3d across = axis_.unitOrthogonal(), along = axis_.cross(across);
  for (const Vec3d& way : {across, along}) {
    const double ahead = leftToKept(kFeeler * way).value_or(*kept_);
    const double behind = leftToKept(-kFeeler * way).value_or(*kept_);
    out += (behind - ahead) / (2 * kFeeler) * way;
  }
  const double steep = out.norm();
  return steep > kLevel ? Vec3d(out / steep) : Vec3d(Vec3d::Zero());
}

// A hand at rest still draws the tool towards itself.
void MouseHand::holdBackFromKept(const Vec3d& towards) noexcept {
  if (towards.isZero(0)) return;
  const double ahead = *kept_ - kAhead * std::max(kept_speed_, 0.0);
  const double most = std::max(kLeast, aim_.force) * std::clamp(ahead / kSoftly, 0.0, 1.0);
  const double pull = -felt_.dot(towards);
  if (pull > most) pose_.translation -= std::min((pull - most) / stiffness_, kMouseLetsGo * kTick) * towards;
}

// Offset of the tool's leading point from the hand's target, mm. For a tilted tool turning adds to it: its contact
// point is beside its axis.
Vec3d MouseHand::givesWay() const noexcept {
  Vec3d shift = held_ + felt_ / stiffness_;
  if (!isTilted()) return shift;
  const Vec3d turn = lean_.turn + torque_ / turn_stiffness_;
  shift += turn.cross(front_ + reach_ * axis_);
  return shift;
}

// Where the line through the hand, along the axis, meets the surface as loaded.
void MouseHand::followSurface() noexcept {
  if (!surface_ || surface_->isEmpty()) return;
  const Vec3d& a = axis_;
  const double step = stepToSurface(*surface_, to_surface_, a, front(), height_);
  height_ = nearStroke(aim_, a, height_ + std::clamp(step, -kSurfaceStep, kSurfaceStep));
}

void MouseHand::moveSideways() noexcept {
  const Vec3d to_kept = sidewaysToKept();
  holdBackFromKept(to_kept);

  const Vec3d& a = axis_;
  Vec3d way = aim_.pointer - front();
  if (isTilted()) {
    const double below = a.dot(givesWay() - way) + reach_;
    way += std::clamp(below, 0.0, std::max(aim_.depth, 0.0)) * aim_.slant;
  }
  way -= a.dot(way) * a;
  way -= aim_.guide.dot(way) * aim_.guide;
  const double distance = way.norm();
  if (!(distance > 1e-9)) return;

  const Vec3d direction = way / distance;
  const double against = -felt_.dot(direction);
  const double most = std::max(kLeast, aim_.force);
  const double speed = std::min(kFollow * distance, kSideways * std::clamp(1 - against / most, 0.0, 1.0));
  Vec3d step = std::min(speed * kTick, distance) * direction;

  // Along a kept part the hand keeps its speed; towards it, it slows down.
  const double nears = to_kept.dot(step), may = kept_ ? kTick * kBrake * std::max(*kept_, 0.0) : nears;
  if (nears > may) step -= (nears - may) * to_kept;
  pose_.translation += step;
}

// Holds the tool, not the hand, in a guide's plane, and its attitude like that of a tilted tool.
void MouseHand::holdAttitude() noexcept {
  if (!isHeldInAttitude()) return;
  lean_.against(torque_, turn_stiffness_);
  const double off = aside_ + aim_.guide.dot(held_ + felt_ / stiffness_);
  aside_ = std::clamp(aside_ - ToolLean::kRate * kTick * off, -kMostAside, kMostAside);
}

void MouseHand::moveAlong(bool is_pressed) noexcept {
  const Vec3d& a = axis_;
  const double at = a.dot(pose_.translation);
  const double lifted = height_ - reach_ - kClearance;

  double to = at;
  if (is_pressed) {
    // The tool, not the hand, stops at the depth: the hand is ahead of it by the give of the coupling. On a slope the
    // surface is lower under one than under the other: the higher of the two counts.
    const double felt = -felt_.dot(a);
    double height = height_;
    if (surface_ && !surface_->isEmpty()) {
      const double at_tool = heightAt(*surface_, to_surface_, a, front() + givesWay(), height_);
      height = std::min(height, nearStroke(aim_, a, at_tool));
    }
    const double to_depth = height + std::max(aim_.depth, -kClearance) - reach_ - (at + a.dot(givesWay()));
    const double left = std::min(to_depth, kept_.value_or(to_depth));
    speed_ += kSmooth * ((left_.value_or(left) - left) / kTick - speed_);
    left_ = left;
    const double ahead = left - kAhead * std::max(speed_, 0.0);
    const double wanted = aim_.force * std::clamp(ahead / kSoftly, 0.0, 1.0);
    const double fastest = std::min(kApproach, kBrake * left);
    to += kTick * std::clamp(std::min(kGives * (wanted - felt), fastest), -kMouseLetsGo, kApproach);
  } else if (at > lifted) {
    to = std::max(at - kTick * kApproach, lifted);
  }
  pose_.translation += (to - at) * a;
}

}  // namespace kerf
