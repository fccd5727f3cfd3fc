// HID devices that are not there, for the whole system: made by the kernel's uhid, they show up as any that is plugged
// in. Needs /dev/uhid, which is root's unless a rule says otherwise.
//
//   kSpaceMouse   a SpaceMouse Wireless, whose knob goes round, and whose button 1 is pressed now and then
//   kPad          an Xbox pad by Bluetooth, at rest, that says how it is told to shake
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

enum class UhidModel { kSpaceMouse, kPad };

struct UhidReport {
  std::uint64_t sent = 0, received = 0;  ///< reports
  std::vector<std::uint8_t> last;        ///< that it was sent
};

class UhidSimulator {
 public:
  /// @param node  the kernel's, "/dev/uhid"; of tests another file.
  /// Errors: kNotFound, kUnreadable: it is not there or not permitted, with what to do.
  static Expected<std::unique_ptr<UhidSimulator>> start(UhidModel model, const std::string& node = "/dev/uhid");
  /// Unplugs it.
  ~UhidSimulator();
  UhidReport report() const;

 private:
  struct State;
  explicit UhidSimulator(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
