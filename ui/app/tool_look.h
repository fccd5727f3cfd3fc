// What is drawn of a tool, and the table of distances by which tissue near it is tinted and darkened.
#pragma once

#include <functional>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf {

struct Tool;

/// Tool frame, mm.
struct ToolLook {
  Mesh mesh;                         ///< closed pieces: toolMesh(tool)
  Box3 cutting;                      ///< what of it cuts: tool.cut->bounds()
  Vec3d approach = -Vec3d::UnitZ();  ///< unit: tool.plunge_direction
  /// Signed distance to what cuts, mm: tool.cut->distance(p). Asked 32 768 times by toolTable(); without one, the box.
  std::function<double(const Vec3d&)> distance;
};
ToolLook lookOf(const Tool& tool);

/// Distances to what cuts, in the approach frame: that of the tool turned so that it goes in along -z.
struct ToolTable {
  static constexpr int kSide = 32;      ///< cells along each axis
  static constexpr double kMargin = 1;  ///< mm around what cuts

  Eigen::Matrix3d approach_from_tool = Eigen::Matrix3d::Identity();  ///< a rotation
  Box3 cutting;                                                      ///< what cuts
  Box3 box;                                                          ///< of the table
  bool is_round = false;                                             ///< as wide along x as along y, within 2 %
  std::vector<float> distances;                                      ///< mm, at the middles of cells; x first, then y
};
/// @pre  the mesh of `look` is not empty.   @cost  a few ms.
ToolTable toolTable(const ToolLook& look);

}  // namespace kerf
