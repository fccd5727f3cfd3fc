// A simulated HID arm for tests: mass, damping, friction and encoders of a DeviceHand, moved by Kerf's forces, at the
// other end of the system's hidapi.
//
// Its time advances in steps of a millisecond, each at least as long in real time. A busy machine slows the arm down,
// but does not affect measurements in its time.
#pragma once

#include <algorithm>

#include "sim/device/arm/raw_arm.h"
#include "sim/hand/virtual_hand.h"
#include "tests/support/hid_testbed.h"

namespace kerf::test {

class SimulatedArm {
 public:
  /// @param path  of the hand that holds it, mm from its start.
  SimulatedArm(HidTestbed& bed, CutPath path, const DeviceHand::Options& hand, int node = 0)
      : bed_(bed), node_(node), path_(std::move(path)), hand_(path_, hand) {
    place_ = poseAt(path_, 0).translation;
    say(place_);
  }
  /// Advances a millisecond: reads the written force, moves, and reports its place. False: the path is over.
  bool step() {
    hear();
    ++ticks_since_word_;
    if (ticks_since_word_ > deadline_) force_.setZero();
    most_force_ = std::max(most_force_, force_.norm());
    ticks_with_force_ = force_.isZero(0) ? 0 : ticks_with_force_ + 1;

    StepOutput last;
    last.force.force = force_;
    DeviceSample sample;
    const bool goes_on = hand_.next(last, sample);
    if (goes_on) place_ = sample.T_world_device.translation;
    say(place_);
    return goes_on;
  }
  /// Reads the written force and reports its place, without advancing the time of its hand.
  void answer() {
    hear();
    say(place_);
  }
  /// N at its tip, device frame.
  const Vec3d& force() const { return force_; }
  double mostForce() const { return most_force_; }
  /// Current number of consecutive steps with a force.
  int ticksWithForce() const { return ticks_with_force_; }
  /// Energy given to the hand so far, N mm.
  double energy() const { return hand_.portEnergy(); }
  /// Displacement of the tip from its start, mm.
  const Vec3d& position() const { return hand_.position(); }

 private:
  void hear() {
    for (const Bytes& report : bed_.takeWritten(node_)) {
      ForceFrame frame;
      if (report.size() != 1 + kRawArmSize) continue;
      if (decodeRawForce(std::span(report).subspan(1), frame) != FrameFault::kNone) continue;
      ticks_since_word_ = 0;
      deadline_ = static_cast<int>(frame.deadline_ms);
      force_ = frame.is_enabled ? frame.force : Vec3d(Vec3d::Zero());
    }
  }
  void say(const Vec3d& place) {
    ++number_;
    HandFrame hand;
    hand.number = number_;
    hand.pose.translation = place;
    hand.most_force = 8;
    const RawArmReport report = encodeRawHand(hand);
    bed_.stream(node_, Bytes(report.begin(), report.end()));
  }

  HidTestbed& bed_;
  const int node_;
  const CutPath path_;
  DeviceHand hand_;
  Vec3d force_ = Vec3d::Zero(), place_ = Vec3d::Zero();
  double most_force_ = 0;
  int deadline_ = 0, ticks_since_word_ = 1 << 20, ticks_with_force_ = 0;
  std::uint32_t number_ = 0;
};

}  // namespace kerf::test
