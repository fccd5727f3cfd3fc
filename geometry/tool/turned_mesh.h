// The solid of revolution that a mesh fills while it turns about +z: the solid that a fluted bur cuts.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "geometry/mesh/mesh.h"
#include "geometry/tool/tool_shape.h"

namespace kerf {

/// Every height has one disc or one ring. The outline follows the mesh's radii to 2 um up to a height of 32 mm, beyond
/// to a 16000th of the height. An outline that is convex to 3 um is made convex.
struct TurnedMesh {
  RevolvedProfile outline;                 ///< outer side, closed
  std::vector<RevolvedProfile> hollows;    ///< space on the axis without material, as in a trephine; closed, disjoint
  double volume_mm3 = 0;                   ///< of the solid of revolution
  double mesh_volume_mm3 = 0;              ///< of the mesh
  std::optional<double> second_ring_at{};  ///< height, mm, where the solid has a second ring: the rest is not valid
};

/// The part of a mesh between two heights, turned. Hollows narrower than 0.04 mm are filled: a tip beside the axis.
/// @pre `mesh` is closed, turned outwards, free of self-intersections; mm; low < high by 0.01 mm or more.
/// @cost parallel; 1 s for 2 million triangles. The same bits on any number of threads.
TurnedMesh turnedMesh(const Mesh& mesh, double low, double high);

/// Its distance. Exact without hollows; beside one a lower bound of the size, with an exact zero level.
std::shared_ptr<const ToolShape> shapeOf(const TurnedMesh& turned);

}  // namespace kerf
