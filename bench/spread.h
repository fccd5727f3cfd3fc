// How far numbers that should be one and the same lie apart.
#pragma once

#include <algorithm>

namespace kerf::cli {

/// By how many percent a is more than b.
inline double percentOff(double a, double b) { return 100 * (a / b - 1); }

/// The least and the most of some numbers.
struct Spread {
  double least = 1e9, most = 0;
  void add(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
  double percent() const { return percentOff(most, least); }
};

}  // namespace kerf::cli
