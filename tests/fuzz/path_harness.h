// Harness of both kinds of path files.
#pragma once

#include <cmath>

#include "sim/hand/path.h"
#include "tests/fuzz/file_harness.h"

namespace kerf::fuzz {

inline void readPathBytes(const ScratchFile& file, const std::uint8_t* data, std::size_t size) {
  file.fill(data, size);
  const Expected<CutPath> path = readPath(file.path());
  if (!path) {
    requireError(path.error());
    return;
  }
  require(path->poses.size() >= 2 && path->cuts.size() + 1 == path->poses.size(), "a motion between any two poses");
  double t = -HUGE_VAL;
  for (const PathPose& pose : path->poses) {
    require(std::isfinite(pose.t) && pose.t >= t, "times are finite and do not decrease");
    t = pose.t;
    require(pose.T_object_tool.translation.allFinite(), "tips are finite");
    require(std::abs(pose.T_object_tool.rotation.norm() - 1) < 1e-6, "rotations are unit quaternions");
  }
}

}  // namespace kerf::fuzz
