// Neighbours of the object in work: their fit to its frame, and the tool's distance to them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "sim/monitor/keep_out.h"
#include "sim/run/session/live_run.h"

namespace kerf {

/// Present state of a neighbour.
struct Neighbour {
  std::size_t number = 1;  ///< ObjectReport::loaded; N of `kerf export --beside N`
  std::string name;        ///< "35"
  double removed_mm3 = 0;  ///< from it, in this session
  double before_mm3 = 0;   ///< in the session that this one continues
};

/// Distance from the tool to a neighbour.
struct NearNeighbour {
  std::string name;
  double distance_mm = 0;   ///< to its surface as loaded; negative: the tool is inside
  bool is_far = true;       ///< beyond the measured range: distance_mm is the reach
  bool is_stopped = false;  ///< the stroke stops short of it here
};

/// Distances to the surfaces as loaded, world frame, one per neighbour.
using NeighbourFields = std::vector<std::shared_ptr<const KeepOut>>;

/// @cost  0.7 s for a molar at 0.1 mm, some seconds for a jaw; up to 200 MB each.   Errors: kCancelled.
Expected<NeighbourFields> neighbourFields(const LiveRun& run, const Progress& progress = {});

/// Warning about a neighbour that is hardly of the same scan: it is far away, differs in size, or lies inside the
/// object. None: it fits.
/// @param object  field as loaded, and `box` of its solid.   @param solid  of the neighbour.
/// @cost  some ms.
std::optional<std::string> misfitOf(const BrickField& object, const Box3& box, const std::string& name,
                                    const Mesh& solid);

}  // namespace kerf
