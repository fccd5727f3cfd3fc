// A removable die from a point on a tooth: planes at its two ends and beside it, a base, and a hole for a pin.
//
//      ╲  tooth  ╱         sides: tapered, wider at the top, so that the die comes out towards the other jaw
//       ╲       ╱          base:  the lower end of the die, square to the occlusal normal
//   ─────╲─────╱─────
//         ╲─┬─╱  base      pin:   from below the underside through the model's base up into the die
//   ────────┴─────────  underside
//
// The ends lie where the row of teeth is thinnest, square to its line. World frame of the object as loaded, mm.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/round_hole.h"
#include "geometry/field/brick_field.h"
#include "ui/app/saw/saw_plan.h"
#include "ui/app/view/upright.h"

namespace kerf {

/// Numbers that the user chooses. Defaults: printed dies have gaps of 0.05 to 0.1 mm, usual pins 2 mm.
struct DieChoice {
  static constexpr double kMostTaper = 15, kMostBase = 50, kMostPin = 6, kMostPinDepth = 40;

  double taper_deg = 3;        ///< of each side
  bool has_four_sides = true;  ///< false: only the ends are cut, the die is as wide as the arch
  double base_mm = 3;          ///< height of the die's base above the underside; 0: the die goes down to it
  double kerf_mm = 0.1;        ///< gap between die and model
  double pin_mm = 2;           ///< diameter; 0: no pin hole
  double pin_depth_mm = 8;     ///< in the die, from its base up
  bool operator==(const DieChoice&) const = default;
};

/// Directions at a tooth, unit, square to each other.
struct DieFrame {
  ToothSides sides;
  bool is_of_arch = false;  ///< false: without a full arch mesial and buccal may be swapped with their opposites
};

struct DiePlan {
  std::vector<SawPlane> planes;  ///< named; normals point into the die; the ends come first
  DieFrame frame;
};

/// Plans the planes of a die.
/// @param at  on the tooth.   @param occlusal  of the solid.   @param bone  distances as loaded.
/// Errors: kGeometry without an occlusal side, or if the base would lie in the crown.   @cost  some 50 ms.
Expected<DiePlan> planDie(const Vec3d& at, const OcclusalSide& occlusal, const Mesh& solid, const BrickField& bone,
                          const DieChoice& choice);

/// The pin hole of a die, whose planes may have been moved since. Its axis goes through the middle of the die's base.
/// @param planes  of the die.   @param occlusal  unit.   @param at  on the tooth.
/// Errors: kGeometry, with the greatest depth, if it comes nearer than 1 mm to a side or a surface of the die.
Expected<RoundHole> pinOf(std::span<const SawPlane> planes, const Vec3d& occlusal, const Vec3d& at,
                          const BrickField& bone, const DieChoice& choice);

}  // namespace kerf
