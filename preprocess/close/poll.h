// Polls for cancellation from loops with short rounds.
#pragma once

#include <string_view>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"

namespace kerf::internal {

/// One per step of a job. The reported fraction does not move, because the length of such loops is unknown.
class Poll {
 public:
  Poll(const Progress& progress, double fraction, std::string_view what)
      : progress_(progress), fraction_(fraction), what_(what) {}
  /// True once the job is cancelled. Asks at every 32nd call, which keeps exact arithmetic within about 10 ms.
  bool stop() {
    if (!stopped_ && ++calls_ % 32 == 0) stopped_ = !report(progress_, fraction_, what_);
    return stopped_;
  }
  bool stopped() const { return stopped_; }

 private:
  const Progress& progress_;
  double fraction_;
  std::string_view what_;
  unsigned calls_ = 0;
  bool stopped_ = false;
};

}  // namespace kerf::internal
