// Measures how the window keeps up: frame times by activity, lag of the picture behind the cut, and punctuality of the
// 1 kHz loop.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "ui/app/workbench/workbench.h"

namespace kerf {

/// Call around each frame. One thread.
class FrameWatch {
 public:
  void begin(const Workbench& bench);  ///< before Workbench::update()
  void end(const Workbench& bench);    ///< after the frame was drawn

  /// One line for people and programs: `watched {"cutting": {"frames": 90, "p50_ms": ..., "p95_ms": ..., "max_ms":
  /// ...}, ..., "carve_to_picture_frames_p95": 2, "haptic_hz": 999.1, "overruns": 3}`. Parts are cutting, resting, and
  /// the first word of a job: opening, exporting, writing.
  std::string summary() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Carved {
    std::uint64_t edits = 0;  // edits pushed so far
    std::uint64_t frame = 0;  // frame that first knew of them
  };

  std::map<std::string, std::vector<double>> ms_;  // by activity
  std::vector<double> lags_;                       // frames from a carve to the picture that shows it
  std::deque<Carved> carved_;                      // not in a picture yet
  Clock::time_point began_, before_;
  std::uint64_t frame_ = 0, meshed_ = 0, pushed_ = 0, tick_ = 0, generation_ = 0;
  double cutting_s_ = 0;
  std::uint64_t cutting_ticks_ = 0, overruns_ = 0;
  bool was_cutting_ = false;
};

}  // namespace kerf
