// Drivers of force-feedback arms on HID: for which interfaces they are, what their reports mean, how a force is
// written. A driver is one source with one row; the list is in arm_driver.cpp. Functions of their arguments alone. @rt
// safe
//
// In between: HandFrame and ForceFrame (device_frame.h), in the arm's own right-handed frame, mm and N.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "sim/device/device_frame.h"
#include "sim/device/hid_port.h"
#include "sim/hand/device_profile.h"

namespace kerf {

/// What a driver keeps of its arm between two reports.
struct ArmState {
  HandFrame hand;               ///< newest; number and time_ns are kept by the driver
  std::array<int, 6> counts{};  ///< of its encoders
  /// mm of the tip for a radian of each motor: column n of motor n. What turns a force into torques.
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
};

inline constexpr std::size_t kLongestArmReport = 65;  ///< bytes that are written, the report's number first
using ArmReportBytes = std::array<std::uint8_t, kLongestArmReport>;

struct ArmDriver {
  const char* id;         ///< "woody"
  const char* people;     ///< what it is for, for people
  DeviceProfile profile;  ///< of the device alone
  /// Its firmware goes on with the last force for longer than 20 ms: a guard takes it away when Kerf is killed.
  bool keeps_force;
  /// Its encoders do not say where it is: no force since it was opened, until it was calibrated.
  bool needs_calibration;
  /// Name of the device for people; null: the driver is not for it.
  const char* (&nameOf)(const HidInfo& info);
  /// Takes over what a report says. @param report  as HidPort::read() gives it.
  /// @return  anything but kNone: it is refused, `state` is as it was.
  FrameFault (&take)(std::span<const std::uint8_t> report, ArmState& state) noexcept;
  /// The report that gives this force, at the place of `state`; a frame that is not enabled: no force.
  /// @param info  of the interface: lengths differ.   @return  how many bytes are to be written.
  std::size_t (&write)(const ForceFrame& force, const ArmState& state, const HidInfo& info,
                       ArmReportBytes& out) noexcept;
  /// The report that says: this is the home pose. 0: there is none, it needs no calibration.
  std::size_t (&calibrate)(const HidInfo& info, ArmReportBytes& out) noexcept;
  /// What its encoders say is its home pose, but for what a hand that holds it there trembles: it took calibrate().
  bool (&isAtHome)(const ArmState& state) noexcept;
};

std::span<const ArmDriver* const> armDrivers();
/// Null: nobody's.
const ArmDriver* armDriverOf(const HidInfo& info);

}  // namespace kerf
