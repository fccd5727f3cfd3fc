// Detects why a stroke removes nothing.
#pragma once

#include <cstdint>

#include "sim/live/haptic_thread.h"

namespace kerf {

/// Follows the reports of a session; any subset of them suffices. Window thread only.
class Hindrance {
 public:
  /// @param is_cutting  the user wants to cut now.   @param drive_share  drive speed over its free speed.
  void update(const HapticReport& report, bool is_cutting, double drive_share);
  /// Problem and remedy, in English; empty: no hindrance, or too brief.
  const char* text() const;

 private:
  enum class Kind { kNone, kBody, kDrive };
  Kind now() const;

  std::uint64_t tick_ = 0;
  double removed_mm3_ = 0;
  double load_ = 0, on_cutting_part_ = 0;  // N, means over kSmooth
  double drive_ = 0, rate_ = 0;            // of the free speed; mm3/s
  Kind kind_ = Kind::kNone;
  double lasts_s_ = 0;
};

}  // namespace kerf
