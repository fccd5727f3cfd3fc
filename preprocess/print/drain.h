// Drains: round holes through the wall of a hollow model, through which resin leaves its cavities.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/base/round_hole.h"
#include "geometry/boolean/post_op_mesh.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

enum class DrainSide {
  kUnderside,    ///< along the printing direction through the lowest face; where that is not possible, as kNearestWall
  kNearestWall,  ///< the shortest way through the wall
};

inline constexpr std::size_t kMostDrains = 20;  ///< for each cavity

struct DrainOptions {
  double diameter_mm = 3.5;  ///< below 2 mm thick resin stays inside
  /// Per cavity. The second drain lets air in. A cavity too small for so many apart gets fewer, at least one.
  std::size_t count = 2;
  Vec3d build_direction = Vec3d::UnitZ();  ///< from the plate into the model, any length but 0
  DrainSide side = DrainSide::kUnderside;
  /// Places by hand, mm, at most 2 mm from the surface: each makes a drain at its nearest point. Cavities without one
  /// get the drains that Kerf places.
  std::vector<Vec3d> at{};
};

struct Drain {
  RoundHole hole;
  std::size_t cavity = 0;  ///< number in DrainPlan::cavities
  double wall_mm = 0;      ///< thickness of the wall along the axis
  bool is_below = false;   ///< along the printing direction
  bool is_by_hand = false;
};

struct Cavity {
  double volume_mm3 = 0;
  Vec3d lowest = Vec3d::Zero();  ///< along the printing direction, mm
};

struct DrainPlan {
  std::vector<Cavity> cavities;  ///< in the order of their first triangle
  std::vector<Drain> drains;     ///< at least one for each cavity
};

/// Places drains: for each cavity the first at its lowest place, the others as far as possible from those before. A
/// place counts if the hole, with 0.5 mm around it, passes through one wall, into this cavity, and not near another
/// wall. The lowest face of the model is its surface up to 0.5 mm above its lowest point: a base on the plate.
/// @pre  ready to print (checkMesh).   Errors: kEmpty for a mesh without a cavity; kBadValue for options; kGeometry for
/// a cavity without a place, with its volume and lowest point, and for a place by hand without a cavity behind it.
/// @cost  two box trees, and some hundred rays per place tried. @thread any; deterministic.
Expected<DrainPlan> placeDrains(const Mesh& hollow, const DrainOptions& options, const Progress& progress = {});

struct Drained {
  Mesh mesh;                                 ///< float32-representable; source vertices first, coloured
  std::vector<char> is_cut;                  ///< per triangle: on the wall of a drain
  std::vector<char> is_source;               ///< per vertex: a vertex of the hollow model, bit for bit
  std::vector<std::uint32_t> from_triangle;  ///< per triangle: in the hollow model, or kNoSource
  double removed_mm3 = 0;
  std::size_t cavities_before = 0, cavities_left = 0;
};

/// Drills the holes by exact cuts (withHole). Each must open a cavity, or join an open one once more: else an error
/// that names the hole. Guarantees of postOperativeMesh().
/// @param holes  at least one, usable.   Errors: kBadValue, kGeometry, kCancelled.
/// @cost  a withHole() per hole. @thread any; deterministic.
Expected<Drained> drained(const Mesh& hollow, std::span<const RoundHole> holes, const Progress& progress = {},
                          const PostOpOptions& options = {});

}  // namespace kerf
