// How much of an object's surface a tool cuts: the areas of the shell's nodes, measured against the ledger.
#pragma once

#include <algorithm>

namespace kerf {

/// A load summed over the nodes of the shell must pay for what is removed, which the ledger knows, and point where the
/// tool's faces do. By their plain areas it does neither beside an edge or at a point thinner than three voxels: there
/// `|grad phi|` is not 1; levels of the field outside the tool go round an edge in an arc, whose normals belong to no
/// face; and a node works with the lever of where it is, up to 1.5 voxels off the surface that it stands for.
///
/// So of a node that is cut only the part of its area that is on a face counts, its work has the lever of the surface,
/// a blade's node the normal of its edge or flank. What is lost with the arcs, and whatever else the areas are short
/// of, is put right by one factor for all: this compares what was removed of late with what those areas say. What all
/// work left unpaid is added: it follows twice as fast. One an object. Docs: docs/how-it-works/step.md. @rt all of it.
class CutArea {
 public:
  /// What both are compared over, s. By what is unpaid a change is followed within half of it. Longer is calmer.
  static constexpr double kTime = 0.3;
  /// While nothing is cut an e-th is left after that, s: nothing is known any more after half a second.
  static constexpr double kForget = 0.04;

  CutArea() = default;
  /// As byLedger() and byShell() said, mm^3.
  CutArea(double by_ledger, double by_shell) noexcept : by_ledger_(by_ledger), by_shell_(by_shell) {}

  /// Factor on the areas of nodes that are cut, 0.5 to 4; 1 where nothing was cut of late.   @param voxel  mm.
  double scale(double voxel) const noexcept {
    const double few = fewOf(voxel);
    return std::clamp((by_ledger_ + few) / (by_shell_ + few), kLeast, kMost);
  }
  /// How far anything is known of what is cut, 0 to 1: 0 where nothing was cut of late.   @param voxel  mm.
  double share(double voxel) const noexcept { return by_shell_ / (by_shell_ + fewOf(voxel)); }

  /// One evaluation of contact of dt seconds, in mm^3: what was removed by the load of the shell; what its areas said
  /// of it, unscaled; and what was removed in all beyond what all work paid for.
  void add(double by_ledger, double by_shell, double unpaid, double dt) noexcept {
    const double kept = 1 - std::min(1.0, dt / kTime);
    by_shell_ = kept * by_shell_ + by_shell;
    by_ledger_ = std::clamp(kept * by_ledger_ + by_ledger + unpaid, kLeast * by_shell_, kMost * by_shell_);
  }
  /// Time in which nothing is cut: what was known is forgotten.
  void fade(double dt) noexcept {
    const double kept = 1 - std::min(1.0, dt / kForget);
    by_ledger_ *= kept;
    by_shell_ *= kept;
  }

  double byLedger() const noexcept { return by_ledger_; }
  double byShell() const noexcept { return by_shell_; }

 private:
  static constexpr double kLeast = 0.5, kMost = 4;
  // Less than a thirtieth of a voxel says little. mm^3
  static double fewOf(double voxel) noexcept { return voxel * voxel * voxel / 30; }

  double by_ledger_ = 0, by_shell_ = 0;  // of late; the first with what was unpaid
};

}  // namespace kerf
