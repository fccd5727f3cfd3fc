// The panel of saw plans: planes, steppers, guide, 'cut this plane now' with its progress; and the hint while a plane
// is picked in the view.
#pragma once

#include <cstdint>
#include <string>

#include "ui/app/app_commands.h"

namespace kerf {

/// What the panel remembers between two frames.
struct SawPanelState {
  std::string name;           ///< being typed, of the chosen plane
  std::uint64_t version = 0;  ///< of the plan when it was taken over
};

/// Runs commands; errors become notices. Drawn when something is open.
void drawSawPanel(AppContext& context, SawPanelState& state);

}  // namespace kerf
