// Ways to hold a mesh as a tool: tip, axis and cutting length, guessed from its outline. A cutting end is thin.
#pragma once

#include <string>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf {

/// Middle and extents of a surface, by its area.
struct SurfaceSpread {
  Vec3d middle = Vec3d::Zero();
  Vec3d extents = Vec3d::Zero();   ///< standard deviations along the principal axes, ascending, mm
  Vec3d longest = Vec3d::UnitZ();  ///< unit: direction of the last one
  /// It has a length: the longest extent is clearly longer than the next.
  bool isSlender() const { return extents[2] > 2 * extents[1]; }
};
/// @return  zero extents for a mesh without area.
SurfaceSpread spreadOf(const Mesh& mesh);

/// One way to hold a mesh.
struct ToolWay {
  /// "+z"; "length", "-length": along the longest extent, or against it; "thin-end".
  std::string name;
  Vec3d axis = Vec3d::UnitZ();             ///< from the tip to the shank, unit
  Vec3d tip = Vec3d::Zero();               ///< mm, middle of the part near the end
  double tip_width_mm = 0;                 ///< width of the part within kTipLength of the end
  double cut_below_mm = 4;                 ///< above the tip: cutting length, until it widens clearly; 4 mm at most
  static constexpr double kTipLength = 2;  ///< mm
  /// Another end that is less than so many times as wide may be the tip.
  static constexpr double kDoubt = 1.5;
};

/// The way along an axis: tip, width and cutting length by the mesh's lowest end.
/// @param mesh_mm  at least one triangle; no stray vertices.   @param axis  unit.
ToolWay toolWayAlong(const Mesh& mesh_mm, const std::string& name, const Vec3d& axis);

/// Six ways along the axes of the file, two along its length, and "thin-end", from the thinnest end that sticks out to
/// any side, if one does. The thinnest tip comes first.
/// @param mesh_mm  at least one triangle; stray vertices do not count.
std::vector<ToolWay> toolWays(const Mesh& mesh_mm);

/// Drops vertices without a triangle: they may lie anywhere.
Mesh withoutStrayVertices(const Mesh& mesh);

}  // namespace kerf
