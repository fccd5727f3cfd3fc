// Readout of the surface under the cursor: for the panel, for the clipboard, and as a row of a path.
#pragma once

#include <optional>
#include <string>

#include "geometry/base/types.h"
#include "ui/app/view/live_surface.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

struct PointReadout {
  Vec3d point = Vec3d::Zero();         ///< mm, in the frame of the scan; for a piece: where it was loaded
  Vec3d normal = Vec3d::UnitZ();       ///< unit, outward, the same frame
  std::string piece;                   ///< its name; empty: there is only one piece
  std::string tissue;                  ///< half a voxel under the surface; empty: no labels
  std::optional<double> thickness_mm;  ///< along the ray, to its exit from the material
  std::optional<Rigid3> T_scan_tool;   ///< of the tool in hand with its tip at the point
};

/// None: the ray hits nothing.   @cost  as LiveScene::hit().
std::optional<PointReadout> readoutAt(const Workbench& bench, const Ray& ray);

/// The same under a tool that is being led: its present or next contact. Without a thickness.
std::optional<PointReadout> readoutOfTool(const Workbench& bench);

/// "12.340, 5.600, -3.200 mm; normal 0.000, 0.100, 0.995; enamel; 4.52 mm thick along the view".
std::string textOf(const PointReadout& readout);
/// The tool at that point, as `kerf cut` reads it: "t,x,y,z,qw,qx,qy,qz", with t = 0.
std::string pathRowOf(const PointReadout& readout);

}  // namespace kerf
