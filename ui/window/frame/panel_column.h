// The column of panels at the right.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Places of the panels in one frame. If too little of the window is left below the last one, the next begins a column
/// beside it. All end over the timeline, and scroll.
class PanelColumn {
 public:
  explicit PanelColumn(const AppContext& context);

  /// For the next window of Dear ImGui: as wide as a panel, as high as its content if there is room.
  void place();
  /// Call before the end of that window: the next one stands below it.
  void take();

 private:
  float left_, top_, end_;
};

}  // namespace kerf
