// The font of the panels and its characters.
#pragma once

#include <imgui.h>

namespace kerf {

/// Adds the panels' font to an atlas.   @param pixels  its height.
/// @return  false: none of the fonts is installed; Dear ImGui then uses its own, which has Latin letters alone.
bool addFont(ImFontAtlas& atlas, float pixels);

}  // namespace kerf
