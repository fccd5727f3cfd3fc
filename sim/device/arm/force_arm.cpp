#include "sim/device/arm/force_arm.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/device/hid/device_driver.h"

namespace kerf {
namespace {

constexpr std::int64_t kNsOfMs = 1'000'000;  // ns
constexpr std::int64_t kDeadManNs = 20 * kNsOfMs;
static_assert(kDeadManNs == static_cast<std::int64_t>(1e9 * ForceArm::kDeadMan));
constexpr double kJump = 5;  // mm from frame to frame: not a hand, the device was repositioned
constexpr std::uint32_t kPedal = 1, kClutch = 2;
constexpr std::uint64_t kAgesEvery = 100;
constexpr double kTorqueRate = 20;  // of the most torque, 1/s: all of it within 50 ms

}  // namespace

ForceFrame ArmLink::answer(const Hand& newest, std::int64_t now) noexcept {
  wishes.update();
  const Wish& wish = wishes.front();
  const bool has_news = wish.written_ns != 0 && newest.came_ns != 0 && newest.frame.is_ready;
  const std::int64_t left_ms = (kDeadManNs - (now - std::min(wish.written_ns, newest.came_ns))) / kNsOfMs;

  ForceFrame out;
  out.hand_number = wish.hand_number;
  out.hand_time_ns = wish.hand_time_ns;
  out.is_enabled = has_news && left_ms >= 1 && wish.is_enabled && may_give_force.load(std::memory_order_acquire);
  if (!out.is_enabled) return out;
  out.deadline_ms = static_cast<std::uint32_t>(left_ms);
  out.force = wish.force;
  out.torque = wish.torque;
  return out;
}

ForceArm::ForceArm(const ArmSettings& settings, const Rigid3& start)
    : now_(settings), guard_(settings.limits), map_(settings.map) {
  sample_.T_world_device = start;
  sample_.pedal = 0;
}

bool ForceArm::lastHand(HandFrame& out) const {
  const std::lock_guard lock(told_mutex_);
  if (told_.came_ns == 0) return false;
  out = told_.frame;
  return true;
}

void ForceArm::publish(const ArmLink::Hand& hand) {
  link_.hands.back() = hand;
  link_.hands.publish();
  const std::lock_guard lock(told_mutex_);
  told_ = hand;
}

void ForceArm::set(const ArmSettings& settings) noexcept {
  settings_.back() = settings;
  settings_.publish();
}

void ForceArm::testForce(const Vec3d& force) noexcept {
  Test& test = tests_.back();
  test.number = ++tests_asked_;
  const double size = force.norm();
  test.force = size > kMostTestForce ? Vec3d(force * (kMostTestForce / size)) : force;
  tests_.publish();
}

// ---- The haptic thread

bool ForceArm::isUsable(const ArmLink::Hand& hand, std::int64_t now) const noexcept {
  return is_armed_ && hand.came_ns != 0 && now - hand.came_ns <= kDeadManNs && hand.frame.is_ready;
}

// After another turn or scale the tool stays, and the hand moves it from there.
void ForceArm::takeSettings() noexcept {
  if (!settings_.update()) return;
  const bool is_alike = now_.map.isAlike(settings_.front().map);
  now_ = settings_.front();
  if (is_alike) return;
  map_ = now_.map;
  has_met_ = false;
}

DeviceSample ForceArm::read() noexcept {
  takeSettings();
  link_.hands.update();
  const ArmLink::Hand& newest = link_.hands.front();
  const std::int64_t now = deviceClock();
  felt_now_.is_valid = isUsable(newest, now);

  // After a stall of this thread the device has no force. It fades in again, however far the hand went meanwhile.
  if (wrote_ != 0 && now - wrote_ > kDeadManNs) {
    guard_.disarm();
    torque_guard_.disarm();
  }
  if (!felt_now_.is_valid) {
    guard_.disarm();
    torque_guard_.disarm();
    has_met_ = false;
    sample_.is_valid = 0;
    sample_.pedal = 0;
    return sample_;
  }

  // A new hand, one that leapt, one that holds the clutch: it takes the tool at the tool's place.
  const bool has_leapt = has_met_ && (newest.frame.pose.translation - hand_.pose.translation).norm() > kJump;
  const bool is_clutched = newest.frame.buttons & kClutch;
  hand_ = newest.frame;
  hand_came_ = newest.came_ns;
  if (!hand_.senses_orientation) hand_.pose.rotation.setIdentity();
  if (!has_met_ || has_leapt || is_clutched || is_clutched_) map_.meet(hand_.pose, sample_.T_world_device);
  if (has_leapt || is_clutched) guard_.disarm();
  has_met_ = true;
  is_clutched_ = is_clutched;

  ForceLimits limits = now_.limits;
  limits.force = std::min(limits.force, hand_.most_force);
  guard_.limit(limits);
  if (!isEnabled()) {
    guard_.disarm();
    guard_.forgetFault();
    torque_guard_.forgetFault();
  } else if (!is_clutched && !has_leapt && !guard_.hasFault()) {
    guard_.arm();
  }
  guardTorque();

  sample_.is_valid = 1;
  sample_.T_world_device = map_.toWorld(hand_.pose);
  sample_.pedal = now_.pedal_is_down || (hand_.buttons & kPedal) ? now_.speed : 0;
  sample_.irrigation = now_.irrigation;
  return sample_;
}

// Armed with the force, or not at all.
void ForceArm::guardTorque() noexcept {
  const bool gives = hand_.gives_torque && hand_.senses_orientation && hand_.most_torque > 0;
  if (!gives || !guard_.isArmed()) return torque_guard_.disarm();
  torque_guard_.limit({hand_.most_torque, kTorqueRate * hand_.most_torque, now_.limits.ramp_s});
  torque_guard_.arm();
}

// Swells and fades: a half sine squared.
Vec3d ForceArm::testNow() noexcept {
  if (tests_.update() && tests_.front().number != test_) {
    test_ = tests_.front().number;
    test_force_ = tests_.front().force;
    test_left_ = kTestSeconds;
  }
  if (test_left_ <= 0) return Vec3d::Zero();
  const double rises = std::sin(std::numbers::pi * test_left_ / kTestSeconds);
  test_left_ -= kTick;
  return rises * rises * test_force_;
}

void ForceArm::write(const DeviceForce& force) noexcept {
  const Vec3d wanted = map_.toDevice(force.force) + testNow();
  if (!guard_.isArmed()) test_left_ = 0;  // a test does not wait for a person to arm
  ArmLink::Wish& wish = link_.wishes.back();
  wish.force = guard_.pass(wanted, kTick);
  wish.torque = torque_guard_.pass(map_.toDevice(force.torque), kTick);
  if (torque_guard_.hasFault()) guard_.fail();
  if (!guard_.isArmed()) {
    torque_guard_.disarm();
    wish.force.setZero();
    wish.torque.setZero();
  }
  wish.is_enabled = guard_.isArmed();
  wish.written_ns = deviceClock();
  wish.hand_number = hand_.number;
  wish.hand_time_ns = hand_.time_ns;

  wrote_ = wish.written_ns;
  const std::int64_t age = wish.written_ns - hand_came_;
  felt_now_.force = wish.force;
  felt_now_.torque = wish.torque;
  felt_now_.wanted = wanted.norm();
  felt_now_.age_ms = 1e-6 * static_cast<double>(age);
  felt_now_.ramp = guard_.ramp();
  felt_now_.is_armed = guard_.isArmed();
  felt_now_.is_clamped = guard_.isClamped();
  felt_now_.has_fault = guard_.hasFault();
  felt_now_.is_clutched = is_clutched_;
  felt_now_.pedal = sample_.pedal;
  link_.wishes.publish();
  felt_.back() = felt_now_;
  felt_.publish();

  if (!felt_now_.is_valid) return;
  ages_now_.add(age);
  if (ages_now_.count() % kAgesEvery != 0) return;
  ages_.back() = ages_now_;
  ages_.publish();
}

void ForceArm::placed(const Rigid3& T_world_tool) noexcept {
  sample_.T_world_device = T_world_tool;
  has_met_ = false;
  guard_.disarm();
  torque_guard_.disarm();
}

void ForceArm::disarm() noexcept {
  is_armed_ = false;
  guard_.disarm();
  torque_guard_.disarm();
  write({});
}

}  // namespace kerf
