// A force-feedback arm on HID, by one of the drivers of arm_driver.h. What is done with a hand and a force:
// force_arm.h.
//
//   arm ──report──▶ ┌────────┐ ──newest hand──▶ ForceArm
//   arm ◀─report─── │ thread │ ◀─newest force── ForceArm
//
// One thread for both ways, in lock-step as these arms are: reports are drained to the newest, then the force is
// written, each millisecond. A write that is stuck keeps hands from coming, too: the haptic thread then knows of none
// after 20 ms, and the arm's own watchdog takes the force away.
#pragma once

#include <memory>
#include <string>

#include "sim/device/arm_driver.h"
#include "sim/device/force_arm.h"

namespace kerf {

/// A HID interface that an arm's driver knows.
struct FoundArm {
  const ArmDriver* driver = nullptr;
  std::string name;  ///< of its model, for people
  HidInfo info;
};
std::vector<FoundArm> groupArms(const std::vector<HidInfo>& interfaces);
inline std::vector<FoundArm> findArms() { return groupArms(listHid()); }
/// @param name  path or serial number. Empty: the only one.
/// Errors: kNotFound with what there is; kBadValue: several, and no name, or a serial that two of them have.
Expected<FoundArm> chooseArm(const std::vector<FoundArm>& arms, const std::string& name);

class HidArm final : public ForceArm {
 public:
  /// Errors: those of HidPort::open(); of an arm that keeps its force those of ZeroGuard::start(); kBadValue: no
  /// thread.
  static Expected<std::unique_ptr<HidArm>> open(const FoundArm& found, const ArmSettings& settings,
                                                const Rigid3& start = {}, ArmListener listener = {});
  /// Writes no force.
  ~HidArm() override;

  std::string what() const override;
  ArmCounts counts() const override;
  /// It is taken to have done so once a later report says that its encoders stand at home; after a second without one
  /// counts() says that it did not.
  bool calibrate() override;
  bool isGone() const override;

 private:
  struct State;
  HidArm(const ArmSettings& settings, const Rigid3& start, std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
