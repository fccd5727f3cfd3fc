// The SpaceMouse of the window: found while the program runs, opened, and reopened after it was unplugged.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "ui/app/base/battery.h"
#include "ui/app/hand/space_mouse_map.h"

namespace kerf {

/// True if a driver of SpaceMouse devices knows these USB ids.
bool isSpaceMouse(std::uint16_t vendor, std::uint16_t product);

/// Window thread only. A background thread lists devices once a second while there is none.
class SpaceMouseLink {
 public:
  /// @param name  path or serial number; empty: the only device. Several without a name: none, reported by news().
  explicit SpaceMouseLink(std::string name = {});
  ~SpaceMouseLink();
  SpaceMouseLink(const SpaceMouseLink&) = delete;
  SpaceMouseLink& operator=(const SpaceMouseLink&) = delete;

  /// Its newest state; none: no device is open.
  std::optional<SpaceMouseState> read();
  /// Change since the last call, as a notice: found, gone, or no permission to open.
  std::optional<std::string> news();
  /// Name of the device last read; empty: none.
  std::string name() const;
  /// Its reported battery state, if it has one.
  std::optional<Battery> battery() const;
  /// Error of a device that is present but does not open; empty: none.
  std::string trouble() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
