// Parts of a scan that the user cuts away before closing: inside a line drawn over a view, or beyond a plane.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// A closed line drawn over a view. It cuts through the whole scan, along the line of sight.
struct OutlineTrim {
  std::vector<Vec3d> outline;         ///< mm, 3 to kMostCorners corners
  Vec3d direction = -Vec3d::UnitZ();  ///< unit, of the view, away from the viewer
  std::optional<Vec3d> eye{};         ///< mm, of a perspective view; none: parallel
  bool keeps_inside = false;          ///< false: the inside goes; true: the outside
  bool operator==(const OutlineTrim&) const = default;
};
inline constexpr std::size_t kMostCorners = 10'000;

/// Everything on the side of the normal goes.
struct PlaneTrim {
  Vec3d point = Vec3d::Zero();    ///< mm
  Vec3d normal = Vec3d::UnitZ();  ///< unit
  bool operator==(const PlaneTrim&) const = default;
};

using ScanTrim = std::variant<OutlineTrim, PlaneTrim>;

/// The same trim with the other side removed.
ScanTrim flipped(ScanTrim trim);
/// For a scan read in another unit: all places times `factor`.
ScanTrim scaledBy(ScanTrim trim, double factor);

struct TrimmedScan {
  Mesh mesh;                                   ///< in the scan's unit: remaining triangles and their vertices, in order
  std::vector<std::uint32_t> source_triangle;  ///< per triangle
  std::size_t vertices_removed = 0;            ///< of those that triangles used
  std::size_t triangles_removed = 0;
  double removed_mm2 = 0;
};

/// Removes whole triangles: all that lie on a removed side, wholly or in part. No vertex moves; a comparison with the
/// scan proves it. A triangle with a corner behind the eye lies outside every outline.
/// @param scan  any mesh.   @param scale_to_mm  of its coordinates; trims are in mm.
/// Errors: kBadValue: a bad trim; kEmpty: no triangle would remain.   @cost  O(triangles + those near an outline *
/// corners).
Expected<TrimmedScan> trimScan(const Mesh& scan, std::span<const ScanTrim> trims, double scale_to_mm = 1);

/// Errors: kBadValue for too few or too many corners, a direction without length, a number that is not finite.
Expected<void> checkTrim(const ScanTrim& trim);

/// As [[trim]] tables of a trim file (preprocess/bake/trim_file.h). Equal trims give equal text, and reading it back
/// gives the same bits.
std::string textOf(std::span<const ScanTrim> trims);

}  // namespace kerf
