// The tour of a first session, and the windows of the menu Help: keys, messages, and what Kerf is.
#pragma once

#include <cstddef>

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Four steps over the picture until the user has seen or skipped them: view.hints.   @param step  kept between frames.
void drawTour(AppContext& context, std::size_t& step);
/// The choice of the left mouse button's effect.
void drawLeftButton(AppContext& context);
/// Each draws nothing while its switch is off: help.keys, help.messages, help.about.
void drawKeys(AppContext& context);
void drawMessages(AppContext& context);
void drawAbout(AppContext& context);

}  // namespace kerf
