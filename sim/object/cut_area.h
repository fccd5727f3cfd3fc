// How much of an object's surface a tool cuts: the areas of the shell's nodes, calibrated with the ledger.
#pragma once

#include <algorithm>

namespace kerf {

/// The load summed over the shell's nodes must match the removed volume in the ledger and follow the tool's faces.
/// Plain node areas fail beside an edge, or at a point thinner than three voxels, for three reasons: `|grad phi|` is
/// not 1 there; outside the tool, level sets go round an edge in an arc, whose normals belong to no face; and a node
/// uses the lever at its own place, up to 1.5 voxels off the surface.
///
/// So only the part of a cut node's area that is on a face counts. Its work uses the lever at the surface, and a
/// blade's node uses the normal of edge or flank. One factor for all nodes corrects the lost arcs and other missing
/// area: recently removed volume over the volume that the areas predict. Adding the removal that the work left unpaid
/// makes the factor follow twice as fast. One per object. Docs: docs/how-it-works/step.md. @rt all of it.
class CutArea {
 public:
  /// Averaging time of both volumes, s. With the unpaid volume the factor follows a change within half of it. Longer is
  /// calmer.
  static constexpr double kTime = 0.3;
  /// While nothing is cut, both volumes decay to 1/e in this time, s: they are gone after half a second.
  static constexpr double kForget = 0.04;

  CutArea() = default;
  /// From the values of byLedger() and byShell(), mm^3.
  CutArea(double by_ledger, double by_shell) noexcept : by_ledger_(by_ledger), by_shell_(by_shell) {}

  /// Factor on the areas of cut nodes, 0.5 to 4; 1 without a recent cut.   @param voxel  mm.
  double scale(double voxel) const noexcept {
    const double few = fewOf(voxel);
    return std::clamp((by_ledger_ + few) / (by_shell_ + few), kLeast, kMost);
  }
  /// How well the cut is known, 0 to 1: 0 without a recent cut.   @param voxel  mm.
  double share(double voxel) const noexcept { return by_shell_ / (by_shell_ + fewOf(voxel)); }

  /// One contact evaluation of dt seconds. Volumes in mm^3.
  /// @param by_ledger  removed by the load of the shell.   @param by_shell  predicted by its areas, unscaled.
  /// @param unpaid  total removal beyond the volume that all work paid for.
  void add(double by_ledger, double by_shell, double unpaid, double dt) noexcept {
    const double kept = 1 - std::min(1.0, dt / kTime);
    by_shell_ = kept * by_shell_ + by_shell;
    by_ledger_ = std::clamp(kept * by_ledger_ + by_ledger + unpaid, kLeast * by_shell_, kMost * by_shell_);
  }
  /// Time without a cut: forgets both volumes.
  void fade(double dt) noexcept {
    const double kept = 1 - std::min(1.0, dt / kForget);
    by_ledger_ *= kept;
    by_shell_ *= kept;
  }

  double byLedger() const noexcept { return by_ledger_; }
  double byShell() const noexcept { return by_shell_; }

 private:
  static constexpr double kLeast = 0.5, kMost = 4;
  // Less than a thirtieth of a voxel is not significant. mm^3
  static double fewOf(double voxel) noexcept { return voxel * voxel * voxel / 30; }

  double by_ledger_ = 0, by_shell_ = 0;  // recent; by_ledger_ includes the unpaid volume
};

}  // namespace kerf
