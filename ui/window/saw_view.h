// What the window shows of a saw plan: its planes as slabs, where they meet the surface, what is being picked.
#pragma once

#include <chrono>
#include <cstdint>

#include "ui/app/camera.h"
#include "ui/window/live_overlay.h"

namespace kerf {

class Workbench;

class SawView {
 public:
  /// Once a frame: whether chunks of the surface changed.
  void surfaceChanged(bool has_changed) { is_outdated_ |= has_changed; }
  /// What to draw now. Contours are found anew when the plan changed, or the surface: then four times a second at most.
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
