// Notices over the picture, beside the columns. Information fades; an error stays until the user dismisses it.
#pragma once

#include <cstddef>
#include <vector>

#include "ui/window/frame/frame_layout.h"

namespace kerf {

/// Place of the notices, window units.
struct NoticePlace {
  float middle = 0;       ///< of the box, from the left
  float edge = 0;         ///< upper edge of the box; lower edge if it stands on the bottom
  bool hangs = true;      ///< hangs from above; else stands on the bottom
  float width = 0;        ///< at most
  float most_height = 0;  ///< longer text scrolls
};

/// In the free area: as wide as it allows, up to 720 units of type size 1, and over the upper part of the object at
/// most.   @param scale  of type and panels.
NoticePlace noticePlace(const FrameArea& free, bool hangs, float scale);

/// Notices in view, by their index in the list.
struct NoticesState {
  struct Shown {
    std::size_t index = 0;
    double until = 0;  ///< time of Dear ImGui; infinite: an error
  };
  std::vector<Shown> shown;
  std::size_t seen = 0;  ///< number of notices at the last draw
  bool hasError(const std::vector<Notice>& notices) const;
};
inline constexpr double kNoticeSeconds = 8;

/// Draws the last three. OK dismisses all. An error said again is shown once.
void drawNotices(AppContext& context, NoticesState& state);

}  // namespace kerf
