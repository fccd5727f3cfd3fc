// The light and the dark theme: colours, sizes and fonts of the panels.
#pragma once

#include <imgui.h>

#include "geometry/base/types.h"
#include "ui/app/settings/settings.h"
#include "ui/window/gl/widgets.h"

namespace kerf {

/// Widths of the side panels and of the import panel, before scaled().
inline constexpr float kPanelWidth = 250, kImportPanelWidth = 400;

/// Colours beside those of Dear ImGui's style.
struct StyleColours {
  ImVec4 warning, good, quiet, accent;
  ImVec4 strong, strong_hovered, strong_text;  ///< of a panel's primary button
  ImU32 guide = 0, guide_text = 0;             ///< lines and text over the picture
  Vec3f background_middle, background_edge;    ///< of the picture
};
const StyleColours& styleColours();

/// From window units at scale 1 to the current scale.
float scaled(float units);

/// Call once, and again when the theme or the scale changes.
void applyStyle(Theme theme, float scale);

/// A panel's primary button: filled. @param key  shown behind the label, quiet; may be empty.
/// A given `width` is a minimum.
bool strongButton(const ui::Words& label, const ui::Words& key, float width);
/// A secondary button.
bool plainButton(const ui::Words& label, const ui::Words& key, float width);
/// A quiet heading over a group of controls.
void heading(const ui::Words& text);

}  // namespace kerf
