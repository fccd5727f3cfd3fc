// Solids of tool meshes: parts of toolMesh().
#pragma once

#include <vector>

#include "geometry/mesh/mesh.h"
#include "geometry/tool/tool.h"

namespace kerf::internal {

inline constexpr Rgba8 kSteelColor{176, 182, 190, 255}, kCuttingColor{224, 196, 108, 255};

/// A convex polygon in the plane (x, z), in either sense, extruded from y0 to y1 > y0: closed, outward, mm.
Mesh prism(std::vector<Eigen::Vector2d> xz, double y0, double y1, Rgba8 color);
/// A bur or a disc: cutting part and inert part, each closed; chords within `tolerance_mm` of the outline.
Mesh revolvedMesh(const Tool& tool, double tolerance_mm);

}  // namespace kerf::internal
