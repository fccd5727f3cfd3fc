// The curve along a row of teeth, and the sides of its teeth: buccal, lingual, mesial, distal.
//
//                front
//               . ─ ─ .            mesial: along the curve to the midline
//            /     ▲     \         distal: along the curve away from it
//           │      │      │        buccal: square to the curve, out of the arch (labial of front teeth)
//           │      │ θ    │        lingual: into the arch (palatal of upper teeth)
//           │    origin   │        occlusal: out of the teeth
#pragma once

#include <optional>
#include <vector>

#include "geometry/mesh/mesh.h"
#include "preprocess/close/occlusal_plane.h"

namespace kerf {

/// The sides of a tooth: directions of the mesh's frame, unit, square to each other. Lingual and distal are the
/// opposites.
struct ToothSides {
  Vec3d occlusal = Vec3d::UnitZ();
  Vec3d buccal = Vec3d::UnitY();
  Vec3d mesial = Vec3d::UnitX();
};

/// A full arch. Its curve lies in the occlusal plane.
struct DentalArch {
  Vec3d origin = Vec3d::Zero();     ///< mm, in the occlusal plane and the midline, level with the hindmost teeth
  Vec3d occlusal = Vec3d::UnitZ();  ///< unit, out of the teeth
  Vec3d front = Vec3d::UnitY();     ///< unit, in the plane, along the midline
  std::vector<Vec3d> curve;         ///< mm, a point a degree about `origin`, from one end to the other
  std::size_t middle = 0;           ///< index of the curve point in the midline

  /// Index of the curve point nearest to `p`, both projected along the occlusal normal.
  std::size_t nearest(const Vec3d& p) const;
  /// The sides of the tooth that stands nearest to a point. Exactly in the midline, which has no mesial side, those of
  /// the tooth to the left as seen from the front with the occlusal side up.   @cost O(curve).
  ToothSides sidesAt(const Vec3d& p) const;
};

/// Finds the curve of a full arch. The surface that faces out of the teeth within 4 mm below and 2 mm above the
/// occlusal plane counts as the row of teeth. The largest gap around its middle, at least 60 degrees, is the back. The
/// midline is the axis in the plane about which the row is most like its mirror image. The curve is a polynomial of
/// degree 6 for the radius over the angle about `origin`, by least squares; it ends 80 degrees from the midline at
/// most.
/// Empty without a full arch: it goes round less than 50 degrees to either side of the midline, or is less than 0.45
/// times as deep as wide (a quadrant, a front, one tooth); more than half of it has no teeth; or the surface there is
/// no row: it scatters about the curve by more than 5 mm rms, or lies in the middle of the arch.
/// @cost one pass and 5 ms. @thread any; deterministic.
std::optional<DentalArch> findDentalArch(const Mesh& mesh_mm, const OcclusalPlane& plane);

}  // namespace kerf
