// The force-feedback arm of the window: opened by its name, it leads the tool while its hand is there, and gives force
// while a person has armed it.
//
//   --device, device.open ──▶ waits ──hand for 0.3 s──▶ leads ──gone for 1 s──▶ waits       the mouse leads meanwhile
//   device.arm ──▶ armed ──device.disarm, gone, another session, close──▶ not armed         force only while it leads
//
// The coupling of a session is made when it is opened: for the arm that is open then. An arm that can bear less gives
// no force in it until that session is opened anew (device.fit).
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "geometry/base/error.h"
#include "sim/device/force_arm.h"
#include "sim/hand/device_profile.h"
#include "sim/hand/hand_switch.h"

namespace kerf {

class LiveRun;
struct HapticReport;

/// What a person has set about it.
struct ArmChoice {
  double most_force = 3;                 ///< N; never more than the device says it can
  double scale = 1;                      ///< mm of the scene for a mm of the hand
  double turn_deg = 0;                   ///< of the device about the scene's z axis
  bool pedal_is_down = false;            ///< the drive turns without button 1
  std::optional<DeviceProfile> profile;  ///< delay of the device alone; none: the default

  static constexpr double kLeastForce = 0.1, kMostForce = 20, kLeastScale = 0.05, kMostScale = 5;
};

/// For a panel and for scripts.
struct ArmView {
  std::string what;         ///< "bridge, port 4417 of this machine"
  std::string missing;      ///< what keeps it from leading or giving force, with what to do; empty: nothing
  bool is_there = false;    ///< its hand is less than 20 ms old
  bool is_leading = false;  ///< the tool follows it
  bool is_armed = false;    ///< a person has armed it
  HandFrame hand;           ///< newest
  ArmFelt felt;             ///< newest; of an arm that leads
  ArmCounts counts;
  double age_p50_ms = 0, age_p99_ms = 0, age_p999_ms = 0;  ///< from a hand's coming to the force that answers it
  /// Of places of the hand since it came, device frame, mm.
  Box3 reached;
  double scale = 1;       ///< mm of the scene for one of those
  double most_force = 0;  ///< N, of all bounds in force
};

/// One thread, the window's.
class ArmLead {
 public:
  ArmLead() = default;
  ~ArmLead();
  ArmLead(const ArmLead&) = delete;
  ArmLead& operator=(const ArmLead&) = delete;

  /// @param name  "bridge", "bridge:PORT", "udp:PORT"; path or serial number of a force-feedback device.
  /// Errors: kBadValue for a name; those of opening.
  Expected<void> open(const std::string& name);
  /// No force from now on; the device is closed.
  void close();
  bool isOpen() const { return arm_ != nullptr; }
  const std::string& name() const { return name_; }
  ForceArm* arm() const { return arm_.get(); }

  const ArmChoice& choice() const { return choice_; }
  /// Another force, scale or turn: at once. Less than the coupling of the session was made for: the guard bounds it.
  void choose(const ArmChoice& choice);
  /// Of the drive while the pedal is down: speed, -1 to 1 of the nominal one, and spray, 0 to 1.
  void drive(double speed, double irrigation);
  /// The window can not be seen, or asks something: it leads nothing.
  void pause(bool is_paused) { is_paused_ = is_paused; }

  /// For a session that is opened now: a coupling that the arm can bear. None: no arm is open.
  std::optional<CouplingSettings> coupling() const;
  /// Force from now on, faded in, while it leads. Errors: kUnsupported with what is missing.
  Expected<void> armForce();
  void disarmForce();
  bool isArmed() const { return arm_ && arm_->isEnabled(); }
  /// Errors: kUnsupported: not armed, or something is touched; kBadValue: more than ForceArm::kMostTestForce.
  Expected<void> testForce(const Vec3d& newtons);

  // ---- A session

  void opened(LiveRun& run, std::shared_ptr<HandSwitch> hands);
  /// Before the session is handed to who writes it.
  void closing();
  bool isLeading() const { return is_leading_; }

  /// Once a frame, after the report was taken.
  /// @param may_lead  nothing else holds the tool, and the person sees it.
  /// @return  sentences for people; `wants_go_on`: the session is latched, and may go on.
  struct News {
    std::vector<std::string> notices;
    bool wants_go_on = false;
    bool wants_tool = false;  ///< it leads from now on: the tool is to be handed to it
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
  std::vector<Kept> kept_;  // arms that a haptic thread may still call, with who calls them
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
