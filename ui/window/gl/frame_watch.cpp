#include "ui/window/gl/frame_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/strokes.h"

namespace kerf {
namespace {

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(values.size())) - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::string partOf(const Workbench& bench) {
  if (const AnyJob* const job = bench.jobs->running()) {
    const std::string title = job->status().title;
    return title.substr(0, title.find(' '));
  }
  return bench.strokes->isPressed() ? "cutting" : "resting";
}

}  // namespace

void FrameWatch::begin(const Workbench& bench) {
  began_ = Clock::now();
  meshed_ = bench.document->run() ? bench.document->run()->editsDone() : 0;
}

void FrameWatch::end(const Workbench& bench) {
  const Clock::time_point now = Clock::now();
  ms_[partOf(bench)].push_back(std::chrono::duration<double, std::milli>(now - began_).count());
  ++frame_;

  if (bench.document->generation() != generation_) {
    generation_ = bench.document->generation();
    carved_.clear();
    pushed_ = tick_ = 0;
  }
  const HapticReport& report = bench.document->report();
  if (report.counts.edits_pushed > pushed_) carved_.push_back({pushed_ = report.counts.edits_pushed, frame_});
  // For a carve between two frames, the first frame that could show it counts.
  for (; !carved_.empty() && carved_.front().edits <= meshed_; carved_.pop_front())
    lags_.push_back(static_cast<double>(frame_ - carved_.front().frame + 1));

  const bool is_cutting = bench.strokes->isPressed() && !bench.jobs->running();
  if (is_cutting && was_cutting_) {
    cutting_s_ += std::chrono::duration<double>(now - before_).count();
    cutting_ticks_ += report.tick - tick_;
  }
  was_cutting_ = is_cutting;
  tick_ = report.tick;
  before_ = now;
  overruns_ = std::max(overruns_, report.counts.overruns);
}

std::string FrameWatch::summary() const {
  std::string out = "watched {";
  for (const auto& [part, ms] : ms_)
    out += fmt::format("\"{}\": {{\"frames\": {}, \"p50_ms\": {:.1f}, \"p95_ms\": {:.1f}, \"max_ms\": {:.1f}}}, ", part,
                       ms.size(), percentile(ms, 0.5), percentile(ms, 0.95), percentile(ms, 1));
  const double hz = cutting_s_ > 0 ? static_cast<double>(cutting_ticks_) / cutting_s_ : 0;
  out += fmt::format("\"carve_to_picture_frames_p95\": {:g}, \"haptic_hz\": {:.1f}, \"overruns\": {}}}",
                     percentile(lags_, 0.95), hz, overruns_);
  return out;
}

}  // namespace kerf
