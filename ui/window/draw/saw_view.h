// The saw plan in the picture: planes as slabs, their contours on the surface, picked points.
#pragma once

#include <chrono>
#include <cstdint>

#include "ui/app/view/camera.h"
#include "ui/window/draw/live_overlay.h"

namespace kerf {

class Workbench;

class SawView {
 public:
  /// Once a frame: whether chunks of the surface changed.
  void surfaceChanged(bool has_changed) { is_outdated_ |= has_changed; }
  /// The plan to draw now. Contours are recomputed when the plan or the surface changed; for the surface at most four
  /// times a second.
  LivePlan planOf(const Workbench& bench, const Camera& camera);

 private:
  void findSlabs(const Workbench& bench);

  std::vector<LiveSlab> slabs_;
  std::uint64_t version_ = 0, generation_ = 0;
  std::size_t tool_ = 0;
  bool is_outdated_ = true;
  std::chrono::steady_clock::time_point found_{};
};

}  // namespace kerf
