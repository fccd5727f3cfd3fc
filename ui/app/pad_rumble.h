// The gamepad that drills shakes: the drive as a fine trembling, contact as a heavy one. No GLFW.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "sim/device/rumble_pad.h"
#include "sim/live/haptic_thread.h"

namespace kerf {

/// Which pad GLFW reads: ids of USB.
struct PadId {
  std::uint16_t vendor = 0, product = 0;
  bool operator==(const PadId&) const = default;
};
/// From the GUID that GLFW gives, 32 hexadecimal digits as SDL writes them. None: it has no ids.
std::optional<PadId> padIdOf(const std::string& guid);

/// @param drive_share  speed of the drive, of its free speed, 0 to 1.
Rumble rumbleOf(const HapticReport& report, double drive_share);

/// Opens the pad that is in use when there is something to shake for, and tells it once a frame. One thread, which
/// waits for nothing: another one opens the pad. The end waits for that. A pad that was lost is opened again after a
/// second.
class PadRumble {
 public:
  using Opener = std::function<Expected<std::unique_ptr<RumblePad>>(const PadId& pad)>;

  PadRumble();
  /// @param open  in the place of RumblePad::open(): for tests. Called by a thread of its own.
  explicit PadRumble(Opener open) : open_(std::move(open)) {}

  /// @param pad  in use; none: there is none.   @param wanted  zero: at rest, as when paused or out of focus.
  /// @return  a sentence when a pad that could shake does not; once.
  std::optional<std::string> update(const std::optional<PadId>& pad, const Rumble& wanted);
  /// Why the pad in use does not shake, though it could; empty: nothing is known.
  const std::string& trouble() const noexcept { return trouble_; }

 private:
  using Clock = std::chrono::steady_clock;
  using Opened = Expected<std::unique_ptr<RumblePad>>;
  void change(const std::optional<PadId>& pad);
  void begin();
  void takeOpened();

  Opener open_;
  std::optional<PadId> of_;  // the pad in use
  std::unique_ptr<RumblePad> pad_;
  std::future<Opened> opening_;
  bool has_tried_ = false, is_stale_ = false;  // stale: what is being opened is not in use any more
  Clock::time_point not_before_{};
  std::string trouble_, told_;
};

}  // namespace kerf
