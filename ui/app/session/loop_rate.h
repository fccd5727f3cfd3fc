// Tick rate of the 1 kHz loop: mean of the last second by the wall clock.
//
// The loop's own clock stops while the loop is late, the wall clock does not. Window thread only.
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
  /// Call every frame, even without new ticks.   @param ticks  since its start; a lower count resets the rate.
  void add(std::uint64_t ticks, Clock::time_point now);
  /// Ticks per second, over the last second or a longer last frame. None in the first second.
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
