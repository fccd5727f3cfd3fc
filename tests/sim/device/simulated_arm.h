// An arm on HID that is not there, for tests: mass, damping, friction and encoders of a DeviceHand, moved by the
// currents or forces that Kerf writes, at the other end of the system's hidapi.
//
// Its time goes by its own steps of a millisecond, each at least as long on the clock: a busy machine makes the arm
// slow, and nothing that is measured in its time worse.
#pragma once

#include <algorithm>
#include <numbers>

#include "sim/device/raw_arm.h"
#include "sim/device/woody_arm.h"
#include "sim/hand/virtual_hand.h"
#include "tests/support/hid_testbed.h"

namespace kerf::test {

class SimulatedArm {
 public:
  enum class Kind { kRaw, kWoody };

  /// @param path  of the hand that holds it, mm from where it begins; a Woody in its home pose.
  SimulatedArm(HidTestbed& bed, Kind kind, CutPath path, const DeviceHand::Options& hand, int node = 0)
      : bed_(bed), kind_(kind), node_(node), path_(std::move(path)), hand_(path_, hand) {
    place_ = poseAt(path_, 0).translation;
    say(place_);
  }
  /// A millisecond: takes what was written, moves, and says where it is. False: the path is over.
  bool step() {
    hear();
    ++ticks_since_word_;
    const int deadline = kind_ == Kind::kRaw ? deadline_ : kWoodyWatchdog;
    if (ticks_since_word_ > deadline) force_.setZero();
    most_force_ = std::max(most_force_, force_.norm());
    ticks_with_force_ = force_.isZero(0) ? 0 : ticks_with_force_ + 1;

    StepOutput last;
    last.force.force = force_;
    DeviceSample sample;
    const bool goes_on = hand_.next(last, sample);
    most_energy_ = std::max(most_energy_, hand_.portEnergy());
    if (goes_on) place_ = sample.T_world_device.translation;
    say(place_);
    return goes_on;
  }
  /// Takes what was written and says where it is, as ever; but no time goes by for its hand.
  void answer() {
    hear();
    say(place_);
  }
  /// N at its tip, device frame.
  const Vec3d& force() const { return force_; }
  double mostForce() const { return most_force_; }
  /// Steps with a force without a break, up to now.
  int ticksWithForce() const { return ticks_with_force_; }
  /// Given to the hand so far at most; in all. N mm.
  double mostEnergy() const { return most_energy_; }
  double energy() const { return hand_.portEnergy(); }
  double work() const { return hand_.work(); }
  /// Of the tip from where it begins, mm.
  const Vec3d& position() const { return hand_.position(); }
  std::uint64_t words() const { return words_; }
  /// Its reports so far.
  std::uint32_t number() const { return number_; }
  static constexpr int kWoodyWatchdog = 500;  // ms, its firmware's own

 private:
  // At home. Its encoders count from there when it is switched on, until it is told what they are to say.
  static constexpr std::array<int, 6> kWoodyHome = {0, 0, 6000, 0, 0, 0};

  void hear() {
    for (const Bytes& report : bed_.takeWritten(node_)) {
      ++words_;
      if (kind_ == Kind::kWoody) {
        ticks_since_word_ = 0;
        if (wordAt(report, 7) == 1)
          for (std::size_t n = 0; n < 3; ++n) zero_[n] = counts_[n] - wordAt(report, 9 + 2 * n);
        force_ = forceOfCurrents(report);
        continue;
      }
      ForceFrame frame;
      if (report.size() != 1 + kRawArmSize) continue;
      if (decodeRawForce(std::span(report).subspan(1), frame) != FrameFault::kNone) continue;
      ticks_since_word_ = 0;
      deadline_ = static_cast<int>(frame.deadline_ms);
      force_ = frame.is_enabled ? frame.force : Vec3d(Vec3d::Zero());
    }
  }
  static int wordAt(const Bytes& report, std::size_t at) {
    return static_cast<std::int16_t>(report[at] | (report[at + 1] << 8));
  }
  // What currents do: torque = kt current, and a torque is J^T of a force.
  Vec3d forceOfCurrents(const Bytes& report) const {
    Vec3d torque;
    for (int n = 0; n < 3; ++n) {
      const int current = wordAt(report, 1 + 2 * static_cast<std::size_t>(n));
      torque[n] = current * model_.newton_mm_per_ampere / 1000;
    }
    return woodyPose(model_, counts_).jacobian.transpose().inverse() * torque;
  }
  // The counts of the encoders at a place: whole ones, the nearest.
  void turnTo(const Vec3d& place) {
    const Vec3d wanted = woodyPose(model_, kWoodyHome).position + place;
    for (int round = 0; round < 4; ++round) {
      const WoodyPose now = woodyPose(model_, counts_);
      const Vec3d radians = now.jacobian.inverse() * (wanted - now.position);
      for (std::size_t n = 0; n < 3; ++n)
        counts_[n] += static_cast<int>(
            std::lround(radians[static_cast<int>(n)] * model_.counts_per_turn[n] / (2 * std::numbers::pi)));
    }
  }
  void say(const Vec3d& place) {
    ++number_;
    if (kind_ == Kind::kRaw) {
      HandFrame hand;
      hand.number = number_;
      hand.pose.translation = place;
      hand.most_force = 8;
      const RawArmReport report = encodeRawHand(hand);
      bed_.stream(node_, Bytes(report.begin(), report.end()));
      return;
    }
    turnTo(place);
    Bytes report(14);
    for (std::size_t n = 0; n < 6; ++n) {
      const int said = counts_[n] - zero_[n];
      report[2 * n] = static_cast<std::uint8_t>(said & 255);
      report[2 * n + 1] = static_cast<std::uint8_t>((said >> 8) & 255);
    }
    bed_.stream(node_, report);
  }

  HidTestbed& bed_;
  const Kind kind_;
  const int node_;
  const CutPath path_;
  const WoodyModel model_{};
  DeviceHand hand_;
  Vec3d force_ = Vec3d::Zero(), place_ = Vec3d::Zero();
  std::array<int, 6> counts_ = kWoodyHome, zero_ = kWoodyHome;
  double most_force_ = 0, most_energy_ = 0;
  int deadline_ = 0, ticks_since_word_ = 1 << 20, ticks_with_force_ = 0;
  std::uint64_t words_ = 0;
  std::uint32_t number_ = 0;
};

}  // namespace kerf::test
