// What was said, until it is dismissed: over the picture, beside the panels.
#pragma once

#include <cstddef>

#include "ui/app/app_commands.h"

namespace kerf {

/// Where notices stand, window units.
struct NoticePlace {
  float middle = 0;       ///< of the box, from the left
  float edge = 0;         ///< its upper edge, or its lower one if it stands on the bottom
  bool hangs = true;      ///< from above; else it stands on the bottom
  float width = 0;        ///< at most
  float most_height = 0;  ///< what is longer is scrolled
};

/// What takes the sides of the window.
enum class SidePanels { kNone, kBoth, kImport };

/// Between the panels, never over them: as wide as these leave it, up to 720 units of type size 1. In a window in which
/// they leave less than 128 all of its width.
/// @param menu  height of the menu bar.   @param scale  of type and panels.
NoticePlace noticePlace(float width, float height, float menu, float scale, SidePanels panels);

/// Draws the last three of those from `seen` on, the newest in view. OK raises `seen` past all.
/// @param drawn  how many there were when it was drawn last; this function keeps it.
void drawNotices(AppContext& context, std::size_t& seen, std::size_t& drawn);

}  // namespace kerf
