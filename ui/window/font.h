// The type of the panels: which font, and which characters it has.
#pragma once

#include <imgui.h>

#include <span>

namespace kerf {

/// Ranges of characters that panels can write, first and last of each: names of files and pieces are a person's.
std::span<const ImWchar> writtenCharacters();

/// Adds the panels' font to an atlas.   @param pixels  its height.
/// @return  false: none of the fonts is installed; Dear ImGui then writes with its own, which has Latin letters alone.
bool addFont(ImFontAtlas& atlas, float pixels);

}  // namespace kerf
