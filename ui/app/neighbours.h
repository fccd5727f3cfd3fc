// What stands beside the object that is worked on: whether it fits the frame, how far the tool is from it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "sim/monitor/keep_out.h"
#include "sim/run/live_run.h"

namespace kerf {

/// A neighbour as it is now.
struct Neighbour {
  std::size_t number = 1;  ///< ObjectReport::loaded; N of `kerf export --beside N`
  std::string name;        ///< "35"
  double removed_mm3 = 0;  ///< off it, in this session
  double before_mm3 = 0;   ///< in the session this one went on from
};

/// A tool beside one.
struct NearNeighbour {
  std::string name;
  double distance_mm = 0;   ///< to its surface as loaded; negative: the tool is in it
  bool is_far = true;       ///< farther than is measured: distance_mm is the reach
  bool is_stopped = false;  ///< the stroke stops short of it, here
};

/// Distances to the surfaces as loaded, world frame, one a neighbour.
using NeighbourFields = std::vector<std::shared_ptr<const KeepOut>>;

/// @cost  0.7 s for a molar at 0.1 mm, some seconds for a jaw; up to 200 MB each.   Errors: kCancelled.
Expected<NeighbourFields> neighbourFields(const LiveRun& run, const Progress& progress = {});

/// What a person should know before they work with a neighbour that hardly is of the same scan: it is far away, of
/// another size, or lies in the object. None: it fits.
/// @param object  field as loaded, and `box` of its solid.   @param solid  of the neighbour.
/// @cost  some ms.
std::optional<std::string> misfitOf(const BrickField& object, const Box3& box, const std::string& name,
                                    const Mesh& solid);

}  // namespace kerf
