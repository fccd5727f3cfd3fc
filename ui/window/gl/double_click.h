// Double clicks by the times of their events: a slow frame loses none.
#pragma once

#include <cmath>
#include <utility>

namespace kerf {

class DoubleClick {
 public:
  static constexpr double kSeconds = 0.4, kApart = 6;  ///< at most between the presses; window units

  /// A third press begins anew.   @param s  time of the event.
  void press(double s, double x, double y) {
    const bool is_second = s - s_ < kSeconds && std::hypot(x - x_, y - y_) < kApart;
    is_double_ |= is_second;
    s_ = is_second ? -kSeconds : s;
    x_ = x;
    y_ = y;
  }
  /// Since the last call.
  bool take() { return std::exchange(is_double_, false); }

 private:
  double s_ = -kSeconds, x_ = 0, y_ = 0;
  bool is_double_ = false;
};

}  // namespace kerf
