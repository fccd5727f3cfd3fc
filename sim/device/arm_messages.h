// What a force-feedback arm says, message by message, taken apart as its transport does it: for recordings and what
// replays them. A message is a report of HID, a datagram of a bridge, a line of a serial port, JSON of Haply's service.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "sim/device/device_frame.h"
#include "sim/hand/device_profile.h"

namespace kerf {

enum class ArmNews {
  kHand,     ///< the hand of the arm
  kOther,    ///< something else, as the state of a service that does not tell of its place
  kRefused,  ///< malformed; nothing of it is used
};

/// One thread.
class ArmMessages {
 public:
  /// @param language  id of a driver of arm_driver.h, or "bridge", "serial", "haply". Null: there is no such.
  static std::unique_ptr<ArmMessages> of(std::string_view language);
  ~ArmMessages();

  const char* language() const;
  /// Of the device alone.
  const DeviceProfile& profile() const;
  /// @param came_ns  of a device whose messages have no clock it becomes the time of the hand.
  ArmNews take(std::span<const std::uint8_t> message, std::int64_t came_ns);
  /// The newest; as its transport gives it to ForceArm.
  const HandFrame& hand() const;

 private:
  struct State;
  explicit ArmMessages(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
