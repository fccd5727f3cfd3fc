// Watches every motion of a path through an object in one piece for likely mistakes.
#pragma once

#include "sim/run/files/path_findings.h"
#include "sim/run/sweep/tip_exit.h"

namespace kerf::internal {

class PathWatch {
 public:
  explicit PathWatch(const BrickField& loaded) : exit_(loaded) {}

  void moveInAir() {
    endStroke();
    exit_.lift();
  }
  void cut(const Rigid3& from, const Rigid3& to, bool removes) {
    if (!is_cutting_) {
      ++found_.strokes;
      is_cutting_ = true;
      has_removed_ = false;
      exit_.moveTo(from);
    }
    has_removed_ |= removes;
    exit_.moveTo(to);
  }
  PathFindings take() {
    endStroke();
    found_.comes_out_at = exit_.place();
    return std::move(found_);
  }

 private:
  void endStroke() {
    if (is_cutting_ && !has_removed_) found_.idle.push_back(found_.strokes);
    is_cutting_ = false;
  }

  TipExit exit_;
  PathFindings found_;
  bool is_cutting_ = false, has_removed_ = false;
};

}  // namespace kerf::internal
