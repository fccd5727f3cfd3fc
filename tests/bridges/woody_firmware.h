// Model of the encoders in a WoodenHaptics arm's firmware. They count from any value; a command sets them.
#pragma once

#include <array>
#include <memory>
#include <mutex>

#include "tests/support/hid_testbed.h"

namespace kerf::test {

class WoodyFirmware {
 public:
  /// @param node  plugged in.   @param counts  initial value.   @param size  of its reports: 14, of a Teensy 64.
  WoodyFirmware(HidTestbed& bed, int node, const std::array<int, 3>& counts, std::size_t size = 14)
      : state_(std::make_shared<State>()), size_(size) {
    state_->counts = counts;
    bed.listen(node, [state = state_](const Bytes& report) { state->take(report); });
  }
  /// Bytes of the next report.
  Bytes report() const {
    Bytes out(size_);
    const std::lock_guard lock(state_->mutex);
    for (std::size_t n = 0; n < 3; ++n) {
      out[2 * n] = static_cast<std::uint8_t>(state_->counts[n] & 255);
      out[2 * n + 1] = static_cast<std::uint8_t>((state_->counts[n] >> 8) & 255);
    }
    return out;
  }
  void turn(const std::array<int, 3>& by) {
    const std::lock_guard lock(state_->mutex);
    for (std::size_t n = 0; n < 3; ++n) state_->counts[n] += by[n];
  }
  /// Ignores commands that set the encoders.
  void ignoreCalibration(bool is_ignored) {
    const std::lock_guard lock(state_->mutex);
    state_->ignores = is_ignored;
  }

 private:
  struct State {
    // Report number, three currents, the command, set values of three encoders.
    void take(const Bytes& report) {
      const auto word = [&](std::size_t n) {
        return static_cast<std::int16_t>(report[1 + 2 * n] | (report[2 + 2 * n] << 8));
      };
      const std::lock_guard lock(mutex);
      if (ignores || report.size() < 15 || word(3) != 1) return;
      for (std::size_t n = 0; n < 3; ++n) counts[n] = word(4 + n);
    }
    std::mutex mutex;
    std::array<int, 3> counts{};  // guarded by mutex, as the next
    bool ignores = false;
  };
  std::shared_ptr<State> state_;
  const std::size_t size_;
};

}  // namespace kerf::test
