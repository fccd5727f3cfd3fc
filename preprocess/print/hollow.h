// Hollows a closed solid to a wall thickness, and measures the wall.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

inline constexpr double kLeastWall = 0.3, kMostWall = 20;  ///< mm
/// mm: deviation from the asked wall that WallNumbers counts as within.
inline constexpr double kWallTolerance = 0.05;

struct HollowOptions {
  double wall_mm = 2;
  /// Radius by which the cavity is opened: edges and corners of the cavity become rounds of it, and slots narrower than
  /// twice this radius stay full. In the edges the wall is thicker than asked, by 0.41 times the radius at a right
  /// angle. 0: sharp edges, and slivers.
  double rounding_mm = 0.3;
  /// Node spacing of the distance field: 0 means a twelfth of the wall. At most a quarter of the wall.
  double voxel_mm = 0;
  double least_cavity_mm3 = 30;          ///< drops smaller cavities; a ball of 3.9 mm has 30 mm3
  Rgba8 inner_color{214, 92, 64, 255};   ///< of the cavities' walls, if the source has colours
  std::uint64_t max_bytes = 6ull << 30;  ///< limit of estimateHollowBytes()
};

/// Thickness of the wall: distance from the cavities' walls to the nearest point of the source's surface, exact at
/// every inner vertex and at the middle of every inner triangle. Shares of the inner area.
struct WallNumbers {
  double least_mm = 0;
  Vec3d least_at = Vec3d::Zero();  ///< on the cavity's wall
  double mean_mm = 0, p05_mm = 0, p95_mm = 0;
  double share_within = 0;  ///< within kWallTolerance of HollowOptions::wall_mm
};

struct Hollowed {
  /// The source's vertices and triangles, then those of the cavities. Drops only cavities of the source that a new one
  /// swallows.
  Mesh mesh;
  std::vector<char> is_inner;           ///< per triangle: on the wall of a new cavity
  std::size_t cavities = 0;             ///< new ones
  std::size_t cavities_dropped = 0;     ///< below least_cavity_mm3
  double dropped_mm3 = 0;               ///< their volume, which stays full
  std::size_t shells_swallowed = 0;     ///< closed pieces of the source's surface that lay in a new cavity
  double solid_mm3 = 0, resin_mm3 = 0;  ///< volume before and after
  WallNumbers wall;
  double voxel_mm = 0;
};

/// Estimated peak memory, bytes; accurate to a factor of 2.
std::uint64_t estimateHollowBytes(const Mesh& solid, const HollowOptions& options);

/// The solid minus its morphological opening at depth: all places deeper than wall + rounding, grown by the rounding.
/// Maragos & Schafer, IEEE TASSP 35(8), 1987; PrusaSlicer hollows likewise. Distances to the source's cavities count
/// too. Then moves the vertices onto the exact wall, rounds to float32, verifies and measures.
/// Guarantees on success: closed, 2-manifold, free of self-intersections in float32; the wall is nowhere below
/// wall - voxel / 2; the source's triangles stay bit for bit.
/// @pre  coordinates representable in float32, mm.
/// Errors: kBadValue for options out of range, or too little memory, with a voxel that fits; kGeometry for a solid that
/// is not ready to print, and for a wall that is too thin; kEmpty for a solid too thin for a cavity, with its thickest
/// place and a wall that fits; kCancelled.
/// @cost  two distance fields: about 4.5 ms of one core per mm2 of surface at voxels of 0.15 mm, 1.8 times
/// PrusaSlicer's hollowing of the same mesh. @thread any; parallel inside; deterministic.
Expected<Hollowed> hollow(const Mesh& solid, const HollowOptions& options, const Progress& progress = {});

}  // namespace kerf
