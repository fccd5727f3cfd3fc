// How often the 1 kHz loop ticks: the mean of the last second, by the clock on the wall.
//
// The loop's own clock stands still while it is late; this one does not. On the window's thread.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace kerf {

class LoopRate {
 public:
  using Clock = std::chrono::steady_clock;

  void clear() { *this = {}; }
  /// Once a frame, whether the loop has ticked or not.   @param ticks  since it began; fewer than before: begins anew.
  void add(std::uint64_t ticks, Clock::time_point now);
  /// Ticks a second; after a frame that took longer, over that. None in the first second.
  std::optional<double> hz() const;

 private:
  struct Moment {
    std::uint64_t ticks = 0;
    Clock::time_point when;
  };
  static constexpr std::size_t kMost = 64;  // 20 ms apart: more than a second

  std::array<Moment, kMost> ring_{};
  std::size_t next_ = 0, count_ = 0;
  Moment last_;
};

}  // namespace kerf
