// Spread of numbers that should be equal.
#pragma once

#include <algorithm>

namespace kerf::cli {

/// Excess of a over b, percent.
inline double percentOff(double a, double b) { return 100 * (a / b - 1); }

/// Minimum and maximum of some numbers.
struct Spread {
  double least = 1e9, most = 0;
  void add(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
  double percent() const { return percentOff(most, least); }
};

}  // namespace kerf::cli
