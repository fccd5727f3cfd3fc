// How much of an object's surface a tool cuts: the areas of the shell's nodes, measured against the ledger.
#pragma once

#include <algorithm>

namespace kerf {

/// The areas of nodes are short beside an edge and coarse at a point thinner than three voxels (`|grad phi|` is not 1
/// there), while erosion takes the surface there as fast as anywhere. So a load summed over nodes pays for less, or for
/// more, than is removed: 2 to 10 % in the kerf of a saw, up to 1.7 times at points. The ledger knows what was removed.
/// This compares both of late, and corrects the areas of what cuts by the ratio: then work and removal agree, whatever
/// the voxel. One for each object. Docs: docs/how-it-works/step.md. @rt all of it.
class CutArea {
 public:
  /// What both are compared over, s. Shorter follows an edge sooner; longer is calmer.
  static constexpr double kTime = 0.3;

  /// Factor on the areas of nodes that are cut, 0.5 to 2; 1 where nothing was cut of late.   @param voxel  mm.
  double scale(double voxel) const noexcept {
    const double few = kFew * voxel * voxel * voxel;
    return std::clamp((by_ledger_ + few) / (by_shell_ + few), 0.5, 2.0);
  }
  /// One evaluation of contact of dt seconds: what was removed, and what the areas said of it, unscaled, mm^3.
  void add(double by_ledger, double by_shell, double dt) noexcept {
    const double kept = keptAfter(dt);
    by_ledger_ = kept * by_ledger_ + by_ledger;
    by_shell_ = kept * by_shell_ + by_shell;
  }
  /// Time without contact: the ratio goes to 1.
  void fade(double dt) noexcept { by_ledger_ = by_shell_ + keptAfter(dt) * (by_ledger_ - by_shell_); }

  double byLedger() const noexcept { return by_ledger_; }
  double byShell() const noexcept { return by_shell_; }

 private:
  static constexpr double kFew = 0.1;  // voxels: less than that says little

  static double keptAfter(double dt) noexcept { return 1 - std::min(1.0, dt / kTime); }

  double by_ledger_ = 0, by_shell_ = 0;
};

}  // namespace kerf
