// The panel of planned holes: place, depth, axis, the walls that stay, 'Drill' with its progress; and the hole in the
// picture with its distances from the corner of the model.
#pragma once

#include <array>
#include <optional>

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// State of the panel between two frames.
struct DrillPanelState {
  std::array<char, 48> place{}, depth{};  ///< during input
  std::optional<Vec3d> shown;             ///< entry of the hole that `place` shows
  std::optional<double> shown_depth;
  int focus_in = 0;        ///< frames until the place takes the keys
  bool was_shown = false;  ///< in the last frame
  bool is_typed = false;   ///< the place: the next one is awaited
};

/// Holes are planned or drilled.
bool isDrillPanelNeeded(const AppContext& context);
/// Runs commands; errors become notices.
void drawDrillPanel(AppContext& context, DrillPanelState& state);
/// The hole over the picture. Each frame.   @param pixels  of the picture per window unit.
void drawPlannedHole(AppContext& context, DrillPanelState& state, double pixels);

}  // namespace kerf
