// The panel of saw plans: planes, steppers, guide, 'cut this plane now' with its progress; and the hint while the user
// picks a plane in the view.
#pragma once

#include <cstdint>
#include <string>

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// State of the panel between two frames.
struct SawPanelState {
  std::string name;           ///< name of the chosen plane, during input
  std::uint64_t version = 0;  ///< version of the plan behind `name`
  float above_cusps = -12;    ///< of the next plane under the cusps, mm
};

/// With an open object.
bool isSawPanelNeeded(const AppContext& context);
/// Runs commands; errors become notices.
void drawSawPanel(AppContext& context, SawPanelState& state);
/// Over the picture, while the user picks.
void drawPickingHint(const AppContext& context);

}  // namespace kerf
