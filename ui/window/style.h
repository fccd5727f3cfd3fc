// Colours, sizes and type of the panels.
#pragma once

#include <imgui.h>

#include "geometry/base/types.h"
#include "ui/app/settings.h"
#include "ui/window/widgets.h"

namespace kerf {

/// Of the panels at the sides, before scaled().
inline constexpr float kPanelWidth = 250;

/// Beside those of Dear ImGui's own style.
struct StyleColours {
  ImVec4 warning, good, quiet, accent;
  ImVec4 strong, strong_hovered, strong_text;  ///< of the one button that goes on
  ImU32 guide = 0, guide_text = 0;             ///< lines and words over the picture
  Vec3f background_middle, background_edge;    ///< of the picture
};
const StyleColours& styleColours();

/// Window units at a scale of 1 to those of now.
float scaled(float units);

/// Once, and again when the theme or the scale changes.
void applyStyle(Theme theme, float scale);

/// The one button of a panel that goes on: filled. @param key  is written behind the label, quiet; may be empty.
/// A width that is given is one at least.
bool strongButton(const ui::Words& label, const ui::Words& key, float width);
/// A button beside it.
bool plainButton(const ui::Words& label, const ui::Words& key, float width);
/// A quiet heading over a group of controls.
void heading(const ui::Words& text);

}  // namespace kerf
