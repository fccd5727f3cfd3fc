// Outlines drawn in CAD programs: one curve of lines and arcs, from DXF or SVG.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

/// A line or an arc, mm; x to the right, y up.
struct OutlinePiece {
  Eigen::Vector2d from, to;
  /// tan of a quarter of the arc's angle, > 0 counter-clockwise; 0: a line.
  double bulge = 0;
  std::size_t line = 0;  ///< in the file, for errors; 0: unknown

  OutlinePiece reversed() const { return {to, from, -bulge, line}; }
  /// @pre bulge != 0.
  Eigen::Vector2d center() const;
};

/// Reads the one curve of a drawing and joins its pieces end to end, from its lower end to its higher one. Of a closed
/// curve the lines on the axis, x = 0, are left out. The lower end is moved to y = 0.
///   .dxf  ASCII, R12 to 2018: LINE, ARC, LWPOLYLINE, POLYLINE in model space; $INSUNITS, mm without
///   .svg  one path of M L H V A C Z; viewBox, width and height with a unit. C becomes chords within 0.001 mm. y, which
///         points down in SVG, is turned up
/// Errors with file and line: kUnsupported names an entity or element of another kind; kBadFormat; kBadValue for curves
/// that do not join within 0.001 mm; kUnreadable, kNotFound.
Expected<std::vector<OutlinePiece>> readOutline(const std::filesystem::path& file);

namespace internal {

struct MeshSource;
/// Pieces in the order of the file, mm.
Expected<std::vector<OutlinePiece>> readDxf(const MeshSource& source);
Expected<std::vector<OutlinePiece>> readSvg(const MeshSource& source);
inline constexpr std::size_t kMostPieces = 1000;
inline constexpr double kJoint = 0.001;   ///< mm: ends that are nearer are one point
inline constexpr double kFarthest = 1e4;  ///< mm: no coordinate beyond

}  // namespace internal
}  // namespace kerf
