// What a planned plane meets: the bone in it, the passes that saw it, and how much of it is sawn.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/field/brick_field.h"
#include "geometry/tool/saw_blade.h"
#include "geometry/tool/tool.h"
#include "ui/app/saw_plan.h"

namespace kerf {

/// How a rectangle is bounded.
struct FitOptions {
  /// Not beyond these, mm from the point along across: a line was drawn.
  std::optional<std::array<double, 2>> across = {};
  bool keeps_approach = false;  ///< else it turns within its plane where the blade reaches too little as it is
};

/// Bounds a plane to the bone that is nearest to its point, in one connected section, and to what the blade reaches.
/// The rectangle then begins 0.5 mm outside the bone and ends 1 mm behind it.
/// @param bone  distances, mm, negative inside; the case's frame.
/// Error kEmpty: no bone of the plane within 8 mm of the point.   @cost  20 ms.
Expected<SawPlane> fitToBone(SawPlane plane, const BrickField& bone, const SawBlade& blade, FitOptions options = {});

/// Whether a blade that is held at its end has its handpiece towards -across: it stays outside the jaw, away from the
/// middle of the bone.
bool isTurned(const SawPlane& plane, const SawBlade& blade, const Box3& bone);

/// One way of the teeth down into the bone. Coordinates of SawPlane: u across, v along the approach, mm.
struct SawPass {
  double u = 0;             ///< of the blade's front
  double from = 0, to = 0;  ///< v of the front: just above the bone, and where it stops
};

/// The passes that saw a plane, beside each other. Columns without bone have none. Empty: there is nothing to saw.
std::vector<SawPass> passesOf(const SawPlane& plane, const BrickField& bone, const SawBlade& blade, bool is_turned);

/// Which part of the bone in a plane the blade has been through, cell by cell.
class SawnSection {
 public:
  static constexpr double kCell = 0.25;  ///< mm

  SawnSection(const SawPlane& plane, const BrickField& bone, const Tool& tool, const SawBlade& blade);

  /// The tool was there. Poses a few tenths of a mm apart leave no cell out.   @cost  some 10 µs.
  void mark(const Rigid3& T_world_tool);
  /// Sawn, of the bone in the rectangle, 0 to 1; 1 where there is none.
  double share() const;
  /// Of the bone in the rectangle. Cells at its edges count in part: whole ones would be 7 % too many for 5 x 4 mm.
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
  double height_ = 0;  // of what cuts, along the approach
  std::vector<Cell> cells_;
  std::size_t planned_ = 0, sawn_ = 0, beyond_ = 0;
  double area_ = 0;  // planned, in cells
};

}  // namespace kerf
