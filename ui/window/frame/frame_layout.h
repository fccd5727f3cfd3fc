// Places of the frame: a docked column at each side, the strip of the steps below, and the area that they leave free.
// All in window units, y downwards.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// The state of the window that a panel belongs to.
enum class Screen {
  kAny,
  kFirst,   ///< nothing is open
  kImport,  ///< a scan before it is prepared
  kCut,
  kReplay
};
Screen screenOf(const Workbench& bench);

struct FrameArea {
  float left = 0, top = 0, right = 0, bottom = 0;
  float width() const { return right - left; }
  float height() const { return bottom - top; }
  float middle() const { return 0.5f * (left + right); }
};

struct FrameLayout {
  FrameArea left, right;   ///< columns; no width: none
  FrameArea strip;         ///< timeline, or the bar of a replay; no height: none
  FrameArea free;          ///< the rest, below the menu
  bool is_single = false;  ///< too narrow for two columns: the right one holds the panels of both
};

/// Wanted widths of the columns, and heights of menu and strip.
struct FrameSizes {
  float width = 0, height = 0, menu = 0, strip = 0;
  float left = 0, right = 0, import = 0;
  float scale = 1;  ///< of type and panels
};

/// Columns get narrower, then become one, before less than 240 units of type size 1 stay free between them.
FrameLayout layoutOf(Screen screen, const FrameSizes& sizes);
/// Of the present frame of Dear ImGui.
FrameLayout frameLayout(const AppContext& context);

/// Handles at the inner edges of the columns. A dragged width is kept in the settings.
void drawColumnEdges(AppContext& context);

/// For a question or a list, before it begins: in the middle of the free area, or of the window if that is too narrow.
/// @param width  wanted.   @param height  wanted; 0: that of the content.
void placeDialog(const AppContext& context, float width, float height = 0);

/// Pixels of the picture that columns, menu and strip cover.
ViewMargins marginsOf(const AppContext& context, double pixels);

}  // namespace kerf
