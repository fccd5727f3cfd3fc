// Paths of the tool: timed poses, or strokes converted to poses.
#pragma once

#include <filesystem>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/types.h"

namespace kerf {

struct PathPose {
  double t = 0;          ///< s, increasing
  Rigid3 T_object_tool;  ///< tool into object frame; the translation is the tip's position, mm
};

struct CutPath {
  std::vector<PathPose> poses;  ///< >= 2
  std::vector<char> cuts;       ///< per motion poses[i] -> poses[i + 1]: 1 cutting, 0 moving in air
};

/// Reads a CSV of timed poses (header exactly `t,x,y,z,qw,qx,qy,qz`) or a TOML of strokes:
/// docs/reference/path-files.md.
///
/// Between poses the tip moves straight and the tool turns by the shorter way. Errors name line and column.
Expected<CutPath> readPath(const std::filesystem::path& file);

}  // namespace kerf
