// Drawing data of a tool, and the distance table that tints and darkens tissue near it.
#pragma once

#include <functional>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf {

struct Tool;

/// Tool frame, mm.
struct ToolLook {
  Mesh mesh;                         ///< closed pieces: toolMesh(tool)
  Box3 cutting;                      ///< cutting part: tool.cut->bounds()
  Vec3d approach = -Vec3d::UnitZ();  ///< unit: tool.plunge_direction
  /// Signed distance to the cutting part, mm: tool.cut->distance(p). toolTable() calls it 32 768 times; if empty: the
  /// box.
  std::function<double(const Vec3d&)> distance;
};
ToolLook lookOf(const Tool& tool);

/// Distances to the cutting part, in the approach frame: the tool frame turned so that the tool goes in along -z.
struct ToolTable {
  static constexpr int kSide = 32;      ///< cells along each axis
  static constexpr double kMargin = 1;  ///< mm around the cutting part

  Eigen::Matrix3d approach_from_tool = Eigen::Matrix3d::Identity();  ///< a rotation
  Box3 cutting;                                                      ///< cutting part
  Box3 box;                                                          ///< of the table
  bool is_round = false;                                             ///< as wide along x as along y, within 2 %
  std::vector<float> distances;                                      ///< mm, at the middles of cells; x first, then y
};
/// @pre  the mesh of `look` is not empty.   @cost  a few ms.
ToolTable toolTable(const ToolLook& look);

}  // namespace kerf
