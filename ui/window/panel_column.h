// The panels at the right, one under the other.
#pragma once

#include "ui/app/app_commands.h"

namespace kerf {

/// Where they stand in one frame. Where too little of the window is left below the last one, the next begins a column
/// beside it. All end over the timeline, and scroll.
class PanelColumn {
 public:
  explicit PanelColumn(const AppContext& context);

  /// For the next window of Dear ImGui: as wide as a panel, as high as what is in it if there is room.
  void place();
  /// Before the end of that window: the next one stands below it.
  void take();

 private:
  float left_, top_, end_;
};

}  // namespace kerf
