// The force-feedback arm of the window. It leads the tool while its hand is present, and gives force while it is armed.
//
//   --device, device.open ──▶ waits ──hand for 0.3 s──▶ leads ──gone for 1 s──▶ waits       the mouse leads meanwhile
//   device.arm ──▶ armed ──device.disarm, gone, another session, close──▶ not armed         force only while it leads
//
// Opening a session fixes its coupling for the open arm. An arm with lower limits gives no force until the session is
// reopened (device.fit).
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "geometry/base/error.h"
#include "sim/device/arm/force_arm.h"
#include "sim/hand/device_profile.h"
#include "sim/hand/hand_switch.h"

namespace kerf {

class LiveRun;
struct HapticReport;

/// User settings of the arm.
struct ArmChoice {
  double most_force = 3;                 ///< N; the device's own limit also applies
  double scale = 1;                      ///< scene mm per hand mm
  double turn_deg = 0;                   ///< rotation of the device about the scene's z axis
  bool pedal_is_down = false;            ///< the drive runs without button 1
  std::optional<DeviceProfile> profile;  ///< its delay is the device's alone; none: the default

  static constexpr double kLeastForce = 0.1, kMostForce = 20, kLeastScale = 0.05, kMostScale = 5;
};

/// State for the panel and for scripts.
struct ArmView {
  std::string what;         ///< "bridge, port 4417 of this machine"
  std::string missing;      ///< why it does not lead or give force, and the remedy; empty: no obstacle
  bool is_there = false;    ///< the newest hand is less than 20 ms old
  bool is_leading = false;  ///< the tool follows it
  bool is_armed = false;    ///< the user has armed it
  HandFrame hand;           ///< newest
  ArmFelt felt;             ///< newest; only while it leads
  ArmCounts counts;
  double age_p50_ms = 0, age_p99_ms = 0, age_p999_ms = 0;  ///< from the arrival of a hand to the force in response
  /// Box of all hand positions since the hand appeared, device frame, mm.
  Box3 reached;
  double scale = 1;       ///< scene mm per device mm
  double most_force = 0;  ///< N, the lowest limit in force
};

/// Window thread only.
class ArmLead {
 public:
  ArmLead() = default;
  ~ArmLead();
  ArmLead(const ArmLead&) = delete;
  ArmLead& operator=(const ArmLead&) = delete;

  /// @param name  "bridge", "bridge:PORT", "udp:PORT"; path or serial number of a force-feedback device.
  /// Errors: kBadValue for an unknown name; errors of opening.
  Expected<void> open(const std::string& name);
  /// Ends the force and closes the device.
  void close();
  bool isOpen() const { return arm_ != nullptr; }
  const std::string& name() const { return name_; }
  ForceArm* arm() const { return arm_.get(); }

  const ArmChoice& choice() const { return choice_; }
  /// Applies at once. If the coupling of the session exceeds the new force limit, the guard bounds the force.
  void choose(const ArmChoice& choice);
  /// Drive while the pedal is down: speed, -1 to 1 of the nominal speed, and spray, 0 to 1.
  void drive(double speed, double irrigation);
  /// Stops leading while the window is hidden or waits for an answer.
  void pause(bool is_paused) { is_paused_ = is_paused; }

  /// Coupling within the limits of the arm, for a new session. None if no arm is open.
  std::optional<CouplingSettings> coupling() const;
  /// Enables force, faded in, while the arm leads. Errors: kUnsupported with the reason.
  Expected<void> armForce();
  void disarmForce();
  bool isArmed() const { return arm_ && arm_->isEnabled(); }
  /// Errors: kUnsupported: not armed, or the tool touches something; kBadValue: more than ForceArm::kMostTestForce.
  Expected<void> testForce(const Vec3d& newtons);

  // ---- A session

  void opened(LiveRun& run, std::shared_ptr<HandSwitch> hands);
  /// Call before the session goes to its writer.
  void closing();
  bool isLeading() const { return is_leading_; }

  /// Call once a frame, after taking the report.
  /// @param may_lead  nothing else holds the tool, and the user sees it.
  /// @return  notices for the user; `wants_go_on`: the session is latched and may continue.
  struct News {
    std::vector<std::string> notices;
    bool wants_go_on = false;
    bool wants_tool = false;  ///< it starts to lead: hand it the tool
  };
  News update(const HapticReport& report, bool may_lead);

  ArmView view() const;

 private:
  using Clock = std::chrono::steady_clock;
  bool hasJustCome() const;
  std::string missingForForce() const;
  ArmSettings settings() const;
  void letGo();
  void stopLeading();
  void forgetHand();
  void openAnew();

  using Kept = std::pair<std::shared_ptr<HandSwitch>, std::shared_ptr<ForceArm>>;
  std::vector<Kept> kept_;  // arms that a haptic thread may still call, with the calling switch
  std::string name_;
  std::shared_ptr<ForceArm> arm_;
  ArmChoice choice_;
  double speed_ = 1, irrigation_ = 1;
  LiveRun* run_ = nullptr;
  std::shared_ptr<HandSwitch> hands_;
  bool is_leading_ = false, was_there_ = false, has_told_of_fault_ = false, is_paused_ = false;
  Clock::time_point there_since_{}, gone_since_{}, next_try_{};
  bool is_touching_ = false;
  Box3 reached_;
};

}  // namespace kerf
