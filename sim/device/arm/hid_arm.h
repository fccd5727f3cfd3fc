// A force-feedback arm on HID, by its ArmDriver (device_driver.h). Use of hand and force: force_arm.h.
//
//   arm ──report──▶ ┌────────┐ ──newest hand──▶ ForceArm
//   arm ◀─report─── │ thread │ ◀─newest force── ForceArm
//
// One thread for both ways, in lock-step like these arms: each millisecond it drains reports to the newest, then writes
// the force. A stuck write also stops hands: the haptic thread then sees none after 20 ms, and the deadline of the last
// report ends the force in the arm.
#pragma once

#include <memory>
#include <string>

#include "sim/device/arm/force_arm.h"
#include "sim/device/hid/device_finder.h"

namespace kerf {

class HidArm final : public ForceArm {
 public:
  /// Errors: those of HidPort::open(); kBadValue: no thread.   @pre  found.isArm()
  static Expected<std::unique_ptr<HidArm>> open(const FoundDevice& found, const ArmSettings& settings,
                                                const Rigid3& start = {}, ArmListener listener = {});
  /// Writes a zero force.
  ~HidArm() override;

  std::string what() const override;
  ArmCounts counts() const override;
  bool isGone() const override;

 private:
  struct State;
  HidArm(const ArmSettings& settings, const Rigid3& start, std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
