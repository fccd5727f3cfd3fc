// The SpaceMouse of the window: looked for while the program runs, opened, and found again when it was unplugged.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "ui/app/battery.h"
#include "ui/app/space_mouse_map.h"

namespace kerf {

/// Whether a driver of SpaceMouse devices knows these ids of USB.
bool isSpaceMouse(std::uint16_t vendor, std::uint16_t product);

/// One thread, the window's. A thread of its own lists devices once a second as long as there is none.
class SpaceMouseLink {
 public:
  /// @param name  path or serial number; empty: the only one. Several without a name: none, and news() says so.
  explicit SpaceMouseLink(std::string name = {});
  ~SpaceMouseLink();
  SpaceMouseLink(const SpaceMouseLink&) = delete;
  SpaceMouseLink& operator=(const SpaceMouseLink&) = delete;

  /// Its newest state; none: no device is open.
  std::optional<SpaceMouseState> read();
  /// What has changed since the last call, a sentence for a notice: it was found, is gone, or may not be opened.
  std::optional<std::string> news();
  /// Of the one that was read last; empty: there is none.
  std::string name() const;
  /// What it has told of its battery, if it has one.
  std::optional<Battery> battery() const;
  /// What is wrong with one that is there but does not open; empty: nothing.
  std::string trouble() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
