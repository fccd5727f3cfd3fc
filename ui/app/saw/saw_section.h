// Section of a planned plane: its bone, the passes that saw it, and the sawn share.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/field/brick_field.h"
#include "geometry/tool/saw_blade.h"
#include "geometry/tool/tool.h"
#include "ui/app/saw/saw_plan.h"

namespace kerf {

/// Bounds of a rectangle.
struct FitOptions {
  /// Limits, mm from the point along across, of a drawn line. Sections beside each other on the line count, as both
  /// sides of an arch, if the blade spans them; else the nearest one.
  std::optional<std::array<double, 2>> across = {};
  bool limits = true;           ///< false: `across` only says which sections count, and they count whole
  bool keeps_approach = false;  ///< false: it turns within its plane where the blade reaches too little
};

/// Bounds a plane to the bone nearest to its point, in one connected section or those on a line, and to the reach of
/// the blade. The rectangle then begins 0.5 mm outside the bone and ends 1 mm behind it.
/// @param bone  distances, mm, negative inside; the case's frame.
/// Error kEmpty: no bone of the plane within 8 mm of the point.   @cost  50 ms.
Expected<SawPlane> fitToBone(SawPlane plane, const BrickField& bone, const SawBlade& blade, FitOptions options = {});

/// Part of the object's section that a planned cut passes.
struct SawCoverage {
  double share = 1;  ///< of the sections that the rectangle meets, within it and the reach of the blade; 1 without bone
  int sections = 0;  ///< connected sections of the whole plane
  int sections_met = 0;  ///< of them: those that the rectangle meets
  bool passesThrough() const { return share >= 0.995; }
};
/// Within 70 mm of the rectangle.   @cost  50 ms.
SawCoverage coverageOf(const SawPlane& plane, const BrickField& bone, const SawBlade& blade);

/// True if the handpiece of a blade held at its end points towards -across: away from the middle of the bone, to stay
/// outside the jaw.
bool isTurned(const SawPlane& plane, const SawBlade& blade, const Box3& bone);

/// One path of the teeth down into the bone. Coordinates of SawPlane: u across, v along the approach, mm.
struct SawPass {
  double u = 0;             ///< of the blade's front
  double from = 0, to = 0;  ///< v of the front: just above the bone, and at its end
};

/// The adjacent passes that saw a plane. Columns without bone have none. Empty: no bone to saw.
std::vector<SawPass> passesOf(const SawPlane& plane, const BrickField& bone, const SawBlade& blade, bool is_turned);

/// Sawn part of the bone in a plane, cell by cell.
class SawnSection {
 public:
  static constexpr double kCell = 0.25;  ///< mm

  SawnSection(const SawPlane& plane, const BrickField& bone, const Tool& tool, const SawBlade& blade);

  /// Marks a pose of the tool. Poses a few tenths of a mm apart leave no cell out.   @cost  some 10 µs.
  void mark(const Rigid3& T_world_tool);
  /// Sawn share of the bone in the rectangle, 0 to 1; 1 without bone.
  double share() const;
  /// Bone in the rectangle. Edge cells count in part: whole ones would be 7 % too many for 5 x 4 mm.
  double plannedMm2() const { return kCell * kCell * area_; }
  /// Bone sawn in the plane, but outside the rectangle.
  double beyondMm2() const { return kCell * kCell * static_cast<double>(beyond_); }

 private:
  struct Cell {
    Vec3d at;  // world
    double u, v;
    bool is_planned, is_sawn;
  };
  SawPlane plane_;
  SawBlade blade_;
  std::shared_ptr<const ToolShape> teeth_;
  double height_ = 0;  // of the cutting part, along the approach
  std::vector<Cell> cells_;
  std::size_t planned_ = 0, sawn_ = 0, beyond_ = 0;
  double area_ = 0;  // planned, in cells
};

}  // namespace kerf
