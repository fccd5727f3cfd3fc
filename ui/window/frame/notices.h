// Notices over the picture, beside the panels, until the user dismisses them.
#pragma once

#include <cstddef>

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Place of the notices, window units.
struct NoticePlace {
  float middle = 0;       ///< of the box, from the left
  float edge = 0;         ///< upper edge of the box; lower edge if it stands on the bottom
  bool hangs = true;      ///< hangs from above; else stands on the bottom
  float width = 0;        ///< at most
  float most_height = 0;  ///< longer text scrolls
};

/// Panels at the sides of the window.
enum class SidePanels { kNone, kBoth, kImport };

/// Between the panels, never over them: as wide as they allow, up to 720 units of type size 1. If they leave less than
/// 128, the full width of the window.
/// @param menu  height of the menu bar.   @param scale  of type and panels.
NoticePlace noticePlace(float width, float height, float menu, float scale, SidePanels panels);

/// Draws the last three notices from `seen` on, the newest in view. OK raises `seen` past all.
/// @param drawn  number of notices at the last draw; this function keeps it.
void drawNotices(AppContext& context, std::size_t& seen, std::size_t& drawn);

}  // namespace kerf
